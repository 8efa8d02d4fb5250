/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/FeedRecord.H"
#include "foam/caseText.H"
#include "foam/foamVersion.H"
#include "IFstream.H"
#include "OFstream.H"
#include "OSspecific.H"
#include "IOdictionary.H"
#include "volFields.H"
#include "Time.H"
#include "SHA1.H"
#include "wordRes.H"

namespace Foam
{

namespace
{

//- What may be changed on the way
const wordHashSet changeable
({
    "drainTime", "duration", "particles", "loading", "massFlowRate"
});

//- Entries of constant/feed itself; others that stand there are macros
const wordHashSet entriesOfFeed
({
    "outlets", "patch", "zone", "start", "particlesPerParcel", "parcels",
    "focus", "velocity", "seed", "materials"
});

//- How contacts are computed, not what they are; and the files' headers
const wordHashSet ignored
({
    "FoamFile", "threads", "treatment", "search", "cellLayers", "step", "stepFraction"
});


struct Change
{
    fileName file;
    string entry;
    string before;
    string now;
};


IOobject header(const fvMesh& mesh, const IOobject::readOption option)
{
    return IOobject
    (
        "feed", mesh.time().timeName(), "uniform", mesh, option,
        IOobject::NO_WRITE, false
    );
}


bool same(const token& a, const token& b)
{
    return
        a.isNumber() && b.isNumber()
      ? mag(a.number() - b.number()) <= 1e-14*mag(a.number())
      : a == b;
}


bool same(const entry& a, const entry& b)
{
    const ITstream& before = a.stream();
    const ITstream& now = b.stream();
    if (before.size() != now.size())
    {
        return false;
    }
    forAll(before, i)
    {
        if (!same(before[i], now[i]))
        {
            return false;
        }
    }
    return true;
}


string valueOf(const entry* e)
{
    if (!e)
    {
        return "absent";
    }
    if (e->isDict())
    {
        return "a dictionary";
    }
    OStringStream text;
    for (const token& t : e->stream())
    {
        text<< (text.str().empty() ? "" : " ") << t;
    }
    return text.str();
}


//- All entries below two dictionaries that differ
void compare
(
    const fileName& file,
    const string& path,
    const dictionary& before,
    const dictionary& now,
    DynamicList<Change>& changes
)
{
    DynamicList<keyType> names;
    for (const entry& e : before)
    {
        names.append(e.keyword());
    }
    for (const entry& e : now)
    {
        if (!before.findEntry(e.keyword(), keyType::LITERAL))
        {
            names.append(e.keyword());
        }
    }
    for (const keyType& name : names)
    {
        const entry* a = before.findEntry(name, keyType::LITERAL);
        const entry* b = now.findEntry(name, keyType::LITERAL);
        if (ignored.found(name))
        {
            continue;
        }
        if (a && b && a->isDict() && b->isDict())
        {
            compare(file, path + name + "/", a->dict(), b->dict(), changes);
        }
        else if (!a || !b || a->isDict() || b->isDict() || !same(*a, *b))
        {
            changes.append({file, path + name, valueOf(a), valueOf(b)});
        }
    }
}


//- Is a change that of an entry which takes its value, such as $loading?
bool isValueOf(const Change& change, const UList<Change>& accepted)
{
    for (const Change& c : accepted)
    {
        if (c.before == change.before && c.now == change.now)
        {
            return true;
        }
    }
    return false;
}


void refuse(const fvMesh& mesh, const Change& change, const string& allowed)
{
    FatalErrorInFunction
        << change.file.c_str() << ": " << change.entry.c_str() << " is "
        << change.now.c_str() << ", but the run came to time "
        << mesh.time().timeName() << " when it was " << change.before.c_str()
        << "; allowed: " << allowed.c_str() << exit(FatalError);
}


//- Names of the files that settings are read from, by folder
const HashTable<wordRes> settingsFiles
({
    {"constant", wordRes({
        wordRe("g"), wordRe("transportProperties"),
        wordRe("turbulenceProperties.*", wordRe::REGEX),
        wordRe(".*CloudProperties", wordRe::REGEX), wordRe("fvOptions")
    })},
    {"system", wordRes({wordRe("simulationParameters"), wordRe("fvOptions")})}
});


//- Those that CASE/folder has
wordList filesIn(const word& folder, const fileName& place)
{
    DynamicList<word> names;
    for (const fileName& file : readDir(place, fileName::FILE, false))
    {
        if (settingsFiles[folder].match(file))
        {
            names.append(file);
        }
    }
    return wordList(names);
}


//- The feed's entries that name a file, with a digest of what stands in it
dictionary namedFiles(const dictionary& feed)
{
    dictionary named;
    for (const entry& e : feed)
    {
        if (e.isDict())
        {
            const dictionary below(namedFiles(e.dict()));
            if (!below.empty())
            {
                named.add(e.keyword(), below);
            }
        }
        else if (e.keyword() == "file")
        {
            const fileName file(fileNameIn(feed, "file"));
            const SHA1 content(caseText(file));
            named.add("file", string(file + " of SHA-1 " + content.digest().str()));
        }
    }
    return named;
}


//- The same of the walls that particles alone meet
dictionary namedSurfaces(const dictionary& cloudProperties)
{
    return namedFiles
    (
        cloudProperties.subOrEmptyDict("subModels")
       .subOrEmptyDict("cellListCoeffs").subOrEmptyDict("surfaces")
    );
}


//- Number of cells, volume, and moments about the origin: others where a mesh
//  was made again in another shape
dictionary shapeOf(const fvMesh& mesh)
{
    const scalarField& V = mesh.V();
    const vectorField& C = mesh.C().primitiveField();
    dictionary shape;
    shape.add("cells", returnReduce(mesh.nCells(), sumOp<label>()));
    shape.add("volume", gSum(V));
    shape.add("firstMoments", gSum(vectorField(V*C)));
    shape.add("secondMoments", gSum(vectorField(V*cmptMultiply(C, C))));
    return shape;
}


//- Of meshes whose sums differ by rounding only
bool sameShape(const dictionary& a, const dictionary& b, const scalar size)
{
    const scalar volume = b.get<scalar>("volume");
    const auto apart = [volume](const vector& one, const vector& other)
    {
        return mag(one - other)/volume;
    };
    return
        a.get<label>("cells") == b.get<label>("cells")
     && mag(a.get<scalar>("volume") - volume) <= 1e-9*volume
     && apart(a.get<vector>("firstMoments"), b.get<vector>("firstMoments"))
     <= 1e-9*size
     && apart(a.get<vector>("secondMoments"), b.get<vector>("secondMoments"))
     <= 1e-9*sqr(size);
}


string told(const dictionary& shape)
{
    OStringStream text;
    text.precision(6);
    text<< shape.get<label>("cells") << " cells, "
        << shape.get<scalar>("volume") << " m3 with the middle at "
        << shape.get<vector>("firstMoments")/shape.get<scalar>("volume");
    return text.str();
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Functions * * * * * * * * * * * * * * * * //

dictionary feedRecord::read(const fvMesh& mesh)
{
    IOobject io(header(mesh, IOobject::MUST_READ));
    return
        returnReduce(io.typeHeaderOk<IOdictionary>(false), andOp<bool>())
      ? dictionary(IOdictionary(io)) : dictionary();
}


void feedRecord::write(const fvMesh& mesh, const dictionary& record)
{
    const IOobject io(header(mesh, IOobject::NO_READ));
    IOdictionary file(io);
    mkDir(io.path());
    OFstream os(io.objectPath());
    os.precision(17);
    file.writeHeader(os);
    record.write(os, false);
    IOobject::writeEndDivider(os);
    if (!os.good())
    {
        FatalErrorInFunction
            << "cannot write " << io.objectPath() << ": is the disk full?"
            << exit(FatalError);
    }
}


void feedRecord::requireSameMesh(const fvMesh& mesh)
{
    const dictionary record(read(mesh));
    if (!record.found("mesh"))
    {
        return;
    }
    const dictionary& before = record.subDict("mesh");
    const dictionary now(shapeOf(mesh));
    const scalar size = mag(mesh.bounds().max()) + mag(mesh.bounds().min());
    if (!sameShape(before, now, size))
    {
        Foam::refuse
        (
            mesh,
            {"constant/polyMesh", "the mesh", told(before), told(now)},
            "that, or a run from the start"
        );
    }
}


dictionary feedRecord::shape(const fvMesh& mesh)
{
    return shapeOf(mesh);
}


dictionary feedRecord::caseFiles(const fvMesh& mesh, const dictionary& feed)
{
    dictionary files;
    if (Pstream::master())
    {
        dictionary surfaces;
        files.add("named", namedFiles(feed));
        for (const word folder : {"constant", "system"})
        {
            const fileName place(mesh.time().globalPath()/folder);
            dictionary found;
            for (const word& name : filesIn(folder, place))
            {
                IFstream is(place/name);
                dictionary content(is);
                content.remove("FoamFile");
                found.add(name, content);
                const dictionary walls(namedSurfaces(content));
                if (!walls.empty())
                {
                    surfaces.add(name, walls);
                }
            }
            files.add(folder, found);
        }
        files.add("surfaces", surfaces);
    }
    elutriaBroadcast(files);
    return files;
}


wordHashSet feedRecord::changes
(
    const fvMesh& mesh,
    const dictionary& record,
    const dictionary& feed,
    const dictionary& files
)
{
    DynamicList<Change> ofFeed, accepted, others;
    compare("constant/feed", "", record.subDict("case"), feed, ofFeed);
    wordHashSet names;
    for (const Change& c : ofFeed)
    {
        const bool may = changeable.found(c.entry);
        (may ? accepted : others).append(c);
        if (may)
        {
            names.insert(c.entry);
        }
    }

    DynamicList<Change> elsewhere;
    const dictionary& before = record.subDict("files");
    for (const word folder : {"system", "constant"})
    {
        const dictionary& now = files.subDict(folder);
        wordHashSet both(before.subDict(folder).toc());
        both |= wordHashSet(now.toc());
        for (const word& name : both.sortedToc())
        {
            compare
            (
                fileName(folder)/name, "",
                before.subDict(folder).subOrEmptyDict(name),
                now.subOrEmptyDict(name), elsewhere
            );
        }
    }
    if (before.found("named"))
    {
        compare
        (
            "constant/feed", "",
            before.subDict("named"), files.subDict("named"), elsewhere
        );
    }
    const dictionary& surfaces = files.subDict("surfaces");
    for (const word& name : surfaces.toc())
    {
        compare
        (
            "constant"/name, "subModels/cellListCoeffs/surfaces/",
            before.subOrEmptyDict("surfaces").subOrEmptyDict(name),
            surfaces.subDict(name), elsewhere
        );
    }
    for (const Change& c : elsewhere)
    {
        if (!isValueOf(c, accepted))
        {
            refuse(mesh, c, "that, or a run from the start");
        }
    }
    for (const Change& c : others)
    {
        const word top(c.entry.substr(0, c.entry.find('/')));
        if (entriesOfFeed.found(top) || !isValueOf(c, accepted))
        {
            refuse(mesh, c, "that, or a run from the start");
        }
    }
    return names;
}


void feedRecord::refuse
(
    const fvMesh& mesh,
    const keyType& entry,
    const dictionary& before,
    const dictionary& now,
    const string& allowed
)
{
    Foam::refuse
    (
        mesh,
        {
            "constant/feed", entry,
            valueOf(before.findEntry(entry, keyType::LITERAL)),
            valueOf(now.findEntry(entry, keyType::LITERAL))
        },
        allowed
    );
}


} // End namespace Foam

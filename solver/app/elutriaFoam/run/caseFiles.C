/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/caseFiles.H"
#include "foam/digits.H"
#include "foam/honoured.H"
#include "foam/fileEntries.H"
#include "IOdictionary.H"
#include "OSspecific.H"
#include "Time.H"
#include "wordRes.H"

#include <fstream>
#include <sstream>

namespace Foam
{

namespace
{

//- Bytes of a dictionary of settings, and of what a field's file says beside
//  its values
constexpr off_t longestDictionary = 5000000;

//- Bytes of a cell's or a face's value in a field's file
constexpr off_t longestValue = 1000;


dictionary fileIfThere(const fvMesh& mesh, const word& name)
{
    IOobject header
    (
        name, mesh.time().constant(), mesh,
        IOobject::READ_IF_PRESENT, IOobject::NO_WRITE, false
    );
    return IOdictionary(header);
}


//- With the reason that the list of what is honoured has
[[noreturn]] void refuseEntry
(
    const fvMesh& mesh,
    const word& name,
    const string& found
)
{
    const fileName file(mesh.time().constant()/name);
    FatalErrorInFunction
        << file.c_str() << ": " << found.c_str()
        << honoured::find(honoured::kind::file, file)->why << exit(FatalError);
    std::abort();
}


void refuseLonger
(
    const fileName& file,
    const off_t most,
    const char* const allowed
)
{
    const off_t bytes = fileSize(file);
    if (bytes > most)
    {
        FatalErrorInFunction
            << file.c_str() << ": has " << threeDigits(1e-6*bytes).c_str()
            << " MB; allowed: " << threeDigits(1e-6*most).c_str() << " MB, "
            << allowed << exit(FatalError);
    }
}


string textOf(const fileName& file)
{
    std::ifstream stream(file);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}


//- Leave the files that the text does not name; what a named one names is named
void dropNamed(DynamicList<word>& files, const fileName& root, string text)
{
    for (label before = -1; before != files.size();)
    {
        before = files.size();
        DynamicList<word> still;
        for (const word& file : files)
        {
            if (text.find(fileName(file).name()) == string::npos)
            {
                still.append(file);
            }
            else
            {
                text += textOf(root/file);
            }
        }
        files.transfer(still);
    }
}


//- Is it a dictionary of the programs that make the mesh or evaluate a run?
bool isDictionaryOfOthers(const word& file)
{
    const honoured::Item* const item =
        honoured::find(honoured::kind::file, file);
    return
        item && item->is == honoured::use::others
     && file.compare(0, 7, "system/") == 0;
}


//- Entries of a file that it has again further down
void addOverwritten
(
    std::vector<caseFiles::Unused>& found,
    const fileName& root,
    const word& file
)
{
    for (const word& twice : repeatedEntries(root/file, false))
    {
        found.push_back
        ({
            word(file + ": " + twice, false),
            "the file has it again further down, and the last rules"
        });
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void caseFiles::refuse(const fvMesh& mesh)
{
    const dictionary rotating(fileIfThere(mesh, "MRFProperties"));
    for (const entry& zone : rotating)
    {
        if (zone.isDict() && zone.dict().getOrDefault("active", true))
        {
            refuseEntry(mesh, "MRFProperties", zone.keyword() + ": ");
        }
    }
    const word motion
    (
        fileIfThere(mesh, "dynamicMeshDict")
       .getOrDefault<word>("dynamicFvMesh", "staticFvMesh")
    );
    if (motion != "staticFvMesh")
    {
        refuseEntry
        (
            mesh, "dynamicMeshDict", "dynamicFvMesh: '" + motion + "'; "
        );
    }
}


wordList caseFiles::filesOf(const fileName& root, const word& folder)
{
    DynamicList<word> found;
    for (const fileName& name : readDir(root/folder))
    {
        found.append(word(folder + '/' + name, false));
    }
    return wordList(std::move(found));
}


void caseFiles::refuseHugeDictionary(const fileName& file)
{
    refuseLonger(file, longestDictionary, "a dictionary of settings");
}


void caseFiles::refuseFolders(const fileName& root)
{
    for (const honoured::Item& item : honoured::items())
    {
        if (item.of == honoured::kind::file && isDir(root/item.name))
        {
            FatalErrorInFunction
                << item.name << ": is a folder; allowed: a file"
                << exit(FatalError);
        }
    }
}


void caseFiles::refuseHuge(const fileName& root)
{
    for (const char* const folder : {"constant", "system"})
    {
        for (const word& file : filesOf(root, folder))
        {
            for (const honoured::Item& item : honoured::items())
            {
                const wordRe name
                (
                    honoured::named(item, ".*", ".*"), wordRe::REGEX
                );
                if
                (
                    item.of == honoured::kind::file
                 && item.is == honoured::use::works && name.match(file)
                )
                {
                    refuseHugeDictionary(root/file);
                }
            }
        }
    }
}


void caseFiles::refuseHugeFields(const fvMesh& mesh)
{
    const fileName folder(mesh.time().timePath());
    const off_t values = mesh.nCells() + mesh.nFaces();
    for (const fileName& name : readDir(folder))
    {
        refuseLonger
        (
            folder/name, longestDictionary + longestValue*values,
            "what a field of this mesh holds"
        );
    }
}


std::vector<caseFiles::Unused> caseFiles::unused
(
    const fvMesh& mesh,
    const word& cloud,
    const word& phase
)
{
    const fileName root(mesh.time().globalPath());
    std::vector<Unused> found;
    wordRes known;
    string text;
    for (const honoured::Item& item : honoured::items())
    {
        if (item.of == honoured::kind::file && item.is != honoured::use::refused)
        {
            const word name(honoured::named(item, cloud, phase), false);
            known.append(wordRe(name, wordRe::REGEX));
            if (item.is == honoured::use::works && isFile(root/name, false))
            {
                text += textOf(root/name);
                addOverwritten(found, root, name);
            }
        }
    }
    DynamicList<word> left;
    for (const char* const folder : {"constant", "system"})
    {
        for (const word& file : filesOf(root, folder))
        {
            if (!known.match(file))
            {
                left.append(file);
            }
            else if (isDictionaryOfOthers(file))
            {
                addOverwritten(found, root, file);
            }
        }
    }
    dropNamed(left, root, text);

    // Fields of the start are read as text only where something is left that
    // one of them may name. Later ones we wrote.
    const fileName fields(mesh.time().timePath());
    const bool first = mesh.time().timeIndex() == 0;
    const fileNameList inTime(first ? readDir(fields) : fileNameList());
    for (const fileName& name : left.empty() ? fileNameList() : inTime)
    {
        dropNamed(left, root, textOf(fields/name));
    }
    for (const fileName& field : inTime)
    {
        const word file(mesh.time().timeName() + '/' + field, false);
        if (!mesh.foundObject<regIOobject>(field))
        {
            left.append(file);
        }
        else if (isFile(root/file))
        {
            addOverwritten(found, root, file);
        }
    }
    for (const word& file : left)
    {
        found.push_back({file, "elutriaFoam reads no such file"});
    }
    return found;
}


} // End namespace Foam

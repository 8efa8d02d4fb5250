/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "foam/Warnings.H"
#include "foam/Json.H"
#include "foam/foamVersion.H"
#include "IOdictionary.H"
#include "OSspecific.H"
#include "Pstream.H"
#include "Time.H"

#include <fstream>

namespace Foam
{

namespace
{

//- Time of what is said while the case is read [s]
constexpr Foam::scalar beforeTheRun = 0;

const char* const fileOfRun = "warnings.json";


IOobject stateHeader(const Time& time, const IOobject::readOption read)
{
    return IOobject
    (
        "warnings", time.timeName(), "uniform", time, read,
        IOobject::NO_WRITE, false
    );
}


dictionary asDictionary(const Warnings::Record& r)
{
    dictionary dict;
    dict.add("name", string(r.warning.name));
    dict.add("what", string(r.warning.what));
    dict.add("howMuch", string(r.warning.howMuch));
    dict.add("whatToSet", string(r.warning.whatToSet));
    dict.add("size", r.warning.size);
    dict.add("first", r.first);
    dict.add("last", r.last);
    dict.add("times", r.times);
    return dict;
}


Warnings::Record asRecord(const dictionary& dict)
{
    return
    {
        {
            dict.get<string>("name"), dict.get<string>("what"),
            dict.get<string>("howMuch"), dict.get<string>("whatToSet"),
            dict.get<scalar>("size")
        },
        dict.get<scalar>("first"), dict.get<scalar>("last"),
        dict.get<label>("times")
    };
}


dictionary asDictionary(const std::vector<Warnings::Record>& records)
{
    dictionary all;
    label n = 0;
    for (const Warnings::Record& r : records)
    {
        all.add(word("warning" + Foam::name(n++)), asDictionary(r));
    }
    return all;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

Warnings& Warnings::all()
{
    static Warnings warnings;
    return warnings;
}


void Warnings::enter(const Record& r)
{
    for (Record& known : records_)
    {
        if
        (
            known.warning.name == r.warning.name
         && known.warning.what == r.warning.what
        )
        {
            if (r.warning.size >= known.warning.size)
            {
                known.warning = r.warning;
            }
            known.first = min(known.first, r.first);
            known.last = max(known.last, r.last);
            known.times += r.times;
            return;
        }
    }
    records_.push_back(r);
    if (time_ && Pstream::master())
    {
        writeFile();    // at once: a run that is killed has said it
    }
}


void Warnings::note(const RunWarning& warning)
{
    // Before the run begins: see start()
    const scalar now = time_ ? time_->value() : beforeTheRun;
    enter({warning, now, now, 1});
}


void Warnings::gather()
{
    List<dictionary> ofProcessor(Pstream::nProcs());
    if (!Pstream::master())
    {
        ofProcessor[Pstream::myProcNo()] = asDictionary(records_);
        records_.clear();
    }
    Pstream::gatherList(ofProcessor);
    if (Pstream::master())
    {
        for (const dictionary& other : ofProcessor)
        {
            for (const entry& e : other)
            {
                enter(asRecord(e.dict()));
            }
        }
    }
}


void Warnings::readState()
{
    const IOdictionary state
    (
        stateHeader(*time_, IOobject::READ_IF_PRESENT)
    );
    for (const entry& e : state)
    {
        if (e.isDict() && Pstream::master())
        {
            enter(asRecord(e.dict()));
        }
    }
}


void Warnings::writeState() const
{
    IOdictionary state(stateHeader(*time_, IOobject::NO_READ));
    state.merge(asDictionary(records_));
    state.regIOobject::write();
}


void Warnings::writeFile() const
{
    std::vector<std::string> objects;
    for (const Record& r : records_)
    {
        objects.push_back
        (
            json::object
            ({
                {"name", json::text(r.warning.name)},
                {"what", json::text(r.warning.what)},
                {"how_much", json::text(r.warning.howMuch)},
                {"what_to_set", json::text(r.warning.whatToSet)},
                {"first_time_s", json::number(r.first)},
                {"last_time_s", json::number(r.last)},
                {"times", json::number(r.times)},
                {"by", json::text("elutriaFoam")}
            })
        );
    }
    const fileName file(time_->globalPath()/fileOfRun);
    const fileName draft(file + ".part");
    {
        std::ofstream os(draft);
        os << json::list(objects) << '\n';
        if (!os.flush())
        {
            FatalErrorInFunction
                << "cannot write " << file << ": is the disk full or the"
                << " folder read-only?" << exit(FatalError);
        }
    }
    mv(draft, file);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Warnings::add(const RunWarning& warning)
{
    Info<< "    Warning: " << warning.text().c_str() << endl;
    if (Pstream::master())
    {
        all().note(warning);
    }
}


void Warnings::addLocal(const RunWarning& warning)
{
    Pout<< "    Warning: " << warning.text().c_str() << endl;
    all().note(warning);
}


void Warnings::start(const Time& time)
{
    Warnings& warnings = all();
    warnings.time_ = &time;
    for (Record& r : warnings.records_)
    {
        r.first = r.last = time.value();
    }
    warnings.readState();
    if (Pstream::master())
    {
        warnings.writeFile();
    }
}


void Warnings::write()
{
    Warnings& warnings = all();
    if (!warnings.time_)
    {
        return;
    }
    warnings.gather();
    if (Pstream::master())
    {
        warnings.writeFile();
    }
    warnings.writeState();
}


} // End namespace Foam

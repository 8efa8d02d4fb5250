/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/Steering.H"
#include "foam/ownEntries.H"
#include "IOdictionary.H"
#include "OSspecific.H"
#include "Pstream.H"

#include <cmath>
#include <fstream>
#include <iomanip>

namespace Foam
{

namespace
{

const char* const headerText =
    "FoamFile\n{\n    version     2.0;\n    format      ascii;\n"
    "    class       dictionary;\n    location    \"system\";\n"
    "    object      steering;\n}\n\n"
    "// Time (s), gas velocity and loading over the case's\nchanges\n(\n";

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

fileName Steering::file() const
{
    return time_.globalPath()/time_.system()/"steering";
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Steering::Steering(const Time& time)
:
    time_(time)
{
    const IOdictionary dict
    (
        IOobject
        (
            "steering",
            time.system(),
            time,
            IOobject::READ_IF_PRESENT,
            IOobject::NO_WRITE,
            false
        )
    );
    requireEntries(dict, wordList({"changes"}));
    const auto rows =
        dict.getOrDefault<List<vector>>("changes", List<vector>());
    for (const vector& row : rows)
    {
        const Change change{row.x(), row.y(), row.z()};
        const bool late = changes_.empty() || change.time >= changes_.back().time;
        if (!(late && change.gas > 0 && change.gas <= 100
         && change.loading > 0 && change.loading <= 100))
        {
            FatalIOErrorInFunction(dict)
                << "changes has " << row << ", allowed: (time gas loading) with"
                << " rising times (s) and factors above 0, up to 100"
                << exit(FatalIOError);
        }
        changes_.push_back(change);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

Steering::Change Steering::at(const scalar time) const
{
    Change found;
    for (const Change& change : changes_)
    {
        if (change.time > time)
        {
            break;
        }
        found = change;
    }
    return found;
}


Steering::Change Steering::before(const scalar time) const
{
    return at(std::nextafter(time, -GREAT));
}


bool Steering::add(const Change& change)
{
    while (!changes_.empty() && changes_.back().time >= change.time)
    {
        changes_.pop_back();
    }
    changes_.push_back(change);
    if (!Pstream::master())
    {
        return true;
    }

    const fileName draft(file() + ".part");
    std::ofstream os(draft);
    os << headerText << std::setprecision(17);
    for (const Change& c : changes_)
    {
        os << "    (" << c.time << ' ' << c.gas << ' ' << c.loading << ")\n";
    }
    os << ");\n" << std::flush;
    return os && mv(draft, file());
}


} // End namespace Foam

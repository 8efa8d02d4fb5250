/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "outlets/Crossings.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "foam/requireAllowed.H"
#include "laws/OutputFiles.hpp"
#include "OSspecific.H"
#include "Pstream.H"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <tuple>

namespace Foam
{

namespace
{

const char* const header = elutria::laws::crossingColumns;

//- Planes of a column at most: a file of them must stay readable
constexpr label mostPlanes = 200;

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

scalarList Crossings::readHeights(const dictionary& feed)
{
    if (!feed.found("planes"))
    {
        return scalarList();
    }
    scalarList heights;
    if (feed.isDict("planes"))
    {
        const dictionary& dict = feed.subDict("planes");
        requireOwnEntries(dict, ownDictionary::planes);
        const scalar first = dict.get<scalar>("first");
        const scalar spacing = readAllowed(dict, "spacing", above(0));
        const label number = dict.get<label>("number");
        requireAllowed("number", number, above(0), dict);
        heights.resize(min(number, mostPlanes + 1));
        forAll(heights, i)
        {
            heights[i] = first + i*spacing;
        }
    }
    else
    {
        heights = feed.get<scalarList>("planes");
    }
    for (label i = 1; i < heights.size(); ++i)
    {
        if (!(heights[i] > heights[i - 1]))
        {
            FatalIOErrorInFunction(feed)
                << "planes has " << heights[i] << " after " << heights[i - 1]
                << ", allowed: rising heights (m)" << exit(FatalIOError);
        }
    }
    if (heights.size() > mostPlanes)
    {
        FatalIOErrorInFunction(feed)
            << "planes are more than " << mostPlanes << ", allowed: up to that"
            << exit(FatalIOError);
    }
    return heights;
}


void Crossings::trim(const fileName& file, const scalar time)
{
    std::ifstream is(file);
    std::string line, kept;
    std::getline(is, line);
    while (std::getline(is, line))
    {
        if (!is.eof() && std::atof(line.c_str()) <= time)
        {
            kept += line + '\n';
        }
    }
    is.close();
    std::ofstream os(file);
    os << header << '\n' << kept;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Crossings::Crossings
(
    const Feed& feed,
    const Time& runTime,
    const vector& gravity
)
:
    feed_(feed),
    up_(-gravity/max(mag(gravity), VSMALL)),
    heights_(readHeights(feed)),
    file_
    (
        runTime.globalPath()/"postProcessing"/"crossings"
       /runTime.timeName()/"crossings.csv"
    )
{
    if (heights_.empty() || !Pstream::master())
    {
        return;
    }
    // Half a step of the last written digit: rows are written with 12 digits
    const scalar until = runTime.value()*(1 + 1e-11);
    const fileName folder(file_.path().path());
    for (const instant& start : Time::findTimes(folder))
    {
        const fileName earlier(folder/start.name()/"crossings.csv");
        if (isFile(earlier, false))
        {
            trim(earlier, until);
        }
    }
    mkDir(file_.path());
    if (!isFile(file_, false))
    {
        std::ofstream(file_) << header << '\n';
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Crossings::move
(
    const point& from,
    const point& to,
    const scalar until,
    const scalar dt,
    const label id,
    const scalar diameter,
    const scalar nParticle
)
{
    if (heights_.empty())
    {
        return;
    }
    const scalar start = from & up_, end = to & up_;
    const label direction = end > start ? 1 : -1;
    forAll(heights_, i)
    {
        const scalar h = heights_[i];
        if ((start < h) == (end < h))
        {
            continue;
        }
        const scalar left = (end - h)/(end - start);
        pending_.append({until - left*dt, i, direction, id, diameter, nParticle});
    }
}


void Crossings::write()
{
    if (heights_.empty())
    {
        return;
    }
    List<List<Row>> all(Pstream::nProcs());
    all[Pstream::myProcNo()] = pending_;
    Pstream::gatherList(all);
    pending_.clear();
    if (!Pstream::master())
    {
        return;
    }

    // In order of time, then of number: the same for any decomposition
    List<Row> rows;
    for (const List<Row>& list : all)
    {
        rows.append(list);
    }
    std::sort
    (
        rows.begin(), rows.end(),
        [](const Row& a, const Row& b)
        {
            return std::tie(a.time, a.id, a.plane) < std::tie(b.time, b.id, b.plane);
        }
    );
    std::ofstream os(file_, std::ios::app);
    os << std::setprecision(12);
    for (const Row& row : rows)
    {
        os  << row.time << ',' << row.plane << ',' << heights_[row.plane] << ','
            << row.direction << ','
            << feed_.materials()[feed_.materialOf(row.id)].name << ','
            << row.id << ',' << row.diameter << ',' << row.nParticle << '\n';
    }
    os.flush();
    if (!os)
    {
        FatalErrorInFunction
            << "cannot write " << file_ << ": is the disk full?"
            << exit(FatalError);
    }
}


} // End namespace Foam

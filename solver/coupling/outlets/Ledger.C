/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "outlets/Ledger.H"
#include "foam/foamVersion.H"
#include "laws/OutputFiles.hpp"
#include "OSspecific.H"
#include "Time.H"
#include "Pstream.H"

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <tuple>

namespace Foam
{

namespace
{

const char* const header = elutria::laws::particleColumns;


//- Write a whole file, or none: users never see half of one
template<class Writer>
void writeWhole(const fileName& file, const Writer& writer)
{
    const fileName draft(file + ".part");
    {
        std::ofstream os(draft);
        os << std::setprecision(12);
        writer(os);
        os.flush();
        if (!os)
        {
            FatalErrorInFunction
                << "cannot write " << file << ": is the disk full or the"
                << " folder read-only?" << exit(FatalError);
        }
    }
    mv(draft, file);
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Ledger::trim(const fileName& file, const scalar time)
{
    std::ifstream is(file);
    std::string line;
    std::ostringstream kept;
    bool dropped = false;

    std::getline(is, line);
    while (std::getline(is, line))
    {
        std::istringstream columns(line);
        std::string cell[7];
        for (auto& c : cell)
        {
            std::getline(columns, c, ',');
        }
        const label id = label(std::atol(cell[3].c_str()));
        const auto product =
            std::find(feed_.products().begin(), feed_.products().end(), cell[1]);

        if
        (
            is.eof()
         || !columns
         || product == feed_.products().end()
         || std::atof(cell[0].c_str()) > time
        )
        {
            dropped = true;
            continue;
        }

        kept << line << '\n';
        const scalar number = feed_.number(id);
        Account& account = accounts_[feed_.materialOf(id)];
        account.left[product - feed_.products().begin()].add
        (
            number,
            number*feed_.mass(id)
        );
    }
    is.close();

    if (dropped)
    {
        writeWhole
        (
            file,
            [&](std::ostream& os) { os << header << '\n' << kept.str(); }
        );
    }
}


void Ledger::takeOver(const scalar time)
{
    // Half a step of the last written digit: rows are written with 12 digits
    const scalar until = time*(1 + 1e-11);

    // In order of time, so that sums are those of one run to the last bit
    for (const instant& start : Time::findTimes(directory_/"outlets"))
    {
        const fileName file(directory_/"outlets"/start.name()/"particles.csv");
        if (isFile(file, false))
        {
            trim(file, until);
        }
    }
}


List<List<Ledger::Row>> Ledger::gather(const UList<Row>& own)
{
    List<List<Row>> all(Pstream::nProcs());
    all[Pstream::myProcNo()] = own;
    Pstream::gatherList(all);
    return all;
}


void Ledger::writeRows(std::ostream& os, const UList<Row>& rows) const
{
    for (const Row& row : rows)
    {
        const Feed::Material& material =
            feed_.materials()[feed_.materialOf(row.id)];

        os  << row.time << ','
            << (row.outlet < 0 ? word("inside") : feed_.products()[row.outlet])
            << ',' << material.name << ',' << row.id << ','
            << row.diameter << ',' << feed_.densityOf(row.id) << ','
            << row.nParticle << ','
            << row.velocity.x() << ',' << row.velocity.y() << ','
            << row.velocity.z() << ',' << row.age << '\n';
    }
}


void Ledger::writeInside(const UList<Row>& rows) const
{
    writeWhole
    (
        directory_/"inside.csv",
        [&](std::ostream& os)
        {
            os << header << '\n';
            writeRows(os, rows);
        }
    );
}


Account Ledger::total() const
{
    Account sum(feed_.products().size());
    for (const Account& material : accounts_)
    {
        sum += material;
    }
    return sum;
}


void Ledger::writeLedger(const scalar time) const
{
    writeWhole
    (
        directory_/"ledger.json",
        [&](std::ostream& os)
        {
            // Sums close to 1e-12
            os  << std::setprecision(15) << "{\n  \"time_s\": " << time
                << ",\n  \"seed\": " << feed_.seedEntry()
                << ",\n  \"partition_to\": \"" << feed_.partitionTo() << "\""
                << ",\n  \"total\": ";
            total().write(os, feed_.products());
            os << ",\n  \"materials\": {";
            forAll(accounts_, m)
            {
                os  << (m ? ",\n    \"" : "\n    \"")
                    << feed_.materials()[m].name << "\": ";
                accounts_[m].write(os, feed_.products());
            }
            os << "\n  }\n}\n";
        }
    );
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Ledger::Ledger(const Feed& feed, const Time& runTime)
:
    feed_(feed),
    directory_(runTime.globalPath()/"postProcessing"),
    file_(directory_/"outlets"/runTime.timeName()/"particles.csv"),
    watched_(false),
    accounts_(feed.materials().size(), Account(feed.products().size())),
    fed_(0)
{
    if (Pstream::master())
    {
        mkDir(file_.path());
        takeOver(runTime.value());
        if (!isFile(file_, false))
        {
            writeWhole(file_, [](std::ostream& os) { os << header << '\n'; });
        }
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Ledger::fed(const label number)
{
    for (; fed_ < number; ++fed_)
    {
        const scalar number = feed_.number(fed_);
        accounts_[feed_.materialOf(fed_)].fed.add
        (
            number,
            number*feed_.mass(fed_)
        );
    }
}


void Ledger::write(const scalar time, const UList<Row>& inside)
{
    const List<List<Row>> left = gather(pending_);
    const List<List<Row>> within = gather(inside);
    pending_.clear();

    if (!Pstream::master())
    {
        return;
    }

    // In order of time, then of number: the same for any decomposition
    List<Row> rows;
    for (const List<Row>& list : left)
    {
        rows.append(list);
    }
    std::sort
    (
        rows.begin(), rows.end(),
        [](const Row& a, const Row& b)
        {
            return std::tie(a.time, a.id) < std::tie(b.time, b.id);
        }
    );
    for (const Row& row : rows)
    {
        accounts_[feed_.materialOf(row.id)].left[row.outlet].add
        (
            row.nParticle,
            row.nParticle*feed_.mass(row.id)
        );
    }

    List<Row> still;
    for (const List<Row>& list : within)
    {
        still.append(list);
    }
    std::sort
    (
        still.begin(), still.end(),
        [](const Row& a, const Row& b) { return a.id < b.id; }
    );
    for (Account& account : accounts_)
    {
        account.inside = Amount();
    }
    for (const Row& row : still)
    {
        accounts_[feed_.materialOf(row.id)].inside.add
        (
            row.nParticle,
            row.nParticle*feed_.mass(row.id)
        );
    }

    std::ofstream os(file_, std::ios::app);
    os << std::setprecision(12);
    writeRows(os, rows);
    os.flush();
    if (!os)
    {
        FatalErrorInFunction
            << "cannot write " << file_ << ": is the disk full?"
            << exit(FatalError);
    }
    writeInside(still);
    writeLedger(time);
}


labelList Ledger::leftParcels() const
{
    labelList parcels(feed_.products().size(), Zero);
    for (const Row& row : pending_)
    {
        ++parcels[row.outlet];
    }
    Pstream::listCombineGather(parcels, plusEqOp<label>());

    const Account all(total());
    forAll(parcels, i)
    {
        parcels[i] += all.left[i].parcels;
    }
    elutriaBroadcast(parcels);
    return parcels;
}


} // End namespace Foam

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
        left_[product - feed_.products().begin()][feed_.materialOf(id)].add
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


void Ledger::writeLedger(const scalar time, const List<Amount>& inside)
{
    const label nMaterials = feed_.materials().size();
    const label nProducts = feed_.products().size();

    const auto total = [&](const List<Amount>& perMaterial)
    {
        Amount sum;
        for (const Amount& a : perMaterial)
        {
            sum.parcels += a.parcels;
            sum.number += a.number;
            sum.mass += a.mass;
        }
        return sum;
    };
    const auto show = [](std::ostream& os, const Amount& a)
    {
        os  << "{\"parcels\": " << a.parcels << ", \"number\": " << a.number
            << ", \"mass_kg\": " << a.mass << "}";
    };

    // injected - outlets - inside; the mass of no parcels is no mass. Returns
    // what is lost
    const auto account = [&]
    (
        std::ostream& os,
        const Amount& injected,
        const List<Amount>& outlets,
        const Amount& within
    )
    {
        Amount lost = injected;
        os << "{\"injected\": ";
        show(os, injected);
        os << ", \"outlets\": {";
        forAll(outlets, i)
        {
            os << (i ? ", \"" : "\"") << feed_.products()[i] << "\": ";
            show(os, outlets[i]);
            lost.parcels -= outlets[i].parcels;
            lost.number -= outlets[i].number;
            lost.mass -= outlets[i].mass;
        }
        os << "}, \"inside\": ";
        show(os, within);
        lost.parcels -= within.parcels;
        lost.number -= within.number;
        lost.mass -= within.mass;

        const scalar error = injected.mass > 0 ? mag(lost.mass)/injected.mass : 0;
        if (lost.parcels == 0)
        {
            lost = Amount();
        }
        os << ", \"lost\": ";
        show(os, lost);
        os << ", \"mass_closure_error\": " << error << "}";
        return lost;
    };

    writeWhole
    (
        directory_/"ledger.json",
        [&](std::ostream& os)
        {
            List<Amount> outlets(nProducts);
            forAll(outlets, i)
            {
                outlets[i] = total(left_[i]);
            }
            // Sums close to 1e-12
            os  << std::setprecision(15) << "{\n  \"time_s\": " << time
                << ",\n  \"seed\": " << feed_.seedEntry()
                << ",\n  \"partition_to\": \"" << feed_.partitionTo() << "\""
                << ",\n  \"total\": ";
            lost_ = account(os, total(injected_), outlets, total(inside));
            os << ",\n  \"materials\": {";
            for (label m = 0; m < nMaterials; ++m)
            {
                forAll(outlets, i)
                {
                    outlets[i] = left_[i][m];
                }
                os  << (m ? ",\n    \"" : "\n    \"")
                    << feed_.materials()[m].name << "\": ";
                account(os, injected_[m], outlets, inside[m]);
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
    left_(feed.products().size(), List<Amount>(feed.materials().size())),
    injected_(feed.materials().size()),
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
        injected_[feed_.materialOf(fed_)].add(number, number*feed_.mass(fed_));
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
        left_[row.outlet][feed_.materialOf(row.id)].add
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
    List<Amount> insideAmounts(feed_.materials().size());
    for (const Row& row : still)
    {
        insideAmounts[feed_.materialOf(row.id)].add
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
    writeLedger(time, insideAmounts);
}


scalar Ledger::injectedMass() const
{
    scalar mass = 0;
    for (const Amount& a : injected_)
    {
        mass += a.mass;
    }
    return mass;
}


labelList Ledger::leftParcels() const
{
    labelList parcels(feed_.products().size(), Zero);
    for (const Row& row : pending_)
    {
        ++parcels[row.outlet];
    }
    Pstream::listCombineGather(parcels, plusEqOp<label>());

    forAll(parcels, i)
    {
        for (const Amount& a : left_[i])
        {
            parcels[i] += a.parcels;
        }
    }
    elutriaBroadcast(parcels);
    return parcels;
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "gas/GasTable.H"
#include "laws/OutputFiles.hpp"
#include "OSspecific.H"

#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>

namespace Foam
{

scalar GasTable::section() const
{
    const fvMesh& mesh = gas_.U().mesh();
    const vector down(normalised(gas_.gravity()));
    const scalarField height(mesh.points() & down);
    return gSum(mesh.V())/max(gMax(height) - gMin(height), VSMALL);
}


GasTable::GasTable(const GasPhase& gas, const Time& time)
:
    gas_(gas),
    file_(time.globalPath()/"postProcessing"/"gas"/time.timeName()/"gas.csv")
{
    if (Pstream::master())
    {
        mkDir(file_.path());
        std::ofstream(file_) << elutria::laws::gasColumns << '\n';
    }
}


void GasTable::write() const
{
    const fvMesh& mesh = gas_.U().mesh();
    std::ostringstream rows;
    rows << std::setprecision(9);
    const auto row = [&]
    (
        const word& patch,
        const scalar area,
        const scalar flow,
        const scalar density,
        const scalar pressure,
        const scalar asked
    )
    {
        rows<< mesh.time().value() << ',' << patch << ',' << area << ','
            << flow << ',' << density*flow << ','
            << flow/max(area, VSMALL) << ',' << pressure << ',' << asked
            << '\n';
    };

    const scalar unknown = std::numeric_limits<scalar>::quiet_NaN();
    scalar inflow = 0, massInflow = 0, allAsked = 0;
    for (const GasPhase::Opening& o : gas_.openings())
    {
        row
        (
            mesh.boundary()[o.patch].name(), o.area, o.flow, o.density,
            o.pressure, o.isAsked ? o.asked : unknown
        );
        inflow += max(o.flow, scalar(0));
        massInflow += o.density*max(o.flow, scalar(0));
        allAsked += o.isAsked ? max(o.asked, scalar(0)) : 0;
    }
    row
    (
        "all", section(), inflow, massInflow/max(inflow, VSMALL), unknown,
        gas_.inflowIsFixed() ? allAsked : unknown
    );
    if (Pstream::master())
    {
        std::ofstream file(file_, std::ios::app);
        file << rows.str();
        if (!file.flush())
        {
            FatalErrorInFunction
                << "cannot write " << file_ << ": is the disk full or the"
                << " folder read-only?" << exit(FatalError);
        }
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/CellGas.H"
#include "laws/SelfInducedVelocity.hpp"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

const volScalarField* CellGas::eddyViscosity() const
{
    return cloud_.mesh().findObject<volScalarField>
    (
        IOobject::groupName("nut", cloud_.U().group())
    );
}


void CellGas::copyFields(const volScalarField* eddyViscosity)
{
    const scalar leastDensity = cloud_.constProps().rhoMin();
    for (label celli = 0; celli < label(cells_.size()); ++celli)
    {
        Cell& cell = cells_[celli];
        cell.velocity = cloud_.U()[celli];
        cell.density = max(cloud_.rho()[celli], leastDensity);
        cell.viscosity = cloud_.mu()[celli];
        cell.eddyViscosity = eddyViscosity ? (*eddyViscosity)[celli] : 0;
        cell.solidFraction = solids_.field()[celli];
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

CellGas::CellGas
(
    const StockCloud& cloud,
    const SolidFraction& solids,
    const DiffusionKernel& kernel
)
:
    cloud_(cloud),
    solids_(solids),
    kernel_(kernel),
    cells_(cloud.mesh().nCells()),
    states_(-1),
    kernelWidth_(-1)
{
    const fvMesh& mesh = cloud.mesh();
    for (label celli = 0; celli < mesh.nCells(); ++celli)
    {
        Cell& cell = cells_[celli];
        cell.volume = mesh.V()[celli];
        cell.size = cbrt(cell.volume);
        cell.centre = mesh.C()[celli];
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void CellGas::update()
{
    const volScalarField* eddies = eddyViscosity();
    const FixedList<label, 5> states
    ({
        cloud_.U().eventNo(),
        cloud_.rho().eventNo(),
        cloud_.mu().eventNo(),
        solids_.field().eventNo(),
        eddies ? eddies->eventNo() : -1
    });
    if (states != states_)
    {
        states_ = states;
        copyFields(eddies);
    }

    const scalar width = kernel_.active() ? kernel_.width() : 0;
    if (width != kernelWidth_)
    {
        kernelWidth_ = width;
        for (Cell& cell : cells_)
        {
            cell.depositKept = -1;
        }
    }
}


scalar CellGas::depositKept(const label celli)
{
    Cell& cell = cells_[celli];
    if (cell.depositKept < 0)
    {
        cell.depositKept =
            elutria::laws::depositKept(kernelWidth_, cell.size);
    }
    return cell.depositKept;
}


} // End namespace Foam

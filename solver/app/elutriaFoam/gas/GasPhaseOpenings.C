/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    GasPhase's inlets and outlets: what is asked of them, and what passes.

\*---------------------------------------------------------------------------*/

#include "gas/GasPhase.H"
#include "fixedValueFvPatchFields.H"
#include "wallPolyPatch.H"

namespace Foam
{

bool GasPhase::isOpen(const polyPatch& patch)
{
    return
        !patch.coupled()
     && !isA<wallPolyPatch>(patch)
     && !polyPatch::constraintType(patch.type());
}


void GasPhase::updateInlets()
{
    forAll(mesh_.boundary(), patchi)
    {
        fvPatchVectorField& U = U_.boundaryFieldRef(false)[patchi];
        if (isA<fixedValueFvPatchVectorField>(U))
        {
            const vectorField before(U);
            U.evaluate();
            if (max(mag(U - before)) > 0)
            {
                phi_.boundaryFieldRef(false)[patchi] ==
                    (U & mesh_.boundary()[patchi].Sf());
            }
        }
    }
    alphaPhi_ = alphaf_*phi_;
}


bool GasPhase::inflowIsFixed() const
{
    // One patch at which pressure is given takes what the others leave
    label givenPressures = 0;
    forAll(mesh_.boundary(), patchi)
    {
        const polyPatch& patch = mesh_.boundaryMesh()[patchi];
        givenPressures +=
            isOpen(patch) && p_.boundaryField()[patchi].fixesValue();
    }
    return
        returnReduce(givenPressures, maxOp<label>()) < 2
     && inflow(phi_) > VSMALL;
}


scalar GasPhase::massInflow() const
{
    return inflow(phi_)*meanDensity();
}


scalar GasPhase::pressureDrop() const
{
    // Of what the gas' weight does not hold
    scalar lowest = GREAT, highest = -GREAT;
    forAll(mesh_.boundary(), patchi)
    {
        const fvPatchScalarField& p = p_.boundaryField()[patchi];
        if (!p.patch().coupled() && p.size() && p.fixesValue())
        {
            const scalarField driving
            (
                p - (p.patch().Cf() & g_.value())
            );
            lowest = min(lowest, min(driving));
            highest = max(highest, max(driving));
        }
    }
    reduce(lowest, minOp<scalar>());
    reduce(highest, maxOp<scalar>());
    return max(highest - lowest, scalar(0));
}


bool GasPhase::isDriven() const
{
    const surfaceScalarField outward(-phi_);
    return inflow(outward) > VSMALL || pressureDrop() > VSMALL;
}


List<GasPhase::Opening> GasPhase::openings() const
{
    DynamicList<Opening> all;
    forAll(mesh_.boundary(), patchi)
    {
        if (!isOpen(mesh_.boundaryMesh()[patchi]))
        {
            continue;
        }
        const fvPatchVectorField& U = U_.boundaryField()[patchi];
        const fvPatchScalarField& p = p_.boundaryField()[patchi];
        const scalarField area(mesh_.boundary()[patchi].magSf());
        const vectorField normal(mesh_.boundary()[patchi].Sf());
        const scalarField& rho = rho_.boundaryField()[patchi];

        Opening o;
        o.patch = patchi;
        o.area = gSum(area);
        o.flow = -gSum(alphaPhi_.boundaryField()[patchi]);
        o.density = gSum(rho*area)/max(o.area, VSMALL);
        o.pressure = gSum(rho*p*area)/max(o.area, VSMALL);
        o.isAsked =
            returnReduce(bool(isA<fixedValueFvPatchVectorField>(U)), orOp<bool>())
         && !returnReduce(p.fixesValue(), orOp<bool>());
        o.asked = -gSum(scalarField(U & normal));
        all.append(o);
    }
    List<Opening> openings;
    openings.transfer(all);
    return openings;
}


} // End namespace Foam

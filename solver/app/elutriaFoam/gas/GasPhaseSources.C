/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    GasPhase's sources of constant/fvOptions.

\*---------------------------------------------------------------------------*/

#include "gas/GasPhase.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

tmp<volVectorField> GasPhase::addSources(fvVectorMatrix& momentum)
{
    const fvVectorMatrix source(sources_(alpha_, geometricOneField(), U_));
    if (source.hasDiag())
    {
        volScalarField resistance
        (
            IOobject("resistance", mesh_.time().timeName(), mesh_),
            mesh_,
            dimensionedScalar(dimless/dimTime, Zero)
        );
        resistance.primitiveFieldRef() =
            max(-source.diag()/mesh_.V().field(), scalar(0));
        momentum += fvm::Sp(resistance, U_) - resistance*U_;
    }
    return source & U_;
}


void GasPhase::checkSources()
{
    wordList fields(mesh_.sortedNames<volScalarField>());
    fields.append(mesh_.sortedNames<volVectorField>());
    for (const fv::option& source : static_cast<PtrList<fv::option>&>(sources_))
    {
        bool acts = false;
        for (const word& field : fields)
        {
            acts = acts || source.applyToField(field) >= 0;
        }
        if (!acts)
        {
            FatalIOErrorInFunction(sources_)
                << source.name() << ": the source acts on no field of this"
                << " case; allowed: " << U_.name() << ", or a field of the"
                << " turbulence, as U, UNames or fields of its coefficients"
                << exit(FatalIOError);
        }
        // All others may change in time in a way that only they know
        const bool steady =
            source.type() == "explicitPorositySource"
         && !source.coeffs().found("timeStart")
         && !sources_.subOrEmptyDict(source.name()).found("timeStart");
        sourcesVary_ = sourcesVary_ || (source.active() && !steady);
    }
    if (hasSources_)
    {
        nu_.reset
        (
            new volScalarField
            (
                fieldHeader
                (
                    IOobject::groupName("nu", name_), IOobject::NO_READ
                ),
                transport_.nu()
            )
        );
        nu_->writeOpt() = IOobject::NO_WRITE;
    }
}


} // End namespace Foam

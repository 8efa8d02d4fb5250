/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    GasPhase's start from a flow that has settled at another velocity.

\*---------------------------------------------------------------------------*/

#include "gas/GasPhase.H"
#include "foam/Warnings.H"

namespace Foam
{

namespace
{

const char* const settledFolder = "settledGas";


IOobject settledHeader(const regIOobject& field, const fvMesh& mesh)
{
    return IOobject
    (
        field.name(), mesh.time().constant(), settledFolder, mesh,
        IOobject::MUST_READ, IOobject::NO_WRITE, false
    );
}


void take(surfaceScalarField& field, const surfaceScalarField& other)
{
    field == other;
}


template<class Type>
void take
(
    GeometricField<Type, fvPatchField, volMesh>& field,
    const GeometricField<Type, fvPatchField, volMesh>& other
)
{
    field.primitiveFieldRef() = other.primitiveField();
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

template<class Visit>
void GasPhase::visitTurbulence
(
    const std::initializer_list<const char*> names,
    const Visit& visit
)
{
    for (const char* const name : names)
    {
        const word field(IOobject::groupName(name, U_.group()));
        if (mesh_.foundObject<volScalarField>(field))
        {
            visit(mesh_.lookupObjectRef<volScalarField>(field));
        }
    }
}


template<class Visit>
void GasPhase::visitFlow(const Visit& visit)
{
    visit(U_);
    visit(p_);
    visit(phi_);
    visitTurbulence({"k", "epsilon", "omega", "nuTilda", "nut"}, visit);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void GasPhase::startFromSettled()
{
    IOobject header(settledHeader(phi_, mesh_));
    if (!header.typeHeaderOk<surfaceScalarField>(true))
    {
        return;
    }
    scalar before = 0;
    try
    {
        before = inflow(surfaceScalarField(header, mesh_));
    }
    catch (const error&)
    {}
    const scalar ratio = inflow(phi_)/max(before, VSMALL);
    if (!(ratio > 1e-3 && ratio < 1e3))
    {
        Warnings::add
        ({
            "settledGas", "constant/settledGas is ignored",
            "it is of another mesh or of a gas at rest",
            "remove it, or write it anew with -keepSettled", 0
        });
        return;
    }

    // The same flow in a time that runs faster by the ratio
    visitFlow([&](auto& field)
    {
        typedef typename std::remove_reference<decltype(field)>::type fieldType;
        const fieldType settled(settledHeader(field, mesh_), mesh_);
        // most of the pressure is the gas's weight
        const scalar power =
            field.name() == p_.name() ? 0
          : -settled.dimensions()[dimensionSet::TIME];
        const fieldType scaled(std::pow(ratio, power)*settled);
        take(field, scaled);
    });
    U_.correctBoundaryConditions();
    visitTurbulence({"k", "nuTilda", "nut"}, [](volScalarField& field)
    {
        field.correctBoundaryConditions();
    });
    alphaPhi_ = alphaf_*phi_;
    forgetMeans();
    Info<< "elutria: gas starts from the flow settled at " << 1/ratio
        << " times its velocity" << endl;
}


void GasPhase::writeSettled()
{
    visitFlow([&](auto& field)
    {
        typedef typename std::remove_reference<decltype(field)>::type fieldType;
        IOobject header(settledHeader(field, mesh_));
        header.readOpt() = IOobject::NO_READ;
        fieldType(header, field).write();
    });
}


} // End namespace Foam

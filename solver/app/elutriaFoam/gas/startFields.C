/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "gas/startFields.H"
#include "gas/GasPhase.H"
#include "run/controls.H"
#include "fixedValueFvPatchFields.H"
#include "localIOdictionary.H"

namespace Foam
{

namespace
{

//- Squares are taken of them
constexpr scalar largest = 1e30;

//- A scalar field that turbulence models read
struct Known
{
    const char* name;
    dimensionSet dimensions;
    Range allowed;
};


std::vector<Known> knownFields()
{
    const dimensionSet energy(dimVelocity*dimVelocity);
    const dimensionSet viscosity(dimVelocity*dimLength);
    return
    {
        {"k", energy, atLeast(0, largest)},
        {"epsilon", energy/dimTime, above(0, largest)},
        {"omega", dimless/dimTime, above(0, largest)},
        {"nut", viscosity, atLeast(0, largest)},
        {"nuTilda", viscosity, atLeast(0, largest)}
    };
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

StartFields::StartFields(const fvMesh& mesh, const word& phase)
:
    mesh_(mesh)
{
    for (const Known& known : knownFields())
    {
        IOobject header
        (
            IOobject::groupName(known.name, phase), mesh.time().timeName(), mesh,
            IOobject::MUST_READ, IOobject::NO_WRITE, false
        );
        if (!header.typeHeaderOk<volScalarField>())
        {
            continue;
        }
        const localIOdictionary file(header, volScalarField::typeName);
        requireSoundControl("0", file);

        dimensionSet dimensions(dimless);
        file.readEntry("dimensions", dimensions);
        if (dimensions != known.dimensions)
        {
            refuseDimensions(header, dimensions, known.dimensions);
        }
        const scalarField values("internalField", file, mesh.nCells());
        files_.push_back
        ({
            header.name(), gMin(values), gMax(values), known.allowed
        });
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void StartFields::requireSound() const
{
    for (const File& file : files_)
    {
        const auto* const read = mesh_.findObject<volScalarField>(file.name);
        if (!read)
        {
            continue;
        }
        requireWithin
        (
            *read, "internalField", file.least, file.most, file.allowed
        );
        for (const fvPatchScalarField& patch : read->boundaryField())
        {
            if
            (
                isA<fixedValueFvPatchScalarField>(patch)
             && GasPhase::isOpen(patch.patch().patch())
             && returnReduce(patch.size(), sumOp<label>()) > 0
            )
            {
                requireWithin
                (
                    *read, patch.patch().name(), gMin(patch), gMax(patch),
                    file.allowed
                );
            }
        }
    }
}


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void refuseDimensions
(
    const IOobject& field,
    const dimensionSet& found,
    const dimensionSet& allowed
)
{
    FatalErrorInFunction
        << field.instance().c_str() << '/' << field.name()
        << ": dimensions are " << found << ", allowed: " << allowed
        << exit(FatalError);
    std::abort();   // never reached
}


void requireWithin
(
    const IOobject& field,
    const word& part,
    const scalar least,
    const scalar most,
    const Range& allowed
)
{
    for (const scalar value : {least, most})
    {
        if (!allowed.has(value))
        {
            FatalErrorInFunction
                << field.instance().c_str() << '/' << field.name() << ": "
                << part << " has " << value << ", allowed: "
                << allowed.text().c_str() << exit(FatalError);
        }
    }
}


} // End namespace Foam

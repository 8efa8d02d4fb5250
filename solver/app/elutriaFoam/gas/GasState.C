/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "gas/GasState.H"
#include "fixedGradientFvPatchFields.H"
#include "surfaceFields.H"
#include "volFields.H"

namespace Foam
{

namespace
{

//- The gradient that a condition keeps from one solve to the next
template<class Type>
Field<Type>* gradient(fvPatchField<Type>& patch)
{
    auto* fixed = dynamic_cast<fixedGradientFvPatchField<Type>*>(&patch);
    return fixed ? &fixed->gradient() : nullptr;
}


template<class Type>
Field<Type>* gradient(fvsPatchField<Type>&)
{
    return nullptr;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

template<class FieldType>
void GasState::save(const fvMesh& mesh)
{
    typedef Field<typename FieldType::value_type> Values;

    const auto fields = mesh.lookupClass<FieldType>();
    forAllConstIters(fields, iter)
    {
        auto& field = const_cast<FieldType&>(*iter.val());
        if
        (
            field.writeOpt() != IOobject::AUTO_WRITE
         || field.name().ends_with("_0")
        )
        {
            continue;
        }
        const Values inside(field.primitiveField());
        auto& patches = field.boundaryFieldRef(false);
        List<Values> onPatches(patches.size()), gradients(patches.size());
        forAll(patches, patchi)
        {
            onPatches[patchi] = patches[patchi];
            if (const Values* kept = gradient(patches[patchi]))
            {
                gradients[patchi] = *kept;
            }
        }
        restorers_.push_back([=, &field]()
        {
            field.primitiveFieldRef() = inside;
            auto& patches = field.boundaryFieldRef();
            forAll(patches, patchi)
            {
                patches[patchi] == onPatches[patchi];
                if (Values* kept = gradient(patches[patchi]))
                {
                    *kept = gradients[patchi];
                }
            }
        });
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

GasState::GasState(const fvMesh& mesh)
{
    save<volScalarField>(mesh);
    save<volVectorField>(mesh);
    save<volSymmTensorField>(mesh);
    save<surfaceScalarField>(mesh);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void GasState::restore() const
{
    for (const auto& restorer : restorers_)
    {
        restorer();
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "averaging/DiffusionKernel.H"
#include "foam/foamVersion.H"
#include "fvm.H"
#include "fvcSurfaceIntegrate.H"
#include "surfaceFields.H"
#include "gaussLaplacianScheme.H"
#include "correctedSnGrad.H"
#include "foam/requireAllowed.H"
#include "linear.H"

namespace Foam
{

DiffusionKernel::DiffusionKernel(const fvMesh& mesh, const dictionary& dict)
:
    mesh_(mesh),
    asked_(-1),
    width_(0),
    steps_(dict.getOrDefault<label>("steps", 2)),
    exchangeRate_
    (
        gMax
        (
            fvc::surfaceSum(mesh.magSf()*mesh.deltaCoeffs())()
           .primitiveField()
           /mesh.V().field()
        )
    ),
    smallestCell_(cbrt(gMin(mesh.V())))
{
    requireOwnEntries(dict, ownDictionary::spreading);
    if (dict.found("width"))
    {
        ITstream& is = dict.lookup("width");
        const token first(is);
        if (first.isNumber() && first.number() >= 0)
        {
            asked_ = first.number();
        }
        else if (!(first.isWord() && first.wordToken() == "auto"))
        {
            FatalIOErrorInFunction(dict)
                << "width is " << first << ", allowed: auto or a length >= 0"
                << exit(FatalIOError);
        }
    }
    requireAllowed("steps", steps_, atLeast(1), dict);
    width_ = max(asked_, scalar(0));
}


void DiffusionKernel::adapt(const scalar largestDiameter)
{
    if (asked_ < 0)
    {
        width_ = diameters*largestDiameter;
    }
}


label DiffusionKernel::explicitSteps() const
{
    return max(steps_, label(ceil(sqr(width_)*exchangeRate_)));
}


template<class Type>
void DiffusionKernel::diffuseExplicit
(
    GeometricField<Type, fvPatchField, volMesh>& field,
    const label steps
) const
{
    const scalar diffusion = 0.5*sqr(width_)/steps;
    const labelUList& owner = mesh_.owner();
    const labelUList& neighbour = mesh_.neighbour();
    const scalarField weight
    (
        diffusion*mesh_.magSf().primitiveField()
       *mesh_.deltaCoeffs().primitiveField()
    );
    Field<Type>& values = field.primitiveFieldRef();
    Field<Type> gain(values.size());

    for (label step = 0; step < steps; ++step)
    {
        gain = Zero;
        forAll(owner, facei)
        {
            const Type flow
            (
                weight[facei]
               *(values[neighbour[facei]] - values[owner[facei]])
            );
            gain[owner[facei]] += flow;
            gain[neighbour[facei]] -= flow;
        }

        field.correctBoundaryConditions();
        forAll(mesh_.boundary(), patchi)
        {
            const fvPatch& patch = mesh_.boundary()[patchi];
            if (!patch.coupled())
            {
                continue;
            }
            const Field<Type> other
            (
                field.boundaryField()[patchi].patchNeighbourField()
            );
            const labelUList& cells = patch.faceCells();
            forAll(cells, i)
            {
                gain[cells[i]] +=
                    diffusion*patch.magSf()[i]*patch.deltaCoeffs()[i]
                   *(other[i] - values[cells[i]]);
            }
        }
        values += gain/mesh_.V().field();
    }
    field.correctBoundaryConditions();
}


template<class Type>
void DiffusionKernel::diffuseImplicit
(
    GeometricField<Type, fvPatchField, volMesh>& field
) const
{
    // (1 - width^2/(2 steps) laplacian) new = old, `steps` times
    const dimensionedScalar diffusion
    (
        "diffusion", dimArea, sqr(width_)/(2*steps_)
    );
    const fv::gaussLaplacianScheme<Type, scalar> laplacian
    (
        mesh_,
        tmp<surfaceInterpolationScheme<scalar>>(new linear<scalar>(mesh_)),
        tmp<fv::snGradScheme<Type>>(new fv::correctedSnGrad<Type>(mesh_))
    );
    const surfaceScalarField gamma
    (
        IOobject
        (
            "diffusion", mesh_.time().timeName(), mesh_,
            IOobject::NO_READ, IOobject::NO_WRITE, false
        ),
        mesh_,
        diffusion
    );

    dictionary controls;
    controls.add("solver", word("PCG"));
    controls.add("preconditioner", word("DIC"));
    controls.add("tolerance", 1e-13);
    controls.add("relTol", 1e-10);

    for (label step = 0; step < steps_; ++step)
    {
        const GeometricField<Type, fvPatchField, volMesh> old(field);
        fvMatrix<Type> equation
        (
            fvm::Sp(dimensionedScalar("one", dimless, 1), field)
          - const_cast<fv::gaussLaplacianScheme<Type, scalar>&>(laplacian)
                .fvmLaplacian(gamma, field)
         ==
            old
        );
        equation.solve(controls);
    }
}


template<class Type>
void DiffusionKernel::smooth
(
    GeometricField<Type, fvPatchField, volMesh>& field
) const
{
    if (!active())
    {
        return;
    }

    const label steps = explicitSteps();
    if (steps <= maxExplicit)
    {
        diffuseExplicit(field, steps);
        return;
    }
    const label level = SolverPerformance<Type>::debug;
    SolverPerformance<Type>::debug = 0;
    diffuseImplicit(field);
    SolverPerformance<Type>::debug = level;
}


template void DiffusionKernel::smooth(volScalarField&) const;
template void DiffusionKernel::smooth(volVectorField&) const;


} // End namespace Foam

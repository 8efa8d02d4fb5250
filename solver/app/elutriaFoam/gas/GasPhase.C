/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "gas/GasPhase.H"
#include "gas/GasClock.H"
#include "gas/scaledInflow.H"
#include "gas/startFields.H"
#include "adjustPhi.H"
#include "extrapolatedCalculatedFvPatchFields.H"
#include "fixedFluxPressureFvPatchScalarField.H"
#include "fixedValueFvPatchFields.H"
#include "foam/requireAllowed.H"
#include "processorPolyPatch.H"
#include "wallPolyPatch.H"

namespace Foam
{

namespace
{

//- Root mean square over the volume
scalar rms(const volVectorField& field)
{
    const scalarField& V = field.mesh().V();
    return std::sqrt(gSum(magSqr(field.primitiveField())*V)/gSum(V));
}


//- Is there one that it could pass?
bool hasOpening(const fvMesh& mesh)
{
    bool open = false;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        open = open || GasPhase::isOpen(patch);
    }
    return returnReduce(open, orOp<bool>());
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void GasPhase::forgetMeans()
{
    courantRate_ = meanSpeed_ = throughTime_ = -1;
}


IOobject GasPhase::fieldHeader
(
    const word& name,
    IOobject::readOption read
) const
{
    return IOobject
    (
        name, mesh_.time().timeName(), mesh_, read, IOobject::AUTO_WRITE
    );
}


tmp<volVectorField> GasPhase::reconstruct(const surfaceScalarField& flux) const
{
    auto tresult = tmp<volVectorField>::New
    (
        IOobject("reconstruct(" + flux.name() + ')', mesh_.time().timeName(), mesh_),
        mesh_,
        dimensionedVector(flux.dimensions()/dimArea, Zero),
        extrapolatedCalculatedFvPatchVectorField::typeName
    );
    vectorField& sum = tresult.ref().primitiveFieldRef();

    const labelUList& owner = mesh_.owner();
    const labelUList& neighbour = mesh_.neighbour();
    forAll(neighbour, facei)
    {
        const vector part
        (
            mesh_.Sf()[facei]*(flux[facei]/mesh_.magSf()[facei])
        );
        sum[owner[facei]] += part;
        sum[neighbour[facei]] += part;
    }
    forAll(mesh_.boundary(), patchi)
    {
        const fvPatch& patch = mesh_.boundary()[patchi];
        const fvsPatchScalarField& patchFlux = flux.boundaryField()[patchi];
        forAll(patchFlux, i)
        {
            sum[patch.faceCells()[i]] +=
                patch.Sf()[i]*(patchFlux[i]/patch.magSf()[i]);
        }
    }
    sum = faceSumInverse_ & sum;
    tresult.ref().correctBoundaryConditions();
    return tresult;
}


tmp<fvVectorMatrix> GasPhase::momentum(const volScalarField& coefficient)
{
    return
        fvm::ddt(alpha_, U_) + fvm::div(alphaPhi_, U_)
      - fvm::Sp(fvc::ddt(alpha_) + fvc::div(alphaPhi_), U_)
      + turbulence_->divDevReff(U_)
     ==
      - fvm::Sp(coefficient/rho_, U_);
}


void GasPhase::correctPressure
(
    const fvVectorMatrix& momentum,
    const volScalarField& rAU,
    const surfaceScalarField& rAUf,
    const surfaceScalarField& forceFlux,
    const surfaceScalarField& inletDrag
)
{
    volVectorField HbyA(constrainHbyA(rAU*momentum.H(), U_, p_));
    surfaceScalarField phiHbyA
    (
        "phiHbyA",
        fvc::flux(HbyA) + alphaf_*rAUf*fvc::ddtCorr(U_, phi_)
    );
    if (hasSources_)
    {
        // As rAUf, so that both sides of a resistance's edge agree
        const surfaceScalarField flux(rAUf*fvc::flux(momentum.H()));
        phiHbyA.primitiveFieldRef() +=
            flux.primitiveField() - fvc::flux(HbyA)().primitiveField();
    }
    if (p_.needReference() && hasOpening(mesh_))
    {
        adjustPhi(phiHbyA, U_, p_);
    }
    phiHbyA += forceFlux - inletDrag;
    constrainPressure(p_, U_, phiHbyA, rAUf);

    while (pimple_.correctNonOrthogonal())
    {
        fvScalarMatrix pressure
        (
            fvm::laplacian(alphaf_*rAUf, p_)
         ==
            fvc::ddt(alpha_) + fvc::div(alphaf_*phiHbyA)
        );
        pressure.setReference(pRefCell_, pRefValue_);
        pressure.solve
        (
            mesh_.solver(p_.select(pimple_.finalInnerIter()))
        );

        if (pimple_.finalNonOrthogonalIter())
        {
            const surfaceScalarField pressureFlux(pressure.flux()/alphaf_);
            phi_ = phiHbyA - pressureFlux;
            alphaPhi_ = alphaf_*phi_;
            p_.relax();
            U_ =
                HbyA
              + rAU*reconstruct((forceFlux - pressureFlux)/rAUf);
            U_.correctBoundaryConditions();
            sources_.correct(U_);
        }
    }
}


tmp<surfaceScalarField> GasPhase::inletDrag
(
    const volScalarField& coefficient,
    const surfaceScalarField& rAUf
) const
{
    auto tdrag = tmp<surfaceScalarField>::New
    (
        IOobject("inletDrag", mesh_.time().timeName(), mesh_),
        mesh_,
        dimensionedScalar(dimVolume/dimTime, Zero)
    );
    surfaceScalarField::Boundary& drag = tdrag.ref().boundaryFieldRef();
    forAll(drag, patchi)
    {
        if (isA<fixedFluxPressureFvPatchScalarField>(p_.boundaryField()[patchi]))
        {
            drag[patchi] =
                rAUf.boundaryField()[patchi]
               *coefficient.boundaryField()[patchi]
               /rho_.boundaryField()[patchi]
               *(
                    U_.boundaryField()[patchi]
                  & mesh_.Sf().boundaryField()[patchi]
                );
        }
    }
    return tdrag;
}


void GasPhase::reportContinuity()
{
    const volScalarField error(fvc::ddt(alpha_) + fvc::div(alphaPhi_));
    const scalar dt = mesh_.time().deltaTValue();
    const scalar local =
        dt*fvc::domainIntegrate(mag(error)).value()/volume_;
    const scalar global =
        dt*fvc::domainIntegrate(error).value()/volume_;
    cumulativeContinuityError_ += global;

    Info<< "time step continuity errors : sum local = " << local
        << ", global = " << global
        << ", cumulative = " << cumulativeContinuityError_ << endl;
}


void GasPhase::keepBoundaries()
{
    solvedU_.setSize(mesh_.boundary().size());
    solvedP_.setSize(mesh_.boundary().size());
    forAll(mesh_.boundary(), patchi)
    {
        solvedU_[patchi] = U_.boundaryField()[patchi];
        solvedP_[patchi] = p_.boundaryField()[patchi];
    }
    boundaryChange_ = 0;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

GasPhase::GasPhase
(
    Time& runTime,
    fvMesh& mesh,
    pimpleControl& pimple,
    const dimensionedVector& g
)
:
    runTime_(runTime),
    mesh_(mesh),
    pimple_(pimple),
    g_(g),
    name_
    (
        IOdictionary
        (
            IOobject
            (
                "transportProperties",
                mesh.time().constant(),
                mesh,
                IOobject::MUST_READ,
                IOobject::NO_WRITE,
                false
            )
        ).get<word>("continuousPhase")
    ),
    U_(fieldHeader(IOobject::groupName("U", name_), IOobject::MUST_READ), mesh),
    p_(fieldHeader("p", IOobject::MUST_READ), mesh),
    phi_
    (
        fieldHeader
        (
            IOobject::groupName("phi", name_), IOobject::READ_IF_PRESENT
        ),
        fvc::flux(U_)
    ),
    transport_(U_, phi_),
    rho_
    (
        fieldHeader(IOobject::groupName("rho", name_), IOobject::NO_READ),
        mesh,
        dimensionedScalar
        (
            IOobject::groupName("rho", name_), dimDensity, transport_
        )
    ),
    mu_
    (
        fieldHeader(IOobject::groupName("mu", name_), IOobject::NO_READ),
        rho_*transport_.nu()
    ),
    alpha_
    (
        fieldHeader
        (
            IOobject::groupName("alpha", name_), IOobject::READ_IF_PRESENT
        ),
        mesh,
        dimensionedScalar("one", dimless, 1)
    ),
    alphaf_("alphaf", fvc::interpolate(alpha_)),
    alphaPhi_
    (
        fieldHeader(IOobject::groupName("alphaPhi", name_), IOobject::NO_READ),
        alphaf_*phi_
    ),
    turbulence_(nullptr),
    sources_(fv::options::New(mesh)),
    hasSources_(static_cast<const PtrList<fv::option>&>(sources_).size()),
    sourcesVary_(false),
    pRefCell_(0),
    pRefValue_(0),
    faceSumInverse_
    (
        inv
        (
            fvc::surfaceSum(mesh.Sf()*mesh.Sf()/mesh.magSf())().primitiveField()
        )
    ),
    cumulativeContinuityError_(0),
    courantRate_(-1),
    meanSpeed_(-1),
    throughTime_(-1),
    volume_(gSum(mesh.V())),
    meanDensity_(gAverage(rho_.primitiveField())),
    boundaryChange_(0),
    extraSteps_(0)
{
    requireAllowed
    (
        rho_.name(), gMin(rho_.primitiveField()), above(0, 1e6), transport_
    );
    requireAllowed
    (
        "nu", gMin(transport_.nu()().primitiveField()), above(0, 1e6), transport_
    );
    requireDimensions(U_, dimVelocity);
    requireDimensions(p_, dimPressure/dimDensity);
    requireDimensions(phi_, dimVolume/dimTime);
    requireDimensions(alpha_, dimless);
    setRefCell(p_, pimple.dict(), pRefCell_, pRefValue_);
    mesh.setFluxRequired(p_.name());
    updateInlets();
    keepBoundaries();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void GasPhase::startTurbulence()
{
    requireSoundStart();
    const StartFields fields(mesh_, name_);
    // From here on kept: the first step's change counts too
    alpha_.oldTime();

    turbulence_ = turbulenceModelType::New
    (
        alpha_, geometricOneField(), U_, alphaPhi_, phi_, transport_
    );
    fields.requireSound();
    checkSources();
}


void GasPhase::correctTransport()
{
    transport_.correct();
    mu_ = rho_*transport_.nu();
    if (nu_.valid())
    {
        *nu_ = transport_.nu();
    }
}


void GasPhase::setVoidFraction(const volScalarField& fraction)
{
    alpha_ = fraction;
    alpha_.correctBoundaryConditions();
    alphaf_ = fvc::interpolate(alpha_);
    alphaPhi_ = alphaf_*phi_;
}


void GasPhase::setSolidFraction(const volScalarField& solid)
{
    setVoidFraction((1.0 - solid)());
}


void GasPhase::forgetVolumeChange()
{
    alpha_.oldTime() == alpha_;
}


void GasPhase::setArrived(const volScalarField& solid)
{
    volScalarField& before = alpha_.oldTime();
    const scalar least = min(gMin(alpha_), gMin(before));
    before.primitiveFieldRef() = min
    (
        max(before.primitiveField() - solid.primitiveField(), least),
        scalar(1)
    );
    before.correctBoundaryConditions();
}


void GasPhase::solve
(
    const volVectorField& force,
    const volScalarField& coefficient,
    const scalar dt
)
{
    GasClock clock(runTime_);
    clock.setStep(dt);
    forgetMeans();

    while (pimple_.loop())
    {
        tmp<fvVectorMatrix> equation(momentum(coefficient));
        fvVectorMatrix& UEqn = equation.ref();
        tmp<volVectorField> tforce(force);
        if (hasSources_)
        {
            tforce = force + addSources(UEqn);
        }
        UEqn.relax();
        sources_.constrain(UEqn);

        const volScalarField rAU(1.0/UEqn.A());
        const surfaceScalarField rAUf
        (
            "Dp",
            hasSources_
          ? 1.0/fvc::interpolate(UEqn.A()) : fvc::interpolate(rAU)
        );
        // On faces the force loses a little of its sum where rAU varies: that
        // comes back evenly, so that the gas gets what the particles gave
        surfaceScalarField forceFlux
        (
            hasSources_ ? rAUf*fvc::flux(tforce()) : fvc::flux(rAU*force)
        );
        const dimensionedVector missing
        (
            fvc::domainIntegrate(tforce() - reconstruct(forceFlux/rAUf))
           /dimensionedScalar("volume", dimVolume, volume_)
        );
        forceFlux += rAUf*((g_ + missing) & mesh_.Sf());
        const surfaceScalarField inletFlux(inletDrag(coefficient, rAUf));

        if (pimple_.momentumPredictor())
        {
            Foam::solve
            (
                UEqn
             ==
                reconstruct
                (
                    forceFlux/rAUf - fvc::snGrad(p_)*mesh_.magSf()
                )
            );
        }
        while (pimple_.correct())
        {
            correctPressure(UEqn, rAU, rAUf, forceFlux, inletFlux);
        }
        if (pimple_.turbCorr())
        {
            turbulence_->correct();
        }
    }
    reportContinuity();
    keepBoundaries();
}


wordList GasPhase::scaleInflow(const scalar factor)
{
    DynamicList<word> others;
    forAll(mesh_.boundary(), patchi)
    {
        const fvPatch& patch = mesh_.boundary()[patchi];
        if (isA<processorPolyPatch>(patch.patch()))
        {
            break;      // these are each processor's own, and come last
        }
        const fvPatchVectorField& U = U_.boundaryField()[patchi];
        const scalar entering =
            patch.coupled() ? 0 : gSum(max(-(U & patch.Sf()), scalar(0))());
        if (entering > 0 && isA<fixedValueFvPatchVectorField>(U))
        {
            autoPtr<fvPatchVectorField> scaled(scaledInflow(U, factor));
            if (scaled)
            {
                U_.boundaryFieldRef(false).set(patchi, scaled.ptr());
            }
            else
            {
                others.append(patch.name());
            }
        }
    }
    return wordList(std::move(others));
}


void GasPhase::followBoundaries()
{
    scalar change = 0, rise = 0;
    forAll(mesh_.boundary(), patchi)
    {
        fvPatchVectorField& U = U_.boundaryFieldRef(false)[patchi];
        if (isA<fixedValueFvPatchVectorField>(U))
        {
            U.evaluate();
            change = max(change, max(mag(U - solvedU_[patchi])));
        }
        fvPatchScalarField& p = p_.boundaryFieldRef(false)[patchi];
        if (isA<fixedValueFvPatchScalarField>(p))
        {
            p.evaluate();
            rise = max(rise, max(mag(p - solvedP_[patchi])));
        }
    }
    boundaryChange_ = returnReduce(max(change, sqrt(rise)), maxOp<scalar>());
    if (sourcesVary_)
    {
        boundaryChange_ = GREAT;
    }
}


scalar GasPhase::boundaryChange() const
{
    return boundaryChange_ > 0 ? boundaryChange_/meanSpeed() : 0;
}


scalar GasPhase::relative(const volVectorField& change) const
{
    return rms(change)/meanSpeed();
}


scalar GasPhase::courantRate() const
{
    if (courantRate_ < 0)
    {
        const scalarField through(fvc::surfaceSum(mag(phi_))().primitiveField());
        courantRate_ = max(0.5*gMax(through/mesh_.V().field()), VSMALL);
    }
    return courantRate_;
}


scalar GasPhase::inflow(const surfaceScalarField& phi)
{
    scalar sum = 0;
    forAll(phi.boundaryField(), patchi)
    {
        if (!phi.mesh().boundary()[patchi].coupled())
        {
            sum -= Foam::sum(min(phi.boundaryField()[patchi], scalar(0)));
        }
    }
    return returnReduce(sum, sumOp<scalar>());
}


scalar GasPhase::throughTime() const
{
    if (throughTime_ < 0)
    {
        const scalar entering = inflow(phi_);
        throughTime_ = entering > VSMALL ? volume_/entering : GREAT;
    }
    return throughTime_;
}


scalar GasPhase::meanSpeed() const
{
    if (meanSpeed_ < 0)
    {
        meanSpeed_ = max(rms(U_), VSMALL);
    }
    return meanSpeed_;
}


} // End namespace Foam

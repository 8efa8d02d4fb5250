/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    GasPhase's way through a window of time: in how many steps, taken again
    where the result is not sound.

\*---------------------------------------------------------------------------*/

#include "gas/GasPhase.H"
#include "gas/GasClock.H"
#include "gas/GasState.H"
#include "gas/startFields.H"
#include "foam/digits.H"
#include "foam/UnsoundStep.H"
#include "foam/Warnings.H"
#include "profiling.H"

namespace Foam
{

namespace
{

//- Above it the gas is no longer the incompressible gas that was asked for
constexpr scalar largestSpeed = 1000;   // m/s

//- Cells over which viscosity may diffuse momentum in a step, squared: PISO
//  splits pressure and velocity, and loses momentum beyond
constexpr scalar largestDiffusion = 10;

//- Parts of a window: beyond them its gas is nearly steady anyway
constexpr label mostSteps = 64;

//- In which a gas at rest begins to flow where pressure drives it
constexpr label mostStepsToStart = 1000;

//- Share of a passage that is a step then
constexpr scalar largestPassage = 0.1;

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

tmp<volVectorField> GasPhase::solveInSteps
(
    const volVectorField& force,
    const volScalarField& coefficient,
    const volScalarField& alphaStart,
    const volScalarField& alphaEnd,
    const scalar dt,
    const label steps
)
{
    const volVectorField before("before", U_);
    if (steps == 1)
    {
        solve(force, coefficient, dt);
        return U_ - before;
    }

    GasClock clock(runTime_);
    tmp<volVectorField> tmean(U_ - before);
    setVoidFraction(alphaStart);
    for (label step = 1; step <= steps && unsound().empty(); ++step)
    {
        // An index that the run itself does not reach
        clock.setIndex(labelMax/2 + extraSteps_++ % (labelMax/2));
        const scalar done = scalar(step)/steps;
        setVoidFraction(((1 - done)*alphaStart + done*alphaEnd)());
        solve(force, coefficient, dt/steps);
        tmean.ref() += (U_ - before)/scalar(steps);
    }
    setVoidFraction(alphaEnd);
    return tmean;
}


void GasPhase::warnOfViscosity(const scalar dt) const
{
    const scalarField diffused
    (
        turbulence_->nuEff()().primitiveField()*dt
       /pow(mesh_.V().field(), 2.0/3.0)
    );
    const scalar most = gMax(diffused);
    if (most > largestDiffusion)
    {
        Warnings::add
        ({
            "viscosity", "viscosity diffuses momentum over many cells in a step",
            threeDigits(sqrt(most)) + " cells in a gas step of " + threeDigits(dt)
          + " s, allowed: " + threeDigits(sqrt(largestDiffusion)),
            "set deltaT to at most " + threeDigits(largestDiffusion/most*dt) + " s",
            most
        });
    }
}


void GasPhase::finishLoops()
{
    while (pimple_.correctNonOrthogonal())
    {}
    while (pimple_.correct())
    {}
    while (pimple_.loop())
    {}
}


label GasPhase::unsoundCell() const
{
    forAll(U_, celli)
    {
        if
        (
            !(magSqr(U_[celli]) < sqr(largestSpeed))
         || !(mag(p_[celli]) < GREAT)
        )
        {
            return celli;
        }
    }
    return -1;
}


void GasPhase::requireSoundStart() const
{
    requireWithin(U_, below(largestSpeed));
    requireWithin(p_, below(GREAT));
}


string GasPhase::unsound() const
{
    label cell = unsoundCell();
    label finder = cell < 0 ? Pstream::nProcs() : Pstream::myProcNo();
    reduce(finder, minOp<label>());
    if (finder == Pstream::nProcs())
    {
        return "";
    }

    const bool mine = finder == Pstream::myProcNo();
    point place(mine ? mesh_.C()[cell] : point::zero);
    scalar speed = mine ? mag(U_[cell]) : 0;
    cell = mine ? cell : 0;
    reduce(place, sumOp<vector>());
    reduce(speed, sumOp<scalar>());
    reduce(cell, sumOp<label>());

    OStringStream text;
    text<< "the gas diverged at time " << mesh_.time().timeName()
        << " s in cell " << cell << " at " << place << " (speed " << speed
        << " m/s, allowed: " << largestSpeed << ")";
    return text.str();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

tmp<volVectorField> GasPhase::advance
(
    const GasExchange& particles,
    const scalar dt,
    const scalar courant,
    const label retakes
)
{
    addProfiling(gas, "elutria::gas");

    // The explicit part at the velocity the particles saw
    const volVectorField force
    (
        (particles.force + particles.coefficient*U_)/rho_
    );
    const volScalarField alphaEnd("alphaEnd", alpha_);
    const volScalarField alphaStart("alphaStart", alpha_.oldTime());
    const GasState before(mesh_);

    const scalar asked = dt*courantRate()/courant*(1 - SMALL);
    label steps = label(max(scalar(1), ceil(min(asked, scalar(mostSteps)))));
    if (asked > mostSteps)
    {
        Warnings::add
        ({
            "gasCourant", "the gas crosses many cells in each part of its step",
            threeDigits(asked*courant/steps) + " cells in each of the "
          + std::to_string(steps) + " parts of " + threeDigits(dt)
          + " s, allowed: " + threeDigits(courant) + " (gasCourant)",
            "set deltaT to at most " + threeDigits(dt*steps/asked) + " s", asked
        });
    }
    warnOfViscosity(dt/steps);
    for (label attempt = 0; ; ++attempt)
    {
        tmp<volVectorField> change;
        string trouble;
        try
        {
            change = solveInSteps
            (
                force, particles.coefficient, alphaStart, alphaEnd, dt, steps
            );
            trouble = unsound();
        }
        catch (const error& broken)
        {
            // OpenFOAM breaks off where an equation's residual is not a number
            finishLoops();
            trouble = unsound();
            if (trouble.empty())
            {
                throw;
            }
        }
        if (trouble.empty())
        {
            return change;
        }

        before.restore();
        forgetMeans();
        if (attempt == retakes)
        {
            throw UnsoundStep
            (
                trouble + ", also after " + Foam::name(retakes)
              + " retakes with smaller steps; likely causes: an inflow or a"
                " pressure that is not meant, cells too coarse or of poor"
                " quality, or a void fraction near its minimum"
            );
        }
        steps *= 2;
        Warnings::add
        ({
            "gasRetaken", "a step of the gas was taken again",
            trouble + ", from before in " + std::to_string(steps) + " steps",
            "set deltaT smaller, or look at the mesh and the inflow there",
            scalar(steps)
        });
    }
}


scalar GasPhase::startStep(const scalar courant) const
{
    // From rest the gas cannot become faster than pressure makes it. The
    // pressure of an inlet follows its velocity from step to step: that is
    // stable where a step is a part of the passage.
    const scalar fastest = sqrt(2*pressureDrop()) + VSMALL;
    const scalar smallest = cbrt(gMin(mesh_.V().field()));
    return min
    (
        courant/max(courantRate(), fastest/smallest),
        largestPassage*mesh_.bounds().mag()/fastest
    );
}


scalar GasPhase::converge
(
    const GasExchange& none,
    const scalar courant,
    const scalar tolerance,
    const label retakes
)
{
    scalar through = throughTime();
    const bool fixed = inflowIsFixed();
    if (through >= GREAT && !isDriven())
    {
        return GREAT;
    }

    GasClock clock(runTime_);
    const label index = runTime_.timeIndex();

    // Ten passes of the gas are enough where it settles at all
    scalar change = GREAT, passed = 0;
    label steps = 0;
    while (change > tolerance && passed < 10*through)
    {
        const scalar dt = min
        (
            fixed ? courant/courantRate() : startStep(courant), through
        );
        clock.setIndex(index + ++steps);
        clock.setStep(dt);

        const scalar moved = relative(advance(none, dt, GREAT, retakes)());
        if (!fixed)
        {
            // A gas that pressure drives finds its flow while it settles
            through = throughTime();
            if (through >= GREAT && steps > mostStepsToStart)
            {
                break;
            }
        }
        change = moved*through/dt;
        passed += dt;
    }

    Info<< "elutria: gas settled in " << steps << " steps, "
        << threeDigits(passed/through).c_str() << " passes; change per pass "
        << threeDigits(change).c_str()
        << (change > tolerance ? " (not below " : " (below ") << tolerance
        << ")" << endl;
    if (change > tolerance)
    {
        Warnings::add
        ({
            "gasNotSettled", "the gas has not settled without particles",
            "it changes by " + threeDigits(100*change) + " % a pass after "
          + threeDigits(passed/through) + " passes, allowed: "
          + threeDigits(100*tolerance) + " %",
            "it is solved in every step, which takes longer; upwind for k and "
            "epsilon, a finer mesh or a steadier inlet may let it settle",
            change
        });
    }
    return change;
}


} // End namespace Foam

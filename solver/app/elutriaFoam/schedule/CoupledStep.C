/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "schedule/CoupledStep.H"
#include "foam/digits.H"
#include "foam/Warnings.H"
#include "foam/requireAllowed.H"
#include "profiling.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void CoupledStep::solveGas()
{
    const bool continued = cloud_.solidFractionIsOfWindow();
    setSolidFraction(gas_, cloud_);
    if (continued && !cloud_.feedDisplacesGas())
    {
        gas_.setArrived(cloud_.arrivedFraction());
    }
    else if (!continued)
    {
        gas_.forgetVolumeChange();
    }
    const GasExchange exchange(cloud_.exchange());
    plan_.account(ScenePlan::partExchange);

    const scalar window = cloud_.window();
    gas_.correctTransport();
    try
    {
        const volVectorField change
        (
            gas_.advance(exchange, window, plan_.courant(), plan_.retakes())
        );
        cloud_.correct(change);
        plan_.gasSolved(window, gas_.relative(change));
    }
    catch (const UnsoundStep&)
    {
        cloud_.drop();
        writeLastSound();
        throw;
    }
    plan_.account(ScenePlan::partGas);
}


void CoupledStep::writeLastSound()
{
    if (runTime_.timeIndex() == runTime_.startTimeIndex())
    {
        Warnings::write();
    }
    else
    {
        AtomicTime(runTime_).write([&]()
        {
            cloud_.writeState();
            Warnings::write();
            runTime_.writeNow();
        });
    }
    Info<< "elutria: last sound state written, time " << runTime_.timeName()
        << endl;
    returnReduce(true, andOp<bool>());      // all have written
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

CoupledStep::CoupledStep
(
    Time& runTime,
    GasPhase& gas,
    ElutriaCloud& cloud,
    ScenePlan& plan
)
:
    runTime_(runTime),
    gas_(gas),
    cloud_(cloud),
    plan_(plan)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void CoupledStep::moveParticles()
{
    try
    {
        cloud_.evolve();
    }
    catch (const UnsoundStep&)
    {
        runTime_.setTime
        (
            runTime_.value() - runTime_.deltaTValue(), runTime_.timeIndex() - 1
        );
        cloud_.takeBack();
        writeLastSound();
        throw;
    }
}


void CoupledStep::settleGas()
{
    if (plan_.gasNeeded(cloud_))
    {
        solveGas();
        return;
    }
    if (runTime_.writeTime())
    {
        setSolidFraction(gas_, cloud_);
    }
    cloud_.drop();
    plan_.account(ScenePlan::partExchange);
}


void CoupledStep::write(const AtomicTime& atomic, const bool last)
{
    addProfiling(write, "elutria::write");
    atomic.write([&]()
    {
        cloud_.writeState();
        plan_.write();
        Warnings::write();
        if (last)
        {
            runTime_.writeAndEnd();
        }
        else
        {
            runTime_.write();
        }
    });
    runTime_.setTime(std::stod(runTime_.timeName()), runTime_.timeIndex());
}


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void setSolidFraction(GasPhase& gas, ElutriaCloud& cloud)
{
    const dictionary& constants =
        cloud.particleProperties().subDict("constantProperties");
    const scalar largest = readAllowed(constants, "alphaMax", above(0, 1));

    gas.setSolidFraction(cloud.solidFraction(largest));
    if (cloud.excessVolume() > 0)
    {
        Warnings::add
        ({
            "alphaMax", "the solid fraction exceeds alphaMax in some cells",
            "the gas does not see " + threeDigits(cloud.excessVolume())
          + " m3 of solids",
            "lower the feed's loading, or raise alphaMax of constantProperties",
            cloud.excessVolume()
        });
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "schedule/ScenePlan.H"
#include "foam/digits.H"
#include "foam/foamVersion.H"
#include "globalMeshData.H"
#include "IOField.H"
#include "foam/ownEntries.H"
#include "foam/requireAllowed.H"

namespace Foam
{

namespace
{

dictionary readSettings(const Time& runTime)
{
    return IOdictionary
    (
        IOobject
        (
            "scenePlan",
            runTime.system(),
            runTime,
            IOobject::READ_IF_PRESENT,
            IOobject::NO_WRITE,
            false
        )
    );
}


scalar readPositive
(
    const dictionary& dict,
    const word& entry,
    const scalar fallback
)
{
    const scalar value = dict.getOrDefault<scalar>(entry, fallback);
    requireAllowed(entry, value, above(0), dict);
    return value;
}

IOobject stateHeader
(
    const fvMesh& mesh,
    const word& name,
    const IOobject::readOption read
)
{
    return IOobject
    (
        name, mesh.time().timeName(), "uniform", mesh, read,
        IOobject::NO_WRITE, false
    );
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void ScenePlan::readState()
{
    const fvMesh& mesh = gas_.U().mesh();
    const IOField<vector> force
    (
        stateHeader(mesh, "gasForce", IOobject::READ_IF_PRESENT)
    );
    const IOField<scalar> volume
    (
        stateHeader(mesh, "gasSolids", IOobject::READ_IF_PRESENT)
    );
    const label blocks = lastLoad_.force.size();
    if (force.size() == blocks && volume.size() == blocks)
    {
        lastLoad_ = {force, volume};
        const IOdictionary solves
        (
            stateHeader(mesh, "gasSolves", IOobject::MUST_READ)
        );
        interval_ = solves.get<label>("interval");
        flow_.restore(solves.getOrDefault<word>("flow", flow_.name()));
    }
}


ScenePlan::choice ScenePlan::readChoice
(
    const dictionary& dict,
    const word& entry
)
{
    const word value(dict.getOrDefault<word>(entry, "auto"));
    if (value == "auto")
    {
        return choice::automatic;
    }
    if (value == "on" || value == "yes" || value == "true")
    {
        return choice::on;
    }
    if (value != "no" && value != "false")
    {
        requireAllowed(entry, value, wordList({"auto", "on", "off"}), dict);
    }
    return choice::off;
}


void ScenePlan::makeBlocks()
{
    const fvMesh& mesh = gas_.U().mesh();
    const boundBox box(mesh.bounds());
    const scalar edge =
        cbrt(512*gSum(mesh.V())/mesh.globalData().nTotalCells());

    Vector<label>& counts = blocks_;
    for (direction axis = 0; axis < vector::nComponents; ++axis)
    {
        counts[axis] = max(label(1), label(ceil(box.span()[axis]/edge)));
    }
    blockOf_.resize(mesh.nCells());
    forAll(blockOf_, celli)
    {
        Vector<label> place;
        for (direction axis = 0; axis < vector::nComponents; ++axis)
        {
            const scalar share =
                (mesh.C()[celli][axis] - box.min()[axis])
               /max(box.span()[axis], VSMALL);
            place[axis] = min
            (
                max(label(share*counts[axis]), label(0)), counts[axis] - 1
            );
        }
        blockOf_[celli] =
            place.x() + counts.x()*(place.y() + counts.y()*place.z());
    }
    const label blocks = counts.x()*counts.y()*counts.z();
    lastLoad_ = {vectorField(blocks, Zero), scalarField(blocks, Zero)};
    load_ = lastLoad_;
}


void ScenePlan::findFlowAxis()
{
    const volVectorField& U = gas_.U();
    const vector flow(gSum((U.primitiveField()*U.mesh().V())()));
    flowAxis_ = 0;
    for (direction axis = 1; axis < vector::nComponents; ++axis)
    {
        if (mag(flow[axis]) > mag(flow[flowAxis_]))
        {
            flowAxis_ = axis;
        }
    }
    flowsBack_ = flow[flowAxis_] < 0;
}


ScenePlan::Load ScenePlan::loadBy(const ElutriaCloud& cloud) const
{
    const label blocks = lastLoad_.force.size();
    Load load{vectorField(blocks, Zero), scalarField(blocks, Zero)};
    cloud.forEachForceOnGas([&](const label celli, const vector& force)
    {
        load.force[blockOf_[celli]] += force;
    });
    for (const StockParcel& p : cloud)
    {
        load.volume[blockOf_[p.cell()]] += p.nParticle()*p.volume();
    }
    Pstream::listCombineGather(load.force, plusEqOp<vector>());
    elutriaBroadcast(load.force);
    Pstream::listCombineGather(load.volume, plusEqOp<scalar>());
    elutriaBroadcast(load.volume);
    return load;
}


scalar ScenePlan::gatheredForce(const vectorField& force) const
{
    const label layers = blocks_[flowAxis_];
    const label stride =
        flowAxis_ == vector::X ? 1
      : flowAxis_ == vector::Y ? blocks_.x()
      : blocks_.x()*blocks_.y();

    scalar gathered = 0;
    forAll(force, first)
    {
        if ((first/stride) % layers > 0)
        {
            continue;
        }
        vector passed(Zero);
        for (label k = 0; k < layers; ++k)
        {
            const label layer = flowsBack_ ? layers - 1 - k : k;
            passed += force[first + layer*stride];
            gathered += mag(passed);
        }
    }
    return gathered/layers;
}


scalar ScenePlan::loadChange() const
{
    const scalar force = gatheredForce(load_.force - lastLoad_.force);
    const scalar volume = sum(mag(load_.volume - lastLoad_.volume));
    return
        max
        (
            force*gas_.throughTime()/(gas_.meanDensity()*gas_.meanSpeed()),
            volume
        )
       /gas_.volume();
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

ScenePlan::ScenePlan(const GasPhase& gas, const Time& runTime)
:
    gas_(gas),
    basis_(gasBasis::start),
    tolerance_(readPositive(readSettings(runTime), "gasTolerance", 0.01)),
    flow_(settledTolerance(), gas.resolvesEddies()),
    interval_(1),
    toldInterval_(1),
    since_(0),
    solves_(0),
    sleeps_(0),
    largestSpared_(0),
    seconds_(scalar(0)),
    lapStart_(clock::now()),
    steps_(0)
{
    makeBlocks();
    findFlowAxis();
    const dictionary dict(readSettings(runTime));
    requireOwnEntries(dict, ownDictionary::scenePlan);
    gasChoice_ = readChoice(dict, "gas");
    convergeGas_ = readChoice(dict, "convergeGas") != choice::off;
    courant_ = readPositive(dict, "gasCourant", 5);
    collisionsPerStep_ = readPositive(dict, "collisionsPerStep", 0.05);
    retakes_ = dict.getOrDefault<label>("retakes", 5);
    requireAllowed("retakes", retakes_, atLeast(0), dict);
    readState();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

scalar ScenePlan::largestStep(const ElutriaCloud& cloud) const
{
    if (!cloud.feed() || !cloud.contacts())
    {
        return GREAT;
    }
    const elutria::laws::GasStream gas(stream(*cloud.feed()));
    return elutria::laws::collisionStep
    (
        expect(*cloud.feed(), gas), gas, collisionsPerStep_
    );
}


bool ScenePlan::gasDue(const Time& runTime, const scalar window)
{
    if (gasChoice_ != choice::automatic)
    {
        return gasChoice_ == choice::on;
    }

    if (gas_.boundaryChange() > tolerance_)
    {
        flow_.disturbed();
    }

    // At write times the pending exchange is settled, so that a restart
    // finds nothing open
    const scalar next = window + runTime.deltaTValue();
    return
        ++since_ >= interval_
     || !flow_.steady()
     || next*gas_.courantRate() > courant_
     || runTime.writeTime();
}


bool ScenePlan::gasNeeded(const ElutriaCloud& cloud)
{
    if (gasChoice_ == choice::on)
    {
        return true;
    }

    load_ = loadBy(cloud);
    const scalar spared = loadChange();

    since_ = 0;
    if (flow_.steady() && spared < tolerance_)
    {
        ++sleeps_;
        largestSpared_ = max(largestSpared_, spared);
        return false;
    }
    return true;
}


bool ScenePlan::settles(const ElutriaCloud& cloud) const
{
    return convergeGas_ && cloud.feed() && cloud.isEmpty();
}


void ScenePlan::gasSettled(const scalar change)
{
    basis_ = gasBasis::settled;
    flow_.settled(change);
    account(partGas);
}


void ScenePlan::gasSolved(const scalar window, const scalar change)
{
    ++solves_;
    since_ = 0;
    flow_.solved(window/gas_.throughTime(), change, loadChange());
    if (flow_.steady() || flow_.watchBegins())
    {
        lastLoad_ = load_;
    }
    findFlowAxis();

    if (!flow_.steady())
    {
        return;
    }
    if (change < 0.5*tolerance_)
    {
        interval_ = min(2*interval_, label(1024));
    }
    else if (change > tolerance_)
    {
        interval_ = max(interval_/2, label(1));
    }
    if (interval_ >= 8*toldInterval_ || 8*interval_ <= toldInterval_)
    {
        toldInterval_ = interval_;
        Info<< "Scene plan: the gas is now due every " << interval_
            << " steps, its velocity changed by " << percent(change).c_str() << endl;
    }
}


void ScenePlan::write() const
{
    if (gasChoice_ != choice::automatic)
    {
        return;
    }
    const fvMesh& mesh = gas_.U().mesh();
    IOField<vector>
    (
        stateHeader(mesh, "gasForce", IOobject::NO_READ), lastLoad_.force
    ).write();
    IOField<scalar>
    (
        stateHeader(mesh, "gasSolids", IOobject::NO_READ), lastLoad_.volume
    ).write();
    IOdictionary solves(stateHeader(mesh, "gasSolves", IOobject::NO_READ));
    solves.add("interval", interval_);
    solves.add("flow", word(flow_.name()));
    solves.regIOobject::write();
}


void ScenePlan::account(const part p)
{
    const clock::time_point now = clock::now();
    seconds_[p] += std::chrono::duration<scalar>(now - lapStart_).count();
    lapStart_ = now;
}


} // End namespace Foam

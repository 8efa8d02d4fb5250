/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Application
    elutriaFoam

Description
    Gas with a cloud of colliding particles, for air classification: transient
    volume-averaged incompressible gas (PIMPLE), two-way exchange of momentum,
    particles moved by Elutria's contact engine. Reads what DPMFoam reads, and
    constant/feed.

\*---------------------------------------------------------------------------*/

#include "cloud/ElutriaCloud.H"
#include "cloud/stockWords.H"
#include "contacts/meshDimensions.H"
#include "feed/FeedRecord.H"
#include "gas/GasPhase.H"
#include "gas/GasTable.H"
#include "gas/startFields.H"
#include "schedule/CoupledStep.H"
#include "schedule/ScenePlan.H"
#include "view/FrameWriter.H"
#include "view/LiveControl.H"
#include "run/AtomicTime.H"
#include "run/caseDictionaries.H"
#include "run/caseFiles.H"
#include "run/caseFunctions.H"
#include "run/controls.H"
#include "run/exitHandling.H"
#include "run/meshFiles.H"
#include "run/nothingLost.H"
#include "foam/foamVersion.H"
#include "foam/Warnings.H"
#include "sigFpe.H"

using namespace Foam;

namespace
{

void reportCount(const Time& runTime, const ElutriaCloud& cloud,
    const ElutriaCloud::Count& count)
{
    Info<< "elutria: time " << runTime.value();
    if (const Feed* feed = cloud.feed())
    {
        Info<< " fed " << count.fed;
        forAll(feed->products(), i)
        {
            Info<< ' ' << feed->products()[i] << ' ' << count.left[i];
        }
        Info<< " inside " << count.inside << " lost " << count.lost;
    }
    else
    {
        Info<< " inside " << count.inside;
    }
    Info<< endl;
}


//- A time step in few enough digits that the files give it back and rounding
//  does not show: a restart goes on with the same
scalar asWritten(const scalar value)
{
    OStringStream text;
    text.precision(min(10, int(IOstream::defaultPrecision())));
    text<< value;
    return std::stod(text.str());
}


//- Does the run end with this step, whether or not the feed is over?
bool isLast(const Time& runTime)
{
    return
        runTime.value()
      > runTime.endTime().value() - 0.5*runTime.deltaTValue();
}


//- A function of controlDict may stop a run before its time: what it came to then
//  is no result of the case
void requireNotStopped(const Time& runTime)
{
    const scalar end = runTime.controlDict().get<scalar>("endTime");
    if (runTime.value() < end - 0.5*runTime.deltaTValue())
    {
        FatalErrorInFunction
            << "stopped at time " << runTime.timeName() << " by a function of"
            << " system/controlDict, before feed and drain time were over;"
            << " started again, the run goes on from the last time written"
            << exit(FatalError);
    }
}


//- Say what the run would do
void announceOnly
(
    Time& runTime,
    const GasPhase& gas,
    const ElutriaCloud& cloud,
    ScenePlan& plan,
    const std::vector<caseFiles::Unused>& unused
)
{
    const bool settles = plan.settles(cloud);
    const bool known = gas.inflowIsFixed();
    const bool flowFollows = settles && !known && gas.isDriven();
    if (cloud.feed() && !flowFollows)
    {
        cloud.feed()->requireRate();
    }
    if (settles)
    {
        plan.setBasis(ScenePlan::gasBasis::inlet);
    }
    caseFunctions::tryToMake(runTime);
    plan.announce(cloud, runTime, unused);
    Info<< "elutria: planned" << endl;
}


//- The gas in which the first particle moves, and what the feed takes from it
void startGas
(
    GasPhase& gas,
    ElutriaCloud& cloud,
    ScenePlan& plan,
    const bool keepSettled
)
{
    const bool known = gas.inflowIsFixed();
    if (plan.settles(cloud))
    {
        gas.startFromSettled();
        plan.gasSettled
        (
            gas.converge
            (
                cloud.exchange(), plan.courant(), plan.settledTolerance(),
                plan.retakes()
            )
        );
        if (keepSettled)
        {
            gas.writeSettled();
        }
    }
    if (cloud.feed())
    {
        Feed& feed = cloud.mesh().lookupObjectRef<Feed>("feed");
        if (!known && !feed.gasFlowTold() && cloud.isEmpty())
        {
            feed.tellGasFlow(gas.massInflow(), gas.name());
        }
        feed.requireRate();
    }
}


//- The time of the next step, which gas and particles allow
void nextStep(Time& runTime, const GasPhase& gas, const scalar largest)
{
    #include "createTimeControls.H"
    maxDeltaT = min(maxDeltaT, largest);
    {
        const scalar CoNum = gas.courantRate()*runTime.deltaTValue();
        Info<< "Courant Number max: " << CoNum << endl;
        #include "setDeltaT.H"
    }
    runTime.setDeltaT(asWritten(runTime.deltaTValue()), false);
    ++runTime;
    Info<< "Time = " << runTime.timeName() << nl << endl;
}


//- Step by step until all particles have left, or the run's end. Returns whether
//  the feed's run is over before its end
bool march
(
    Time& runTime,
    GasPhase& gas,
    ElutriaCloud& cloud,
    ScenePlan& plan,
    const GasTable& table,
    LiveControl& control,
    FrameWriter* frames
)
{
    CoupledStep step(runTime, gas, cloud, plan);
    const scalar largestStep = plan.largestStep(cloud);

    // Do not continue a run that has already finished
    bool drained = cloud.drained(cloud.count());
    while (!drained && runTime.run())
    {
        control.follow();
        plan.resume();
        nextStep(runTime, gas, largestStep);

        // OpenFOAM's models write some of their files while they work
        autoPtr<AtomicTime> atomic
        (
            runTime.writeTime() ? new AtomicTime(runTime) : nullptr
        );

        step.moveParticles();
        plan.account(ScenePlan::partParticles);

        gas.followBoundaries();
        if (plan.gasDue(runTime, cloud.window()))
        {
            step.settleGas();
        }

        const ElutriaCloud::Count count = cloud.count();
        reportCount(runTime, cloud, count);
        drained = cloud.drained(count);
        if (drained && !atomic)
        {
            atomic.reset(new AtomicTime(runTime));
        }
        if (atomic)
        {
            step.write(*atomic, drained);
            table.write();
        }
        if (frames)
        {
            // A restart goes on with the departures after a written time, which
            // is now what its folder is called
            const bool now = atomic || isLast(runTime);
            frames->write(count, control.now(), now);
        }
        plan.countStep();
        plan.account(ScenePlan::partOutput);
    }
    return drained;
}


//- From the case's files to the end of the run
void run(const argList& args)
{
    AtomicTime::discardIncomplete(args.path());
    caseFiles::refuseFolders(args.rootPath()/args.globalCaseName());
    caseFiles::refuseHuge(args.rootPath()/args.globalCaseName());
    #include "createTime.H"
    requireSoundControlDict(runTime);
    caseFunctions::load(runTime);
    requireSoundBlocks(args.rootPath()/args.globalCaseName());

    // Divergence is found by GasPhase::unsound(), not by a trap
    sigFpe::unset(false);

    requireSoundMesh(runTime);
    #include "createMesh.H"
    requireVolumes(mesh);
    refuseWedges(mesh);
    feedRecord::requireSameMesh(mesh);
    requireSoundControl("fvSchemes", mesh.schemesDict());
    requireSoundControl("fvSolution", mesh.solutionDict());
    #include "createControl.H"
    #include "readGravitationalAcceleration.H"
    requireSoundGravity(g);
    caseFiles::refuse(mesh);
    caseFiles::refuseHugeFields(mesh);

    const word cloudName(args.opt<word>("cloud", "kinematicCloud"));
    refuseOthersModels(mesh, cloudName);

    GasPhase gas(runTime, mesh, pimple, g);
    ElutriaCloud cloud(cloudName, gas.rho(), gas.U(), gas.mu(), g);
    requireSoundControl("cloudProperties", cloud.particleProperties());
    if (cloud.feed())
    {
        CaseDrag(cloud.particleProperties()).requireShapesKnown(*cloud.feed());
    }
    setSolidFraction(gas, cloud);
    gas.startTurbulence();
    const std::vector<caseFiles::Unused> unused
    (
        caseFiles::unused(mesh, cloud.name(), gas.name())
    );

    const bool planOnly = args.found("plan");
    if (!planOnly)
    {
        Warnings::start(runTime);
    }
    const bool watched = args.found("frames") || FrameWriter::asked(runTime);
    LiveControl control(runTime, gas, cloud.feed(), watched);

    ScenePlan plan(gas, runTime);
    cloud.setRetakes(plan.retakes());
    if (planOnly)
    {
        announceOnly(runTime, gas, cloud, plan, unused);
        return;
    }
    caseFunctions::make(runTime);
    startGas(gas, cloud, plan, args.found("keepSettled"));
    const GasTable table(gas, runTime);
    table.write();

    plan.announce(cloud, runTime, unused);
    plan.account(ScenePlan::partOutput);
    std::unique_ptr<FrameWriter> frames;
    if (watched && cloud.feed())
    {
        frames.reset(new FrameWriter(runTime, gas, cloud, *cloud.feed()));
    }
    exitHandling::caseIsRead();
    Info<< "\nStarting time loop\n" << endl;

    const bool drained =
        march(runTime, gas, cloud, plan, table, control, frames.get());

    plan.report(cloud);
    if (cloud.feed())
    {
        requireNothingLost(mesh, cloud);
        if (!drained)
        {
            requireNotStopped(runTime);
        }
    }
    Info<< "elutria: finished" << endl;
}

} // End anonymous namespace


int main(int argc, char *argv[])
{
    argList::addNote
    (
        "Gas with a cloud of colliding particles, for air classification."
        " Reads the case of DPMFoam, and constant/feed."
    );
    argList::addOption
    (
        "cloud",
        "name",
        "name of the cloud (default: kinematicCloud)"
    );

    argList::addBoolOption
    (
        "keepSettled",
        "leave the empty column's settled gas in constant/settledGas: a run"
        " that finds it there, of this mesh at any velocity, starts from it"
    );

    argList::addBoolOption
    (
        "plan",
        "read the whole case, write what is expected and planned to"
        " postProcessing/plan.json, and run nothing"
    );

    argList::addBoolOption
    (
        "dictionaries",
        "print the case's dictionaries as OpenFOAM reads them, as JSON, and run"
        " nothing; #calc and #codeStream are not executed"
    );

    argList::addBoolOption
    (
        "frames",
        "for who looks on: write frames to postProcessing/frames/frames.bin, and"
        " follow postProcessing/frames/control"
    );

    #include "addCheckCaseOptions.H"
    #include "setRootCaseLists.H"
    return exitHandling::guarded([&]()
    {
        if (args.found("dictionaries"))
        {
            std::cout<< "elutria: dictionaries "
                << dictionariesAsJson(args.path()) << std::endl;
            return;
        }
        run(args);
    });
}

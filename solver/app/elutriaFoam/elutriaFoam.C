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
#include "foam/digits.H"
#include "foam/foamVersion.H"
#include "foam/Warnings.H"
#include "foam/requireAllowed.H"
#include "profiling.H"
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


//- Write the step just done, and end the run with it if it is the last
void write(Time& runTime, ElutriaCloud& cloud, const ScenePlan& plan,
    const AtomicTime& atomic, const bool last)
{
    addProfiling(write, "elutria::write");
    atomic.write([&]()
    {
        cloud.writeState();
        plan.write();
        Warnings::write();
        if (last)
        {
            runTime.writeAndEnd();
        }
        else
        {
            runTime.write();
        }
    });
    runTime.setTime(std::stod(runTime.timeName()), runTime.timeIndex());
}


//- Write the state before a step that cannot be taken, to start again from. The
//  start's own is there already, in files of the user's.
void writeLastSound(Time& runTime, ElutriaCloud& cloud)
{
    if (runTime.timeIndex() == runTime.startTimeIndex())
    {
        Warnings::write();
    }
    else
    {
        AtomicTime(runTime).write([&]()
        {
            cloud.writeState();
            Warnings::write();
            runTime.writeNow();
        });
    }
    Info<< "elutria: last sound state written, time " << runTime.timeName()
        << endl;
    returnReduce(true, andOp<bool>());      // all have written
}


//- The particles' part of a step
void moveParticles(Time& runTime, ElutriaCloud& cloud)
{
    try
    {
        cloud.evolve();
    }
    catch (const UnsoundStep&)
    {
        runTime.setTime
        (
            runTime.value() - runTime.deltaTValue(), runTime.timeIndex() - 1
        );
        cloud.takeBack();
        writeLastSound(runTime, cloud);
        throw;
    }
}


//- The void fraction that the particles leave the gas
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


//- Bring the gas up to the particles' time
void solveGas
(
    Time& runTime,
    GasPhase& gas,
    ElutriaCloud& cloud,
    ScenePlan& plan
)
{
    const bool continued = cloud.solidFractionIsOfWindow();
    setSolidFraction(gas, cloud);
    if (continued && !cloud.feedDisplacesGas())
    {
        gas.setArrived(cloud.arrivedFraction());
    }
    else if (!continued)
    {
        gas.forgetVolumeChange();
    }
    const GasExchange exchange(cloud.exchange());
    plan.account(ScenePlan::partExchange);

    const scalar window = cloud.window();
    gas.correctTransport();
    try
    {
        const volVectorField change
        (
            gas.advance(exchange, window, plan.courant(), plan.retakes())
        );
        cloud.correct(change);
        plan.gasSolved(window, gas.relative(change));
    }
    catch (const UnsoundStep&)
    {
        cloud.drop();
        writeLastSound(runTime, cloud);
        throw;
    }
    plan.account(ScenePlan::partGas);
}


//- Solve the gas, or leave it at rest
void settleGas
(
    Time& runTime,
    GasPhase& gas,
    ElutriaCloud& cloud,
    ScenePlan& plan
)
{
    if (plan.gasNeeded(cloud))
    {
        solveGas(runTime, gas, cloud, plan);
        return;
    }
    if (runTime.writeTime())
    {
        setSolidFraction(gas, cloud);
    }
    cloud.drop();
    plan.account(ScenePlan::partExchange);
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
    requireSoundControl("fvSolution", mesh.solutionDict());
    #include "createControl.H"
    #include "createTimeControls.H"
    #include "readGravitationalAcceleration.H"
    requireSoundGravity(g);
    caseFiles::refuse(mesh);
    caseFiles::refuseHugeFields(mesh);

    const word cloudName(args.opt<word>("cloud", "kinematicCloud"));
    refuseOthersModels(mesh, cloudName);

    GasPhase gas(runTime, mesh, pimple, g);
    ElutriaCloud cloud
    (
        cloudName, gas.rho(), gas.U(), gas.mu(), g
    );
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

    if (!args.found("plan"))
    {
        Warnings::start(runTime);
    }
    const bool watched = args.found("frames") || FrameWriter::asked(runTime);
    LiveControl control(runTime, gas, cloud.feed(), watched);
    std::unique_ptr<FrameWriter> frames;

    ScenePlan plan(gas, runTime);
    cloud.setRetakes(plan.retakes());
    const bool settles = plan.settles(cloud);

    const bool known = gas.inflowIsFixed();
    if (args.found("plan"))
    {
        if (cloud.feed() && !(settles && !known && gas.isDriven()))
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
        return;
    }
    caseFunctions::make(runTime);
    if (settles)
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
        if (args.found("keepSettled"))
        {
            gas.writeSettled();
        }
    }
    if (const Feed* feed = cloud.feed())
    {
        if (!known && !feed->gasFlowTold() && cloud.nParcels() == 0)
        {
            mesh.lookupObjectRef<Feed>("feed").tellGasFlow
            (
                gas.massInflow(), gas.name()
            );
        }
        feed->requireRate();
    }
    const GasTable table(gas, runTime);
    table.write();

    plan.announce(cloud, runTime, unused);
    plan.account(ScenePlan::partOutput);
    if (watched && cloud.feed())
    {
        frames.reset(new FrameWriter(runTime, gas, cloud, *cloud.feed()));
    }
    exitHandling::caseIsRead();
    Info<< "\nStarting time loop\n" << endl;

    const scalar largestStep = plan.largestStep(cloud);

    // Do not continue a run that has already finished
    bool drained = cloud.drained(cloud.count());
    while (!drained && runTime.run())
    {
        control.follow();
        plan.resume();
        #include "readTimeControls.H"
        maxDeltaT = min(maxDeltaT, largestStep);
        {
            const scalar CoNum = gas.courantRate()*runTime.deltaTValue();
            Info<< "Courant Number max: " << CoNum << endl;
            #include "setDeltaT.H"
        }
        runTime.setDeltaT(asWritten(runTime.deltaTValue()), false);
        ++runTime;
        Info<< "Time = " << runTime.timeName() << nl << endl;

        // OpenFOAM's models write some of their files while they work
        autoPtr<AtomicTime> atomic
        (
            runTime.writeTime() ? new AtomicTime(runTime) : nullptr
        );

        moveParticles(runTime, cloud);
        plan.account(ScenePlan::partParticles);

        gas.followBoundaries();
        if (plan.gasDue(runTime, cloud.window()))
        {
            settleGas(runTime, gas, cloud, plan);
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
            write(runTime, cloud, plan, *atomic, drained);
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

    plan.report(cloud);
    if (cloud.feed())
    {
        requireNothingLost(mesh, cloud);
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

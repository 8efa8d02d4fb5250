/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/GasSampling.H"
#include "cloud/parcelBlocks.H"
#include "laws/SelfInducedVelocity.hpp"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "foam/soonRead.H"
#include "foam/stateFile.H"
#include "impacts/Flight.hpp"
#include "IOField.H"
#include "profiling.H"
#include "turbulenceModel.H"

#include <algorithm>
#include <memory>

namespace Foam
{

namespace laws = elutria::laws;

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

bool GasSampling::readCorrection(const dictionary& properties)
{
    refuseNearMisses
    (
        properties, {"selfInducedVelocity", "ownWake", "spreading"}
    );
    refuseNearMisses
    (
        properties.subDict("subModels"),
        {
            "cellListCoeffs", "pairCollisionCoeffs",
            "continuousDispersionRASCoeffs"
        }
    );
    if (const dictionary* former = properties.findDict("ownWake"))
    {
        Info<< "elutria: " << properties.name() << ": ownWake { undisturbed }"
            << " is read, but now called selfInducedVelocity { correct }"
            << endl;
        requireOwnEntries(*former, ownDictionary::ownWake);
        return former->getOrDefault<Switch>("undisturbed", true);
    }
    const dictionary own(properties.subOrEmptyDict("selfInducedVelocity"));
    requireOwnEntries(own, ownDictionary::selfInducedVelocity);
    return own.getOrDefault<Switch>("correct", true);
}


scalar GasSampling::readDisturbanceAge() const
{
    // The second name is that of runs before the first was chosen
    for (const char* const name : {"disturbanceAge", "ownWakeAge"})
    {
        const IOField<scalar> age
        (
            stateFile(cloud_, name, IOobject::READ_IF_PRESENT)
        );
        if (age.size())
        {
            return age[0];
        }
    }
    return -1;
}


Random GasSampling::randomOf(const StockParcel& p) const
{
    const uint64_t seed = feed_ ? feed_->seed() : 0;
    return Random
    (
        label
        (
            laws::scrambled
            (
                seed + laws::scrambled(parcelName(p))
              + uint64_t(cloud_.time().timeIndex())
            )
        )
    );
}


void GasSampling::disperse
(
    StockParcel& p,
    StockTracking& td,
    Random& random,
    const point& place,
    const scalar effectiveMass,
    const scalar dt
)
{
    if (!inertialDispersion_)
    {
        // OpenFOAM's take the cloud's numbers
        cloud_.rndGen() = random;
        p.calcDispersion(cloud_, td, dt);
        random = cloud_.rndGen();
        return;
    }
    const scalar mass = p.mass(), Re = p.Re(td);
    const forceSuSp mean = forces_.coupled(p, td, dt, mass, Re);
    const forceSuSp rest = forces_.nonCoupled(p, td, dt, mass, Re);
    const scalar dragRate = max(mean.Sp(), VSMALL);

    td.Uc() += inertialDispersion_->fluctuation
    (
        random,
        dt,
        inertialDispersion_->turbulence(p.cell()),
        {
            effectiveMass/dragRate,
            mag(rest.Su())/dragRate,
            place - gas_[p.cell()].centre
        },
        p.UTurb(),
        p.tTurb()
    );
}


void GasSampling::sample
(
    StockTracking& td,
    Random& random,
    StepParcels& step,
    const size_t i,
    const scalar whole
)
{
    StockParcel& p = *step.parcels[i];
    if (!p.active())
    {
        rest(p, step, i);
        return;
    }
    const scalar mass = p.mass();

    step.share[i] = 1 - p.stepFraction();
    const scalar dt = step.share[i]*whole;

    step.start(i);
    if (planar_)
    {
        step.starts[i] = p.position();
    }
    readGas(p, td);
    const scalar effectiveMass = forces_.effectiveMass(p, td, mass);
    step.effectiveMass[i] = effectiveMass;

    random = randomOf(p);
    if (dispersing_)
    {
        disperse(p, td, random, step.starts[i], effectiveMass, dt);
    }
    seeUndisturbedGas(p, td, dt);

    const scalar Re = p.Re(td);
    const forceSuSp free = forces_.nonCoupled(p, td, dt, mass, Re);
    const forceSuSp drag = forces_.coupled(p, td, dt, mass, Re);
    const vector acceleration((free.Su() + drag.Su())/effectiveMass);
    scalar rate = drag.Sp()/effectiveMass;

    // Predict the end of the step, and take the mean of both ends' drag
    const vector startVelocity(p.U());
    const elutria::dem::Flight now
    (
        {}, toEngine(startVelocity), toEngine(acceleration),
        toEngine(td.Uc()), rate
    );
    p.U() = toFoam(now.at(dt).velocity);
    const forceSuSp later = forces_.coupled(p, td, dt, mass, p.Re(td));
    p.U() = startVelocity;
    rate = 0.5*(rate + later.Sp()/effectiveMass);

    elutria::dem::Particles& all = step.particles;
    all.id[i] = parcelName(p);
    all.material[i] = contacts_ ? contacts_->material(p) : 0;
    all.radius[i] = 0.5*p.d();
    all.mass[i] = mass;
    all.statisticalWeight[i] = p.nParticle();
    step.cells[i] = p.cell();
    step.solids[i] = p.nParticle()*p.volume();
    all.dragRate[i] = rate;
    all.position.set(i, toEngine(step.starts[i]));
    all.velocity.set(i, toEngine(startVelocity));
    all.spin.set(i, toEngine(p.omega()));
    all.gasVelocity.set(i, toEngine(td.Uc()));
    all.acceleration.set(i, toEngine(acceleration));
}


void GasSampling::expectCell(const StockParcel& p) const
{
    soonRead(gas_[p.cell()]);
    if (dispersing_ && inertialDispersion_)
    {
        soonRead(inertialDispersion_->turbulence(p.cell()));
    }
}


void GasSampling::rest(StockParcel& p, StepParcels& step, const size_t i)
{
    p.U() = Zero;
    p.angularMomentum() = Zero;
    step.share[i] = 0;
    step.start(i);
    step.effectiveMass[i] = p.mass();
    step.cells[i] = p.cell();
    step.solids[i] = p.nParticle()*p.volume();

    elutria::dem::Particles& all = step.particles;
    all.id[i] = parcelName(p);
    all.material[i] = contacts_ ? contacts_->material(p) : 0;
    all.radius[i] = 0.5*p.d();
    all.mass[i] = p.mass();
    all.statisticalWeight[i] = p.nParticle();
    all.dragRate[i] = 0;
    all.position.set(i, toEngine(step.starts[i]));
    for
    (
        auto* vectors :
        {&all.velocity, &all.spin, &all.gasVelocity, &all.acceleration}
    )
    {
        vectors->set(i, {});
    }
}


void GasSampling::seeUndisturbedGas
(
    const StockParcel& p,
    StockTracking& td,
    const scalar dt
)
{
    if (!undisturbed_ || p.age() < disturbanceAge_ || disturbanceAge_ < 0)
    {
        return;
    }

    const CellGas::Cell& cell = gas_[p.cell()];
    const scalar kernel = gas_.kernelWidth();
    const vector seen(td.Uc() - p.U());
    const scalar passing = (p.U() & seen)/max(mag(seen), VSMALL);
    if (laws::outOfDisturbance(passing*disturbanceAge_, kernel, cell.size))
    {
        return;
    }

    const scalar volume = p.nParticle()*p.volume();
    const scalar viscosity = td.muc() + td.rhoc()*cell.eddyViscosity;
    const laws::DepositSurroundings gas
    {
        kernel,
        cell.size,
        laws::neighbourSpacing
        (
            cell.solidFraction, volume,
            volume/cell.volume*gas_.depositKept(p.cell())
        ),
        viscosity,
        viscosity/td.rhoc()
    };

    scalar share = 0, change = 1;
    for (label pass = 0; pass < 20 && change > 1e-5; ++pass)
    {
        td.Uc() = p.U() + seen/(1 - share);
        const scalar dragRate =
            forces_.coupled(p, td, dt, p.mass(), p.Re(td)).Sp();
        const scalar better = laws::selfInducedShare
        (
            p.nParticle()*dragRate,
            {mag(td.Uc() - p.U()), passing, passing*disturbanceAge_},
            gas
        );
        change = mag(better - share);
        share = better;
    }
    td.Uc() = p.U() + seen/(1 - share);
}


void GasSampling::findSolidFractions(StepParcels& step)
{
    elutria::dem::Particles& all = step.particles;
    std::vector<double>& fractions = all.solidFraction;
    fractions.assign(all.size(), 0);

    const bool weighted = std::any_of
    (
        all.statisticalWeight.begin(), all.statisticalWeight.end(),
        [](const double number) { return number != 1; }
    );
    if (!contacts_ || !returnReduce(weighted, orOp<bool>()))
    {
        return;
    }

    for (size_t i = 0; i < all.size(); ++i)
    {
        solidVolume_[step.cells[i]] += step.solids[i];
        ++parcels_[step.cells[i]];
    }
    for (size_t i = 0; i < all.size(); ++i)
    {
        const label celli = step.cells[i], others = parcels_[celli] - 1;
        const scalar volume = solidVolume_[celli] - step.solids[i];

        // Rounded: the last digits of a cell's volume are those of the
        // decomposition of the mesh
        fractions[i] = float
        (
            volume*(others - 1)/max(others, label(1))/gas_[celli].volume
        );
    }
    for (const label celli : step.cells)
    {
        solidVolume_[celli] = 0;
        parcels_[celli] = 0;
    }
}


bool GasSampling::readsCells(const StockCloud& cloud)
{
    const dictionary& schemes = cloud.solution().interpolationSchemes();
    const word names[] = {cloud.rho().name(), cloud.U().name(), cloud.mu().name()};
    return std::all_of(std::begin(names), std::end(names), [&](const word& name)
    {
        return schemes.get<word>(name) == "cell";
    });
}


void GasSampling::readGas(StockParcel& p, StockTracking& td)
{
    if (!readsCells_)
    {
        p.setCellValues(cloud_, td);
        return;
    }
    const CellGas::Cell& cell = gas_[p.cell()];
    td.rhoc() = cell.density;
    td.Uc() = cell.velocity;
    td.muc() = cell.viscosity;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

GasSampling::GasSampling
(
    StockCloud& cloud,
    const SolidFraction& solids,
    const DiffusionKernel& kernel,
    const Feed* feed,
    const CloudContacts* contacts
)
:
    cloud_(cloud),
    kernel_(kernel),
    gas_(cloud, solids, kernel),
    forces_(cloud),
    feed_(feed),
    contacts_(contacts),
    inertialDispersion_(dynamic_cast<InertialDispersion*>(&cloud.dispersion())),
    planar_(cloud.mesh().nSolutionD() < 3),
    readsCells_(readsCells(cloud)),
    solidVolume_(contacts ? cloud.mesh().nCells() : 0, Zero),
    parcels_(contacts ? cloud.mesh().nCells() : 0, Zero),
    undisturbed_(readCorrection(cloud.particleProperties())),
    disturbanceAge_(readDisturbanceAge()),
    dispersing_(false)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void GasSampling::sample(StepParcels& step, StockTracking& td, const scalar dt)
{
    addProfiling(sampling, "elutria::sampling");
    dispersing_ = disperses();
    gas_.update();

    step.list(cloud_);
    step.particles.stepIndex = cloud_.time().timeIndex();
    sampleAll(step, td, dt);
    if (disturbanceAge_ >= 0)
    {
        disturbanceAge_ += dt;
    }
    findSolidFractions(step);
    step.setLateAside();
}


unsigned GasSampling::threadsFor(const size_t parcels) const
{
    const bool shared =
        readsCells_ && forces_.shared()
     && (inertialDispersion_ || !dispersing_);
    return shared ? parcelThreads(contacts_, parcels) : 1;
}


void GasSampling::sampleAll
(
    StepParcels& step,
    StockTracking& first,
    const scalar dt
)
{
    const size_t n = step.parcels.size();
    const unsigned threads = threadsFor(n);
    std::vector<std::unique_ptr<StockTracking>> others;
    while (others.size() + 1 < threads)
    {
        others.push_back(std::make_unique<StockTracking>(cloud_));
    }
    if (threads > 1 && undisturbed_)
    {
        for (const StockParcel* p : step.parcels)
        {
            gas_.depositKept(p->cell());
        }
    }
    size_t end = n;     // of those that are moved
    while (end > 0 && !step.parcels[end - 1]->active())
    {
        --end;
    }
    forParcelBlocks(threads, n, [&](const size_t from, const size_t to)
    {
        const int thread = omp_get_thread_num();
        StockTracking& td = thread ? *others[thread - 1] : first;
        Random random;
        sampleBlock(step, td, random, from, to, dt);
        if (from < end && end <= to)
        {
            // What OpenFOAM's models draw follows the last parcel's numbers
            cloud_.rndGen() = random;
        }
    });
}


void GasSampling::sampleBlock
(
    StepParcels& step,
    StockTracking& td,
    Random& random,
    const size_t from,
    const size_t to,
    const scalar dt
)
{
    const std::vector<StockParcel*>& parcels = step.parcels;
    for (size_t i = from; i < to; ++i)
    {
        soonRead(*parcels[min(i + 2, to - 1)]);
        expectCell(*parcels[min(i + 1, to - 1)]);
        sample(td, random, step, i, dt);
    }
}


void GasSampling::gasWasSolved()
{
    disturbanceAge_ = cloud_.solution().coupled() ? 0 : -1;
}


bool GasSampling::disperses() const
{
    const auto* gas = mesh().findObject<turbulenceModel>
    (
        IOobject::groupName(turbulenceModel::propertiesName, cloud_.U().group())
    );
    const bool laminar =
        gas && gas->get<word>("simulationType") == "laminar";
    return cloud_.dispersion().active() && !laminar;
}


scalar GasSampling::selfInducedShare(const scalar weight, const scalar speed) const
{
    scalar largest = 0;
    for (const Feed::Material& m : feed_->materials())
    {
        largest = max(largest, m.sizes.max());
    }
    DiffusionKernel kernel(kernel_);
    kernel.adapt(largest);

    const scalar viscosity = gAverage(cloud_.mu().primitiveField());
    return laws::selfInducedShare
    (
        weight/speed,
        {speed, 0, 0},
        {
            kernel.active() ? kernel.width() : 0,
            cbrt(gAverage(mesh().V().field())),
            GREAT,
            viscosity,
            viscosity/gAverage(cloud_.rho().primitiveField())
        }
    );
}


void GasSampling::writeState() const
{
    if (disturbanceAge_ >= 0)
    {
        IOField<scalar>
        (
            stateFile(cloud_, "disturbanceAge", IOobject::NO_READ),
            scalarField(1, disturbanceAge_)
        ).write();
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/ElutriaCloud.H"
#include "contacts/ContactMemory.H"
#include "foam/stateFile.H"
#include "NoCollision.H"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "impacts/Flight.hpp"
#include "turbulenceModel.H"
#include "zeroGradientFvPatchFields.H"

#include <algorithm>

namespace Foam
{

defineTypeNameAndDebug(ElutriaCloud, 0);

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

IOobject ElutriaCloud::passingField(const word& name) const
{
    return IOobject
    (
        name, mesh().time().timeName(), mesh(),
        IOobject::NO_READ, IOobject::NO_WRITE, false
    );
}


void ElutriaCloud::findModels()
{
    typedef stockCloud::collidingCloudType collidingCloudType;

    contacts_ =
        dynamic_cast<CellListCollision<collidingCloudType>*>(&collision());
    if (contacts_)
    {
        contacts_->meetMirrors();
    }

    stockMotion_ =
        !contacts_
     && !isType<NoCollision<collidingCloudType>>(collision());

    inertialDispersion_ = dynamic_cast<InertialDispersion*>(&dispersion());

    auto& injectors = const_cast<InjectionModelList<kinematicCloudType>&>
    (
        this->injectors()
    );
    for (InjectionModel<kinematicCloudType>& injector : injectors)
    {
        if (auto* f = dynamic_cast<FeedInjection<kinematicCloudType>*>(&injector))
        {
            injection_ = f;
            injection_->handOver();
        }
    }

    if (!feed_)
    {
        return;
    }

    typedef OutletRecorder<kinematicCloudType> Recorder;
    for (CloudFunctionObject<kinematicCloudType>& object : functions())
    {
        if (auto* r = dynamic_cast<Recorder*>(&object))
        {
            recorder_ = r;
        }
    }
    if (!recorder_)
    {
        dictionary settings;
        settings.add("type", Recorder::typeName);
        recorder_ = new Recorder(settings, *this, "outlets");
        functions().append(recorder_);
    }
    recorder_->solverWrites();
}


void ElutriaCloud::sampleGas(trackingData& td, const scalar dt)
{
    elutria::dem::Particles& all = particles_;
    const size_t n = this->size();

    all.moment = time().timeIndex();
    all.id.resize(n);
    all.material.resize(n);
    all.radius.resize(n);
    all.mass.resize(n);
    all.number.resize(n);
    all.dragRate.resize(n);
    for
    (
        auto* vectors :
        {
            &all.position, &all.velocity, &all.spin, &all.gasVelocity,
            &all.acceleration, &all.dragImpulse
        }
    )
    {
        vectors->resize(n);
    }
    effectiveMass_.resize(n);
    starts_.resize(n);
    eddyViscosity_ = mesh().findObject<volScalarField>
    (
        IOobject::groupName("nut", U().group())
    );

    size_t i = 0;
    for (parcelType& p : *this)
    {
        sampleGas(p, td, i++, dt);
    }
}


void ElutriaCloud::sampleGas
(
    parcelType& p,
    trackingData& td,
    const size_t i,
    const scalar dt
)
{
    elutria::dem::Particles& all = particles_;
    const scalar mass = p.mass();

    starts_[i] = p.position();
    p.setCellValues(*this, td);
    const scalar massEff = forces().massEff(p, td, mass);

    if (dispersing_ && inertialDispersion_)
    {
        const forceSuSp mean = forces().calcCoupled
        (
            p, td, dt, mass, p.Re(td), td.muc()
        );
        const forceSuSp rest = forces().calcNonCoupled
        (
            p, td, dt, mass, p.Re(td), td.muc()
        );
        const scalar dragRate = max(mean.Sp(), VSMALL);
        inertialDispersion_->relaxationTime = massEff/dragRate;
        inertialDispersion_->meanSlip = mag(rest.Su())/dragRate;
        inertialDispersion_->offset = starts_[i] - mesh().C()[p.cell()];
    }
    seedRandom(p);
    if (dispersing_)
    {
        p.calcDispersion(*this, td, dt);
    }
    seeUndisturbedGas(p, td, dt);

    const forceSuSp free = forces().calcNonCoupled
    (
        p, td, dt, mass, p.Re(td), td.muc()
    );
    const forceSuSp drag = forces().calcCoupled
    (
        p, td, dt, mass, p.Re(td), td.muc()
    );
    const vector acceleration((free.Su() + drag.Su())/massEff);
    scalar rate = drag.Sp()/massEff;

    // Predict the end of the step, and take the mean of both ends' drag
    const vector startVelocity(p.U());
    const elutria::dem::Flight now
    (
        {}, toEngine(startVelocity), toEngine(acceleration),
        toEngine(td.Uc()), rate
    );
    p.U() = toFoam(now.at(dt).velocity);
    const forceSuSp later = forces().calcCoupled
    (
        p, td, dt, mass, p.Re(td), td.muc()
    );
    p.U() = startVelocity;
    rate = 0.5*(rate + later.Sp()/massEff);

    all.id[i] = parcelName(p);
    all.material[i] = contacts_ ? contacts_->material(p) : 0;
    all.radius[i] = 0.5*p.d();
    all.mass[i] = mass;
    all.number[i] = p.nParticle();
    all.dragRate[i] = rate;
    all.position.set(i, toEngine(starts_[i]));
    all.velocity.set(i, toEngine(startVelocity));
    all.spin.set(i, toEngine(p.omega()));
    all.gasVelocity.set(i, toEngine(td.Uc()));
    all.acceleration.set(i, toEngine(acceleration));
    effectiveMass_[i] = massEff;
}


void ElutriaCloud::seedRandom(const parcelType& p)
{
    const uint64_t seed = feed_ ? feed_->seed() : 0;
    rndGen() = Random
    (
        label
        (
            scrambled
            (
                seed + scrambled(parcelName(p)) + uint64_t(time().timeIndex())
            )
        )
    );
}


void ElutriaCloud::findSolidFractions()
{
    std::vector<double>& fractions = particles_.solidFraction;
    fractions.assign(this->size(), 0);

    const bool weighted = std::any_of
    (
        particles_.number.begin(), particles_.number.end(),
        [](const double number) { return number != 1; }
    );
    if (!contacts_ || !returnReduce(weighted, orOp<bool>()))
    {
        return;
    }

    const scalarField solids(solidVolume());
    labelList parcels(mesh().nCells(), Zero);
    for (const parcelType& p : *this)
    {
        ++parcels[p.cell()];
    }
    size_t i = 0;
    for (const parcelType& p : *this)
    {
        const label celli = p.cell(), others = parcels[celli] - 1;
        const scalar volume = solids[celli] - p.nParticle()*p.volume();
        fractions[i++] =
            volume*(others - 1)/max(others, label(1))/mesh().V()[celli];
    }
}


void ElutriaCloud::advanceParticles(const scalar dt)
{
    if (contacts_)
    {
        string trouble;
        ParticleExchange::onMaster
        (
            particles_,
            [&](elutria::dem::Particles& everyone)
            {
                try
                {
                    report_ = contacts_->guardedEngine().advance
                    (
                        everyone, dt, retakes_
                    );
                }
                catch (const std::exception& error)
                {
                    trouble = error.what();
                    return;
                }
                work_.particleSteps += everyone.size();
                work_.freeFlights += report_.freeParticles;
                work_.softFlights += report_.softParticles;
                work_.impacts += report_.impacts;
                for (const std::string& warning : report_.warnings)
                {
                    Info<< "    Warning: " << warning.c_str() << endl;
                }
            }
        );
        elutriaBroadcast(trouble);
        if (!trouble.empty())
        {
            throw UnsoundStep
            (
                "the particles' motion failed at time " + time().timeName()
              + " s: " + trouble
            );
        }
        return;
    }

    elutria::dem::Particles& all = particles_;
    for (size_t i = 0; i < all.size(); ++i)
    {
        const elutria::dem::Flight now
        (
            all.position[i], all.velocity[i], all.acceleration[i],
            all.gasVelocity[i], all.dragRate[i]
        );
        const elutria::dem::Flight later = now.at(dt);
        all.position.set(i, later.position);
        all.velocity.set(i, later.velocity);
        all.dragImpulse.set
        (
            i, all.mass[i]*now.dragGain(dt, all.acceleration[i])
        );
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

ElutriaCloud::ElutriaCloud
(
    const word& cloudName,
    const volScalarField& rho,
    const volVectorField& U,
    const volScalarField& mu,
    const dimensionedVector& g
)
:
    stockCloud(cloudName, rho, U, mu, g),
    feed_(Feed::find(mesh(), U.group())),
    injection_(nullptr),
    recorder_(nullptr),
    contacts_(nullptr),
    inertialDispersion_(nullptr),
    dispersing_(false),
    stockMotion_(false),
    impulse_(mesh().nCells(), Zero),
    arrived_(mesh().nCells(), Zero),
    injectedFrom_(0),
    window_(0),
    windowStart_(time().timeIndex()),
    retakes_(0),
    volumeShares_(mesh()),
    kernel_(mesh(), particleProperties().subOrEmptyDict("spreading")),
    ownWake_(particleProperties().subOrEmptyDict("ownWake")),
    wakeAge_(readWakeAge()),
    eddyViscosity_(nullptr),
    theta_
    (
        IOobject
        (
            IOobject::groupName("alpha", "particles"),
            mesh().time().timeName(),
            mesh(),
            IOobject::NO_READ,
            IOobject::AUTO_WRITE
        ),
        mesh(),
        dimensionedScalar(dimless, Zero),
        zeroGradientFvPatchScalarField::typeName
    ),
    thetaTime_(-1),
    excessVolume_(0)
{
    findModels();
    if (contacts_)
    {
        contactMemory::read(*this, contacts_->engine());
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void ElutriaCloud::evolve()
{
    if (solution().canEvolve())
    {
        trackingData td(*this);
        injectedFrom_ = this->size();
        solve(*this, td);
    }
}


template<class TrackCloudType>
void ElutriaCloud::motion(TrackCloudType& cloud, trackingData& td)
{
    countInjected();
    enterFeed(td);

    const scalar dt = solution().trackTime();
    window_ += dt;

    if (stockMotion_)
    {
        stockCloud::motion(cloud, td);
        return;
    }

    dispersing_ = disperses();
    sampleGas(td, dt);
    if (wakeAge_ >= 0)
    {
        wakeAge_ += dt;
    }
    findSolidFractions();
    advanceParticles(dt);
    track(td, dt);
}


bool ElutriaCloud::disperses() const
{
    const auto* gas = mesh().findObject<turbulenceModel>
    (
        IOobject::groupName(turbulenceModel::propertiesName, U().group())
    );
    const bool laminar =
        gas && gas->get<word>("simulationType") == "laminar";
    return dispersion().active() && !laminar;
}


bool ElutriaCloud::hasFriction() const
{
    const elutria::dem::ContactMaterials& materials =
        contacts_->engine().materials();
    for (uint32_t a = 0; a < materials.size(); ++a)
    {
        for (uint32_t b = 0; b <= a; ++b)
        {
            if (materials.pair(a, b).friction > 0)
            {
                return true;
            }
        }
    }
    return false;
}


scalar ElutriaCloud::shortestContact
(
    const scalar diameter,
    const scalar speed
) const
{
    elutria::dem::Particles pair;
    for (const label i : {0, 1})
    {
        scalar lightest = GREAT;
        for (const Feed::Material& m : feed_->materials())
        {
            lightest = min(lightest, m.density);
        }
        pair.id.push_back(i);
        pair.material.push_back(0);
        pair.radius.push_back(0.5*diameter);
        pair.mass.push_back
        (
            lightest*constant::mathematical::pi/6*pow3(diameter)
        );
        pair.position.push_back({2*i*diameter, 0, 0});
        pair.velocity.push_back({});
        pair.spin.push_back({});
    }
    return
        contacts_->engine().stepLimit(pair, speed)
       /contactStepFraction();
}


scalar ElutriaCloud::deepestOverlap(const scalar speed) const
{
    scalar deepest = 0;
    for (const Feed::Material& m : feed_->materials())
    {
        deepest = max
        (
            deepest,
            contacts_->engine().expectedOverlap
            (
                0.5*m.sizes.max(), m.density, speed
            )
        );
    }
    return deepest;
}


bool ElutriaCloud::softOnly() const
{
    return
        contacts_->engine().settings().treatment
     == elutria::dem::ContactTreatment::soft;
}


void ElutriaCloud::writeState()
{
    if (recorder_)
    {
        recorder_->writeFiles();
    }
    if (contacts_)
    {
        contactMemory::write(*this, contacts_->engine());
    }
    if (wakeAge_ >= 0)
    {
        IOField<scalar>
        (
            stateFile(*this, "ownWakeAge", IOobject::NO_READ),
            scalarField(1, wakeAge_)
        ).write();
    }
}


void ElutriaCloud::info()
{}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "ElutriaCloud.H"
#include "ContactMemory.H"
#include "ParcelTransfer.H"
#include "NoCollision.H"
#include "foamVersion.H"
#include "flight.hpp"
#include "meshTools.H"
#include "wallPolyPatch.H"
#include "zeroGradientFvPatchFields.H"

namespace Foam
{

defineTypeNameAndDebug(ElutriaCloud, 0);

namespace
{

elutria::dem::Vector3 toEngine(const vector& v)
{
    return {v.x(), v.y(), v.z()};
}

vector toFoam(const elutria::dem::Vector3& v)
{
    return vector(v.x, v.y, v.z);
}

} // End anonymous namespace


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


void ElutriaCloud::enterFeed(trackingData& td)
{
    if (!injection_)
    {
        return;
    }

    const scalar dt = solution().trackTime();
    const labelRange numbers = injection_->take(time().value());

    for (const label i : numbers)
    {
        const point position(injection_->position(i));
        const label celli = mesh().findCell(position);

        // One processor takes the particle: the first that has the place
        label owner = celli < 0 ? Pstream::nProcs() : Pstream::myProcNo();
        reduce(owner, minOp<label>());
        if (owner == Pstream::nProcs())
        {
            FatalErrorInFunction
                << "particle " << i << " of the feed would enter at "
                << position << ", outside the mesh: move the feed's patch or"
                << " zone away from the domain's edge" << exit(FatalError);
        }
        if (owner != Pstream::myProcNo())
        {
            continue;
        }

        auto* parcel = new parcelType(mesh(), position, celli);
        setParcelThermoProperties(*parcel, dt);
        injection_->setParcel(i, *parcel);
        checkParcelProperties(*parcel, dt, true);
        addParticle(parcel);
    }
}


void ElutriaCloud::sampleGas(trackingData& td, const scalar dt)
{
    elutria::dem::Particles& all = particles_;
    const size_t n = this->size();

    all.id.resize(n);
    all.material.resize(n);
    all.radius.resize(n);
    all.mass.resize(n);
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

    p.setCellValues(*this, td);
    const scalar massEff = forces().massEff(p, td, mass);

    if (inertialDispersion_)
    {
        const forceSuSp mean = forces().calcCoupled
        (
            p, td, dt, mass, p.Re(td), td.muc()
        );
        inertialDispersion_->relaxationTime = massEff/max(mean.Sp(), VSMALL);
    }
    seedRandom(p);
    p.calcDispersion(*this, td, dt);

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
    all.dragRate[i] = rate;
    all.position.set(i, toEngine(p.position()));
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


void ElutriaCloud::advanceParticles(const scalar dt)
{
    if (contacts_)
    {
        ParticleExchange::onMaster
        (
            particles_,
            [&](elutria::dem::Particles& everyone)
            {
                try
                {
                    report_ = contacts_->engine().advance(everyone, dt);
                }
                catch (const std::exception& error)
                {
                    FatalErrorInFunction
                        << "the particles' motion failed at time "
                        << time().timeName() << " s: " << error.what()
                        << exit(FatalError);
                }
                for (const std::string& warning : report_.warnings)
                {
                    Info<< "    Warning: " << warning.c_str() << endl;
                }
            }
        );
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


List<ElutriaCloud::Flight> ElutriaCloud::flights
(
    const List<vector>& starts,
    const scalar dt
) const
{
    const elutria::dem::Particles& all = particles_;
    const elutria::dem::PeriodicBox box =
        contacts_ ? contacts_->engine().settings().box
      : elutria::dem::PeriodicBox();

    List<Flight> flights(starts.size());
    size_t i = 0;
    for (const parcelType& p : *this)
    {
        Flight& f = flights[i];
        f.displacement = toFoam
        (
            box.shortest(all.position[i] - toEngine(starts[i]))
        );
        f.start = p.U();
        f.end = toFoam(all.velocity[i]);
        f.spin = toFoam(all.spin[i]);
        f.impulse =
            effectiveMass_[i]/all.mass[i]*toFoam(all.dragImpulse[i]);
        f.dragRate = all.dragRate[i];

        meshTools::constrainDirection
        (
            mesh(), mesh().solutionD(), f.displacement
        );
        meshTools::constrainDirection(mesh(), mesh().solutionD(), f.end);
        ++i;
    }
    return flights;
}


void ElutriaCloud::deposit(const parcelType& p, const Flight& flight)
{
    impulse_[p.cell()] -= p.nParticle()*flight.impulse;
}


void ElutriaCloud::meetPatch
(
    parcelType& p,
    Flight& flight,
    trackingData& td,
    const scalar dt
)
{
    const scalar done = p.stepFraction();
    const vector arrival(flight.start + done*(flight.end - flight.start));
    const polyPatch& patch = mesh().boundaryMesh()[p.patch()];

    if (contacts_ && isA<wallPolyPatch>(patch))
    {
        // The engine has dealt with the wall; the chord of a curved path cuts
        // a corner. Go where the path ends, or along the wall towards it.
        const point target(p.position() + (1 - done)*flight.displacement);
        const label celli = mesh().findCell(target);
        if (celli >= 0)
        {
            p.relocate(target, celli);
            p.age() += (1 - done)*dt;
            p.stepFraction() = 1;
        }
        else
        {
            const vector n(p.normal());
            flight.displacement -= (flight.displacement & n)*n;
            p.hitFace(flight.displacement, *this, td);
        }
        return;
    }

    p.U() = arrival;
    p.hitFace(flight.displacement, *this, td);

    if (td.keepParticle && p.U() != arrival)
    {
        // Turned by a rebound or a mirror: what the forces had still to add
        // in this step stays
        flight.end = p.U() + (flight.end - arrival);
        flight.displacement = 0.5*(p.U() + flight.end)*dt;
        flight.start = flight.end;
    }
}


void ElutriaCloud::trackParcel
(
    parcelType& p,
    Flight& flight,
    trackingData& td,
    const scalar dt
)
{
    td.switchProcessor = false;
    td.keepParticle = true;

    // A parcel that slides along walls without end is left where it is
    label attempts = 0;

    while
    (
        td.keepParticle && !td.switchProcessor && p.stepFraction() < 1
     && p.active()
    )
    {
        const point from(p.position());
        const scalar before = p.stepFraction();
        const scalar f = 1 - before;

        p.trackToFace
        (
            f*flight.displacement - p.deviationFromMeshCentre(), f
        );
        const scalar spent = (p.stepFraction() - before)*dt;
        p.age() += spent;

        functions().postMove(p, spent, from, td.keepParticle);
        if (!p.onFace())
        {
            continue;
        }
        functions().postFace(p, td.keepParticle);

        if (p.onBoundaryFace())
        {
            if (spent < SMALL*dt && ++attempts > 20)
            {
                p.age() += f*dt;
                p.stepFraction() = 1;
            }
            else
            {
                meetPatch(p, flight, td, dt);
            }
        }
        else
        {
            p.hitFace(flight.displacement, *this, td);
        }
    }

    if (td.keepParticle && !td.switchProcessor)
    {
        p.U() = flight.end;
        p.angularMomentum() = p.momentOfInertia()*flight.spin;
    }
}


void ElutriaCloud::track(trackingData& td, const scalar dt)
{
    // Parcels still to be tracked, with their flights: first all of the
    // cloud's, then those that arrive from other processors
    List<vector> starts(this->size());
    label k = 0;
    for (parcelType& p : *this)
    {
        starts[k++] = p.position();
        p.stepFraction() = 0;
    }
    List<Flight> flightOf(flights(starts, dt));
    IDLList<parcelType> moving;
    moving.transfer(*this);

    dragRates_.clear();
    ParcelTransfer<parcelType, Flight> transfer(mesh());

    do
    {
        k = 0;
        for (parcelType& p : moving)
        {
            Flight& flight = flightOf[k++];
            trackParcel(p, flight, td, dt);

            if (!td.keepParticle)
            {
                deposit(p, flight);
                delete moving.remove(&p);
            }
            else if (td.switchProcessor)
            {
                transfer.add(moving.remove(&p), flight);
            }
            else
            {
                deposit(p, flight);
                dragRates_.append(flight.dragRate);
                addParticle(moving.remove(&p));
            }
        }
    } while (transfer.exchange(moving, flightOf, td));
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
    stockMotion_(false),
    impulse_(mesh().nCells(), Zero),
    window_(0),
    kernel_(mesh(), particleProperties().subOrEmptyDict("spreading")),
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
        solve(*this, td);
    }
}


template<class TrackCloudType>
void ElutriaCloud::motion(TrackCloudType& cloud, trackingData& td)
{
    enterFeed(td);

    const scalar dt = solution().trackTime();
    window_ += dt;

    if (stockMotion_)
    {
        stockCloud::motion(cloud, td);
        return;
    }

    sampleGas(td, dt);
    advanceParticles(dt);
    track(td, dt);
}


scalar ElutriaCloud::response(const label k) const
{
    return -std::expm1(-dragRates_[k]*window_);
}


ElutriaCloud::GasExchange ElutriaCloud::exchange() const
{
    GasExchange gas
    {
        volVectorField
        (
            passingField("particleForce"), mesh(),
            dimensionedVector(dimForce/dimVolume, Zero),
            zeroGradientFvPatchVectorField::typeName
        ),
        volScalarField
        (
            passingField("particleCoefficient"), mesh(),
            dimensionedScalar(dimDensity/dimTime, Zero),
            zeroGradientFvPatchScalarField::typeName
        )
    };
    if (!solution().coupled() || window_ <= 0)
    {
        return gas;
    }

    vectorField& force = gas.force.primitiveFieldRef();
    scalarField& coefficient = gas.coefficient.primitiveFieldRef();
    if (stockMotion_)
    {
        force = UTrans().field();
        coefficient = UCoeff().field();
    }
    else
    {
        force = impulse_;
        label k = 0;
        for (const parcelType& p : *this)
        {
            coefficient[p.cell()] += p.nParticle()*p.mass()*response(k++);
        }
    }

    const scalarField Vw(mesh().V()*window_);
    force /= Vw;
    coefficient /= Vw;
    kernel_.spread(gas.force);
    kernel_.spread(gas.coefficient);
    gas.force.correctBoundaryConditions();
    gas.coefficient.correctBoundaryConditions();
    return gas;
}


void ElutriaCloud::correct(const volVectorField& change)
{
    if (!stockMotion_ && solution().coupled())
    {
        volVectorField seen
        (
            passingField("gasChange"), mesh(),
            dimensionedVector(dimVelocity, Zero),
            zeroGradientFvPatchVectorField::typeName
        );
        seen.primitiveFieldRef() = change.primitiveField();
        kernel_.spread(seen);

        label k = 0;
        for (parcelType& p : *this)
        {
            p.U() += response(k++)*seen[p.cell()];
        }
    }
    drop();
}


void ElutriaCloud::drop()
{
    impulse_ = Zero;
    window_ = 0;
}


const volScalarField& ElutriaCloud::solidFraction(const scalar maximum)
{
    scalarField& theta = theta_.primitiveFieldRef();
    scalar largest = 0;

    theta = 0;
    for (const parcelType& p : *this)
    {
        theta[p.cell()] += p.nParticle()*p.volume();
        largest = max(largest, p.d());
    }
    theta /= mesh().V();

    reduce(largest, maxOp<scalar>());
    kernel_.adapt(largest);
    kernel_.spread(theta_);

    excessVolume_ = 0;
    forAll(theta, celli)
    {
        if (theta[celli] > maximum)
        {
            excessVolume_ += (theta[celli] - maximum)*mesh().V()[celli];
            theta[celli] = maximum;
        }
    }
    reduce(excessVolume_, sumOp<scalar>());
    theta_.correctBoundaryConditions();
    return theta_;
}


ElutriaCloud::Count ElutriaCloud::count() const
{
    Count count;
    for (const parcelType& p : *this)
    {
        count.inside += p.origProc() == Feed::feedOrigin || !feed_;
    }
    reduce(count.inside, sumOp<label>());

    if (feed_)
    {
        count.fed = feed_->fedUntil(time().value());
        count.left = recorder_->leftParcels();
        count.lost = count.fed - count.inside - sum(count.left);
    }
    return count;
}


bool ElutriaCloud::drained(const Count& count) const
{
    return
        feed_
     && time().value() > feed_->end()
     && (count.inside == 0 || time().value() > feed_->drained());
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
}


void ElutriaCloud::info()
{}


} // End namespace Foam

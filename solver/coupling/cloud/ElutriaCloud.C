/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/ElutriaCloud.H"
#include "cloud/contactLimits.H"
#include "cloud/exactPlaces.H"
#include "cloud/stockRecords.H"
#include "contacts/ContactHistory.H"
#include "contacts/SymmetryWalls.H"
#include "foam/foamVersion.H"
#include "foam/Warnings.H"
#include "impacts/Flight.hpp"
#include "NoCollision.H"
#include "profiling.H"
#include "sigFpe.H"

namespace Foam
{

defineTypeNameAndDebug(ElutriaCloud, 0);

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

CloudContacts* ElutriaCloud::findContacts()
{
    if (!solution().active())
    {
        FatalIOErrorInFunction(solution().dict())
            << "active is no: no particle would move, allowed: yes"
            << exit(FatalIOError);
    }
    auto* contacts = dynamic_cast<CloudContacts*>(&collision());
    if (contacts)
    {
        refuseWithContacts
        (
            particleProperties(), mesh(), namesOf(contacts->surfaces())
        );
        // Engine and walls are made anew for that
        bool symmetric = false;
        for (const polyPatch& patch : mesh().boundaryMesh())
        {
            symmetric = symmetric || isSymmetry(patch);
        }
        if (symmetric)
        {
            contacts->addSymmetryWalls();
        }
    }
    return contacts;
}


void ElutriaCloud::advanceEngine(const scalar dt)
{
    // The engine's vector kernels compute lanes that nobody uses
    const sigFpe::ignore untrapped;
    report_ = contacts_->guardedEngine().advance
    (
        parcels_.particles, dt, retakes_
    );

    work_.particleSteps += report_.particles;
    work_.freeFlights += report_.freeParticles;
    work_.softFlights += report_.softParticles;
    work_.impacts += report_.impacts;
    ofRank_.particleSteps += report_.own.particles;
    ofRank_.ghostSteps += report_.own.ghosts;
    ofRank_.sharedIslands += report_.own.sharedIslands;
    if (Pstream::master())
    {
        for (const RunWarning& warning : report_.warnings)
        {
            Warnings::add(warning);
        }
    }
}


void ElutriaCloud::advanceFreely(const scalar dt)
{
    elutria::dem::Particles& all = parcels_.particles;
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


void ElutriaCloud::advanceParticles(const scalar dt)
{
    addProfiling(engine, "elutria::engine");
    if (!contacts_)
    {
        advanceFreely(dt);
        return;
    }

    contacts_->moveWalls();
    try
    {
        advanceEngine(dt);
    }
    catch (const std::exception& error)
    {
        throw UnsoundStep
        (
            "the particles' motion failed at time " + time().timeName()
          + " s: " + error.what()
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
    StockCloud(withStockRecords(cloudName, U.mesh()), rho, U, mu, g),
    feed_(Feed::find(mesh(), U.group())),
    contacts_(findContacts()),
    stockMotion_
    (
        !contacts_
     && !isType<NoCollision<StockCloud::collidingCloudType>>(collision())
    ),
    feedDisplacesGas_
    (
        particleProperties().getOrDefault<Switch>("feedDisplacesGas", false)
    ),
    kernel_(mesh(), particleProperties().subOrEmptyDict("spreading")),
    solids_(mesh(), kernel_),
    cells_(mesh()),
    entry_(*this, solids_, cells_, feed_),
    sampling_(*this, solids_, kernel_, feed_, contacts_),
    coupling_(*this, kernel_, stockMotion_),
    wallHits_(*this, contacts_),
    tracking_
    (
        *this, coupling_, solids_, cells_, contacts_, entry_.recorder(),
        sampling_.hasInertialDispersion(), wallHits_.sticks()
    ),
    retakes_(0)
{
    exactPlaces::read(*this, parcels_);
    if (contacts_)
    {
        contactHistory::read(*this, contacts_->engine());
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void ElutriaCloud::evolve()
{
    if (solution().canEvolve())
    {
        StockTracking td(*this);
        entry_.startStep();
        if (!stockMotion_)
        {
            // OpenFOAM's models move what they inject, and then motion() does
            // so again. In this part of a collision step they do not: motion()
            // moves it, for the time since it was injected.
            td.part() = StockTracking::tpVelocityHalfStep;
        }
        solve(*this, td);
    }
}


template<class TrackCloudType>
void ElutriaCloud::motion(TrackCloudType& cloud, StockTracking& td)
{
    const scalar dt = solution().trackTime();

    entry_.enter(parcels_);
    coupling_.startStep(dt);
    if (stockMotion_)
    {
        StockCloud::motion(cloud, td);
        coupling_.depositStock();
        return;
    }
    td.part() = StockTracking::tpLinearTrack;
    sampling_.sample(parcels_, td, dt);
    advanceParticles(dt);
    parcels_.flyLate(dt);
    wallHits_.tell(report_.hits, parcels_, td, dt);
    tracking_.track(parcels_, td, dt);
}


List<ElutriaCloud::RankWork> ElutriaCloud::workOfRanks() const
{
    RankWork own(ofRank_);
    own.cells = mesh().nCells();
    own.particles = size();
    if (contacts_)
    {
        const auto& traffic = contacts_->engine().exchange().traffic();
        own.calls = traffic.calls;
        own.seconds = traffic.seconds;
        own.bytes = traffic.bytes;
    }
    List<scalarList> rows(Pstream::nProcs());
    rows[Pstream::myProcNo()] = scalarList
    ({
        own.cells, own.particles, own.particleSteps, own.ghostSteps,
        own.sharedIslands, own.calls, own.seconds, own.bytes
    });
    Pstream::gatherList(rows);
    DynamicList<RankWork> ranks;
    for (const scalarList& r : rows)
    {
        if (r.size())
        {
            ranks.append({r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7]});
        }
    }
    return List<RankWork>(ranks);
}


void ElutriaCloud::takeBack()
{
    entry_.takeBack();
    drop();
}


void ElutriaCloud::correct(const volVectorField& change)
{
    coupling_.correct(change);
    drop();
    sampling_.gasWasSolved();
}


void ElutriaCloud::drop()
{
    coupling_.restart();
    solids_.forgetArrivals();
}


const volScalarField& ElutriaCloud::solidFraction(const scalar maximum)
{
    solids_.clear();
    parcels_.startSearch();
    for (const StockParcel& p : *this)
    {
        solids_.add
        (
            p.cell(), parcels_.place(p), p.nParticle()*p.volume(), p.d()
        );
    }
    return solids_.finish(maximum);
}


void ElutriaCloud::writeState()
{
    catchUp();
    entry_.writeState();
    if (contacts_)
    {
        contactHistory::write(*this, contacts_->engine());
    }
    sampling_.writeState();
    if (!stockMotion_)
    {
        exactPlaces::write(*this, parcels_);
    }
}


void ElutriaCloud::info()
{
    if (time().writeTime())
    {
        StockCloud::info();
    }
    else if
    (
        patchInteraction().coeffDict().getOrDefault<Switch>("writeToFile", false)
    )
    {
        countTotals(patchInteraction());
    }
}


} // End namespace Foam

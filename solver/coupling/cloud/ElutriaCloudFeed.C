/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    ElutriaCloud's feed: who enters, who is inside, who has left.

\*---------------------------------------------------------------------------*/

#include "cloud/ElutriaCloud.H"
#include "foam/foamVersion.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

label ElutriaCloud::findOwner(const point& position, label& celli) const
{
    celli = mesh().findCell(position);

    // One processor takes the particle: the first that has the place
    label owner = celli < 0 ? Pstream::nProcs() : Pstream::myProcNo();
    reduce(owner, minOp<label>());
    return owner == Pstream::nProcs() ? -1 : owner;
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
        point position(injection_->position(i));
        label celli = -1;
        label owner = findOwner(position, celli);
        if (owner < 0)
        {
            position = feed_->retreat(i);
            owner = findOwner(position, celli);
        }
        if (owner < 0)
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
        countArrival(*parcel, 1);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

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


void ElutriaCloud::takeBack()
{
    for (parcelType& p : *this)
    {
        if
        (
            p.origProc() == Feed::feedOrigin
         && p.origId() >= feed_->fedUntil(time().value())
        )
        {
            deleteParticle(p);
        }
    }
    drop();
}


} // End namespace Foam

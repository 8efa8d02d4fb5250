/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    What parcels a feed is made of: drawn once all else is known.

\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "foam/foamVersion.H"
#include "mathematicalConstants.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Feed::drawParcels()
{
    std::vector<elutria::laws::Ingredient> ingredients;
    label present = 0;
    for (const Material& m : materials_)
    {
        ingredients.push_back(m.ingredient());
        present += m.massFraction > 0;
    }
    if (weighted() && parcels_ < present)
    {
        FatalIOErrorInFunction(*this)
            << "particles is " << parcels_ << ", allowed: >= " << present
            << ", a parcel of each material" << exit(FatalIOError);
    }
    drawn_.reset
    (
        new elutria::laws::StratifiedFeed
        (
            ingredients, sampling_, seed_ + uint64_t(first_),
            massFlow_/rate_, {slots_}
        )
    );
}


elutria::laws::FedParcel Feed::drawn(const label k) const
{
    if (k < 0 || k >= parcels_)
    {
        FatalIOErrorInFunction(*this)
            << "parcel " << first_ + k << " is not of this feed, which has " << parcels_
            << ": was it changed since the run began?" << exit(FatalIOError);
    }
    return (*drawn_)[k];
}


scalar Feed::slot(const label i) const
{
    return i + random(i, 2)*min(scalar(1), slots_ - i);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

scalar Feed::mass(const label i) const
{
    const Feed& own = stretchOf(i);
    return own.ownMass(i - own.first_);
}


scalar Feed::ownMass(const label k) const
{
    const elutria::laws::FedParcel p = drawn(k);
    return
        p.density
       *constant::mathematical::pi/6*pow3(p.diameter);
}


scalar Feed::number(const label i) const
{
    const Feed& own = stretchOf(i);
    return own.ownNumber(i - own.first_);
}


scalar Feed::ownNumber(const label k) const
{
    return
        weighted()
      ? massFactor(entryTime(k))*drawn(k).mass/ownMass(k) : 1;
}


scalar Feed::meanMass() const
{
    scalar number = 0;
    for (const Material& m : materials_)
    {
        number += m.massFraction/m.ingredient().meanMass();
    }
    return 1/number;
}


scalar Feed::numberFraction(const Material& m) const
{
    return m.massFraction*meanMass()/m.ingredient().meanMass();
}


scalar Feed::heaviestParcel() const
{
    scalar heaviest = 0;
    const label some = drawn_ ? min(label(1000), parcels_) : 0;
    for (label i = 0; i < some; ++i)
    {
        heaviest = max(heaviest, drawn(i).mass);
    }
    return heaviest;
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    What parcels a feed is made of: drawn once all else is known, and kept
    where a feed is made longer.

\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "foam/foamVersion.H"
#include "IOField.H"
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
    std::vector<double> ends(ends_.cbegin(), ends_.cend());
    if (ends.empty() || ends.back() < slots_)
    {
        ends.push_back(slots_);
    }
    drawn_.reset
    (
        new elutria::laws::StratifiedFeed
        (
            ingredients, sampling_, seed_, massFlow_/rate_, ends
        )
    );
}


IOobject Feed::stateOf(const word& name, const IOobject::readOption read) const
{
    return IOobject
    (
        name, mesh_.time().timeName(), "uniform", mesh_,
        read, IOobject::NO_WRITE, false
    );
}


void Feed::readEnds()
{
    ends_ = IOField<scalar>(stateOf("feedEnds", IOobject::READ_IF_PRESENT));
}


void Feed::writeState() const
{
    scalarList begun(ends_);
    if
    (
        (begun.empty() || begun.last() < slots_)
     && fedUntil(mesh_.time().value()) > label(drawn_->lastBlock())
    )
    {
        begun.append(slots_);
    }
    if (begun.size())
    {
        const unsigned digits = IOstream::defaultPrecision(17);
        IOField<scalar>(stateOf("feedEnds", IOobject::NO_READ), begun).write();
        IOstream::defaultPrecision(digits);
    }
}


elutria::laws::FedParcel Feed::drawn(const label i) const
{
    if (i < 0 || i >= parcels_)
    {
        FatalIOErrorInFunction(*this)
            << "parcel " << i << " is not of this feed, which has " << parcels_
            << ": was it changed since the run began?" << exit(FatalIOError);
    }
    return (*drawn_)[i];
}


scalar Feed::slot(const label i) const
{
    return i + random(i, 2)*min(scalar(1), slots_ - i);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

scalar Feed::mass(const label i) const
{
    const elutria::laws::FedParcel p = drawn(i);
    return materials_[p.material].density*constant::mathematical::pi/6*pow3(p.diameter);
}


scalar Feed::number(const label i) const
{
    return weighted() ? drawn(i).mass/mass(i) : 1;
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
    for (label i = 0; i < min(label(1000), parcels_); ++i)
    {
        heaviest = max(heaviest, drawn(i).mass);
    }
    return heaviest;
}


} // End namespace Foam

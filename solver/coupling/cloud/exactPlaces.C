/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/exactPlaces.H"
#include "IOField.H"

namespace Foam
{

namespace
{

const word fieldName("exactPlace");

} // End anonymous namespace


void exactPlaces::write(const StockCloud& cloud, StepParcels& parcels)
{
    IOField<vector> places
    (
        cloud.fieldIOobject(fieldName, IOobject::NO_READ), cloud.size()
    );
    parcels.startSearch();
    label i = 0;
    for (const auto& p : cloud)
    {
        places[i++] = parcels.place(p);
    }
    places.write(cloud.size() > 0);
}


void exactPlaces::read(const StockCloud& cloud, StepParcels& parcels)
{
    const IOField<vector> places
    (
        cloud.fieldIOobject(fieldName, IOobject::READ_IF_PRESENT)
    );
    parcels.ends.clear();
    if (places.size() != cloud.size())
    {
        return;
    }
    label i = 0;
    for (const auto& p : cloud)
    {
        parcels.ends.push_back({parcelName(p), places[i++], true});
    }
}


} // End namespace Foam

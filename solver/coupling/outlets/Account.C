/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "outlets/Account.H"

namespace Foam
{

namespace
{

void show(std::ostream& os, const Amount& a)
{
    os  << "{\"parcels\": " << a.parcels << ", \"number\": " << a.number
        << ", \"mass_kg\": " << a.mass << "}";
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

Amount Account::missing() const
{
    Amount rest = fed;
    for (const Amount& a : left)
    {
        rest -= a;
    }
    rest -= inside;
    return rest;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Account::operator+=(const Account& other)
{
    fed += other.fed;
    forAll(left, i)
    {
        left[i] += other.left[i];
    }
    inside += other.inside;
}


Amount Account::lost() const
{
    const Amount rest = missing();
    return rest.parcels ? rest : Amount();
}


scalar Account::closureError() const
{
    return fed.mass > 0 ? mag(missing().mass)/fed.mass : 0;
}


void Account::write(std::ostream& os, const wordList& products) const
{
    os << "{\"injected\": ";
    show(os, fed);
    os << ", \"outlets\": {";
    forAll(left, i)
    {
        os << (i ? ", \"" : "\"") << products[i] << "\": ";
        show(os, left[i]);
    }
    os << "}, \"inside\": ";
    show(os, inside);
    os << ", \"lost\": ";
    show(os, lost());
    os << ", \"mass_closure_error\": " << closureError() << "}";
}


} // End namespace Foam

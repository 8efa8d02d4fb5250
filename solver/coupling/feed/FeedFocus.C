/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Which sizes a feed knows best: those at which the cut is expected.

\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "foam/digits.H"
#include "foam/foamVersion.H"
#include "uniformDimensionedFields.H"
#include "volFields.H"

namespace Foam
{

elutria::laws::Gas Feed::gas(const word& phaseName) const
{
    const auto mean = [&](const char* field)
    {
        return ofAnyOrder
        (
            gAverage
            (
                mesh_.lookupObject<volScalarField>
                (
                    IOobject::groupName(field, phaseName)
                ).primitiveField()
            )
        );
    };
    return {mean("rho"), mean("mu")};
}


vector Feed::gravity() const
{
    return
        mesh_.time().lookupObject<uniformDimensionedVectorField>("g").value();
}


scalar Feed::superficialSpeed(const word& phaseName) const
{
    const vector g(gravity());
    const scalarField height(mesh_.points() & g/max(mag(g), VSMALL));
    const scalar section =
        ofAnyOrder(gSum(mesh_.V())/(gMax(height) - gMin(height)));
    return gasFlow_/(gas(phaseName).density*section);
}


scalar Feed::settlingSize(const Material& material, const word& phaseName) const
{
    using namespace elutria::laws;
    Drag drag = SchillerNaumann::CdRe;
    if (material.measured)
    {
        drag = MeasuredVelocity::CdRe;
    }
    else if (material.form.hasAxes())
    {
        drag = BagheriBonadonna::CdRe;
    }
    else if (material.form.sphericity < 1)
    {
        drag = HaiderLevenspiel::CdRe;
    }

    return elutria::laws::settlingSize
    (
        drag, {material.density, material.form},
        superficialSpeed(phaseName), gas(phaseName), mag(gravity()),
        material.sizes.min(), material.sizes.max()
    );
}


void Feed::readFocus(const word& phaseName)
{
    token asked(word("none"));
    if (found("focus"))
    {
        asked = token(lookup("focus"));
    }
    const bool automatic = asked.isWord() && asked.wordToken() == "auto";
    const bool given = asked.isNumber() && asked.number() > 0;
    if (!automatic && !given && !(asked.isWord() && asked.wordToken() == "none"))
    {
        FatalIOErrorInFunction(*this)
            << "focus is " << asked << ", allowed: none, auto or a size > 0"
            << exit(FatalIOError);
    }
    if (sampling_ != Sampling::evenSizes)
    {
        return;
    }
    const dictionary& told = told_.subOrEmptyDict("focus");

    // Else parcels must meet, and the sizes aside need their number
    const bool dilute = isDilute();
    for (Material& m : materials_)
    {
        if (told.found(m.name))
        {
            m.focus = told.get<scalar>(m.name);
        }
        else if (given)
        {
            m.focus = asked.number();
        }
        else if (automatic && dilute)
        {
            m.focus = settlingSize(m, phaseName);
        }
        if (m.focus > 0)
        {
            m.sizes.focusOn(m.focus);
        }
    }
}


} // End namespace Foam

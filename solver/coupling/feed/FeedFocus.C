/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Which sizes a feed knows best: those at which the cut is expected.

\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "laws/DragLaws.H"
#include "foam/foamVersion.H"
#include "uniformDimensionedFields.H"
#include "volFields.H"

namespace Foam
{

scalar Feed::settlingSize(const Material& material, const word& phaseName) const
{
    const auto mean = [&](const char* field)
    {
        return gAverage
        (
            mesh_.lookupObject<volScalarField>
            (
                IOobject::groupName(field, phaseName)
            ).primitiveField()
        );
    };
    const scalar rho = mean("rho"), mu = mean("mu");
    const vector g
    (
        mesh_.time().lookupObject<uniformDimensionedVectorField>("g").value()
    );
    const scalarField height(mesh_.points() & g/max(mag(g), VSMALL));
    const scalar section = gSum(mesh_.V())/(gMax(height) - gMin(height));
    const scalar speed = gasMassFlow(phaseName)/(rho*section);

    const auto law =
        material.sphericity < 1
      ? dragLaws::HaiderLevenspiel::CdRe : dragLaws::SchillerNaumann::CdRe;

    // Weight less drag of a size that falls at that speed, per volume
    const auto excess = [&](const scalar d)
    {
        const scalar drag = law(rho*speed*d/mu, 1, material.sphericity);
        return
            (material.density - rho)*mag(g) - 0.75*mu*speed/sqr(d)*drag;
    };
    scalar low = material.sizes.min(), high = material.sizes.max();
    if (!(excess(low) < 0 && excess(high) > 0))
    {
        return 0;                       // all go one way
    }
    for (label halving = 0; halving < 40; ++halving)
    {
        const scalar middle = std::sqrt(low*high);
        (excess(middle) < 0 ? low : high) = middle;
    }
    return low;
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

    // Else parcels must meet, and the sizes aside need their number
    const bool dilute = isDilute(phaseName);
    for (Material& m : materials_)
    {
        if (given)
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

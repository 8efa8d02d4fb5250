/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/ContactEstimate.H"
#include "foam/foamVersion.H"
#include "mathematicalConstants.H"

namespace Foam
{

scalar ContactEstimate::duration
(
    const scalar diameter,
    const scalar speed
) const
{
    scalar lightest = GREAT;
    for (const Feed::Material& m : feed_.materials())
    {
        lightest = min(lightest, m.leastDensity());
    }
    elutria::dem::Particles pair;
    for (const label i : {0, 1})
    {
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
    return engine_.stepLimit(pair, speed)/stepFraction();
}


scalar ContactEstimate::deepestOverlap(const scalar speed) const
{
    scalar deepest = 0;
    for (const Feed::Material& m : feed_.materials())
    {
        deepest = max
        (
            deepest,
            engine_.expectedOverlap(0.5*m.sizes.max(), m.largestDensity(), speed)
        );
    }
    return deepest;
}


bool ContactEstimate::softOnly() const
{
    return
        engine_.settings().treatment == elutria::dem::ContactTreatment::soft;
}


bool hasFriction(const elutria::dem::Engine& engine)
{
    const elutria::dem::ContactMaterials& materials = engine.materials();
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


} // End namespace Foam

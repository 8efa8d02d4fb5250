/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "schedule/CaseDrag.H"
#include "foam/foamVersion.H"

namespace Foam
{

namespace
{

//- Sizes beyond which a cut is not looked for [m]
constexpr scalar smallestCut = 1e-7, largestCut = 0.1;

} // End anonymous namespace


CaseDrag::CaseDrag(const dictionary& cloudProperties)
:
    law_(nullptr),
    sphericity_(0)
{
    DynamicList<word> forces;
    const dictionary& all =
        cloudProperties.subDict("subModels").subDict("particleForces");

    for (const entry& force : all)
    {
        const elutria::laws::DragLaw* law =
            elutria::laws::findDragLaw(force.keyword());
        if (law || force.keyword().find("Drag") != std::string::npos)
        {
            forces.append(force.keyword());
        }
        if (law && !law_)
        {
            law_ = law;
            if (force.isDict() && force.keyword() == "nonSphereDrag")
            {
                sphericity_ = force.dict().get<scalar>("phi");
            }
        }
    }
    forces_.transfer(forces);
    if (!law_)
    {
        law_ = elutria::laws::findDragLaw(elutria::laws::SchillerNaumann::name);
    }
}


elutria::laws::Grain CaseDrag::grain(const Feed::Material& material) const
{
    elutria::laws::Grain grain{material.density, material.form};
    if (sphericity_ > 0)
    {
        grain.form = {sphericity_};
    }
    return grain;
}


bool CaseDrag::ignoresShape(const Feed::Material& material) const
{
    const elutria::laws::Form& form = material.form;
    const bool known =
        forces_.size() == 1 && elutria::laws::findDragLaw(forces_[0]);
    if
    (
        !known || sphericity_ > 0 || form.measured
     || (form.sphericity == 1 && !form.hasAxes())
    )
    {
        return false;
    }
    elutria::laws::Form sphere(form);
    sphere.sphericity = sphere.flatness = sphere.elongation = 1;
    constexpr scalar Re = 100;
    return law_->CdRe(Re, 1, form) == law_->CdRe(Re, 1, sphere);
}


scalar CaseDrag::relaxationTime
(
    const Feed::Material& material,
    const scalar diameter,
    const scalar slip,
    const elutria::laws::Gas& gas
) const
{
    return elutria::laws::relaxationTime
    (
        law_->CdRe, grain(material), diameter, slip, gas
    );
}


scalar CaseDrag::terminalVelocity
(
    const Feed::Material& material,
    const scalar diameter,
    const elutria::laws::Gas& gas,
    const scalar gravity
) const
{
    return elutria::laws::terminalVelocity
    (
        law_->CdRe, grain(material), diameter, gas, gravity
    );
}


scalar CaseDrag::settlingSize
(
    const Feed::Material& material,
    const scalar velocity,
    const elutria::laws::Gas& gas,
    const scalar gravity
) const
{
    return elutria::laws::settlingSize
    (
        law_->CdRe, grain(material), velocity, gas, gravity,
        smallestCut, largestCut
    );
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "schedule/CaseDrag.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "laws/StockDrag.hpp"
#include "StringStream.H"

namespace Foam
{

namespace
{

//- Sizes beyond which a cut is not looked for [m]
constexpr scalar smallestCut = 1e-7, largestCut = 0.1;


//- Has a force one sphericity for all particles?
bool hasOwnSphericity(const word& force)
{
    const elutria::laws::StockDrag* const stock =
        elutria::laws::findStockDrag(force);
    return
        stock
     && stock->takes == elutria::laws::StockDrag::Shape::ownSphericity;
}


//- Laws of ours that take a shape, for a message
std::string lawsOfShape()
{
    std::string names;
    for (const elutria::laws::DragLaw& law : elutria::laws::dragLaws())
    {
        if (law.knowsShape)
        {
            names += std::string(names.empty() ? "" : ", ") + law.name;
        }
    }
    return names;
}

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
            if (force.isDict() && hasOwnSphericity(force.keyword()))
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


bool CaseDrag::knowsShape(const Feed::Material& material) const
{
    for (const word& force : forces_)
    {
        const elutria::laws::DragLaw* const law =
            elutria::laws::findDragLaw(force);
        const elutria::laws::StockDrag* const stock =
            elutria::laws::findStockDrag(force);
        const bool measured = material.measured
         && force == elutria::laws::MeasuredVelocity::name;
        const bool other = hasOwnSphericity(force)
         && mag(sphericity_ - material.form.sphericity) > SMALL;
        const bool ofSpheres =
            stock ? stock->takes == elutria::laws::StockDrag::Shape::sphere
          : law && !law->knowsShape;

        if (measured || !(other || ofSpheres))
        {
            return true;
        }
    }
    return forces_.empty();
}


void CaseDrag::requireShapesKnown(const Feed& feed) const
{
    for (const Feed::Material& material : feed.materials())
    {
        const elutria::laws::Form& form = material.form;
        if ((form.sphericity == 1 && !form.hasAxes()) || knowsShape(material))
        {
            continue;
        }
        OStringStream shape;
        if (form.hasAxes())
        {
            shape
                << "flatness " << form.flatness
                << " and elongation " << form.elongation;
        }
        else
        {
            shape << "sphericity " << form.sphericity;
        }
        FatalIOErrorInFunction(feed)
            << material.name << " has " << shape.str().c_str() << ", which "
            << listed(forces_).c_str() << " does not take, allowed: 1, or"
            << " particleForces with one of " << lawsOfShape().c_str()
            << exit(FatalIOError);
    }
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

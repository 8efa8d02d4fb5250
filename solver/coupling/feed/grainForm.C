/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/grainForm.H"
#include "feed/SizeDistribution.H"
#include "foam/caseText.H"
#include "foam/ownEntries.H"
#include "foam/requireAllowed.H"
#include "foam/Warnings.H"

#include <stdexcept>

namespace Foam
{

namespace
{

scalar readShare(const dictionary& dict, const word& entry)
{
    const scalar value = dict.get<scalar>(entry);
    if (!(value > 0 && value <= 1))
    {
        FatalIOErrorInFunction(dict)
            << entry << " is " << value << ", allowed: 0 < value <= 1"
            << exit(FatalIOError);
    }
    return value;
}

} // End anonymous namespace


elutria::laws::Form readForm(const dictionary& dict)
{
    elutria::laws::Form form;
    const bool flat = dict.found("flatness"), slender = dict.found("elongation");
    if (flat != slender || (flat && dict.found("sphericity")))
    {
        FatalIOErrorInFunction(dict)
            << "the shape is of "
            << (dict.found("sphericity") ? "sphericity " : "")
            << (flat ? "flatness " : "") << (slender ? "elongation" : "")
            << ", allowed: sphericity, or both flatness and elongation"
            << exit(FatalIOError);
    }
    if (flat)
    {
        form.flatness = readShare(dict, "flatness");
        form.elongation = readShare(dict, "elongation");
        form.sphericity =
            elutria::laws::ellipsoidSphericity(form.flatness, form.elongation);
    }
    else if (dict.found("sphericity"))
    {
        form.sphericity = readShare(dict, "sphericity");
    }
    return form;
}


std::shared_ptr<const elutria::laws::MeasuredDrag> readMeasuredDrag
(
    const dictionary& material,
    const scalar density
)
{
    if (!material.found("measuredVelocity"))
    {
        return nullptr;
    }
    const dictionary& dict = material.subDict("measuredVelocity");
    requireOwnEntries(dict, ownDictionary::measuredVelocity);
    const fileName file(fileNameIn(dict, "file"));
    const scalar rho = dict.getOrDefault<scalar>("gasDensity", 1.2);
    const scalar mu = dict.getOrDefault<scalar>("gasViscosity", 1.8e-5);
    requireAllowed("gasDensity", rho, above(0), dict);
    requireAllowed("gasViscosity", mu, above(0), dict);
    if (rho >= density)
    {
        FatalIOErrorInFunction(dict)
            << "gasDensity is " << rho << ", allowed: below the grains' "
            << density << " kg/m3" << exit(FatalIOError);
    }

    std::string text;
    try
    {
        text = caseText(file);
        return std::make_shared<elutria::laws::MeasuredDrag>
        (
            elutria::laws::velocityTable(text), density, rho, mu
        );
    }
    catch (const std::invalid_argument& refused)
    {
        const std::string where(text.empty() ? "" : "file " + file + ": ");
        FatalIOErrorInFunction(dict)
            << (where + refused.what()).c_str() << exit(FatalIOError);
        throw;
    }
}


void warnOfSizes
(
    const word& material,
    const elutria::laws::MeasuredDrag& measured,
    const SizeDistribution& sizes
)
{
    const scalar finest = sizes.min(), coarsest = sizes.max();
    if (finest >= measured.smallest() && coarsest <= measured.largest())
    {
        return;
    }
    OStringStream found;
    found<< "sizes from " << finest << " to " << coarsest
        << " m are fed, measured: " << measured.smallest() << " to "
        << measured.largest() << " m";
    Warnings::add
    ({
        "measuredVelocity",
        std::string(material) + " has sizes of which no velocity was measured",
        found.str(),
        "measure them; until then their drag over a sphere's is that of the"
        " nearest size measured",
        max(measured.smallest()/finest, coarsest/measured.largest())
    });
}


} // End namespace Foam

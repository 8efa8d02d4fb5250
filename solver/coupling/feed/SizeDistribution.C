/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/SizeDistribution.H"
#include "foam/caseText.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "laws/SizeTables.hpp"
#include "scalarList.H"

#include <stdexcept>

namespace Foam
{

namespace
{

namespace laws = elutria::laws;


std::vector<double> readNumbers(const dictionary& dict, const word& entry)
{
    const scalarList numbers(dict.get<scalarList>(entry));
    return {numbers.cbegin(), numbers.cend()};
}


//- A file that the dictionary names, from the case's folder
laws::CumulativeCurve readSieveFile(const dictionary& dict)
{
    const fileName given(fileNameIn(dict, "file"));
    const std::string text(caseText(given));
    try
    {
        return laws::sieveTable
        (
            text, dict.found("min") ? dict.get<scalar>("min") : 0
        );
    }
    catch (const std::invalid_argument& refused)
    {
        throw std::invalid_argument("file " + given + ": " + refused.what());
    }
}


//- With entries that the dictionary may have beside those of its law
laws::CumulativeCurve statedCurve
(
    const dictionary& dict,
    const wordList& others
);


laws::CumulativeCurve readSum(const dictionary& dict)
{
    std::vector<laws::CumulativeCurve> curves;
    std::vector<double> shares;
    for (const entry& part : dict.subDict("parts"))
    {
        curves.push_back(statedCurve(part.dict(), {"share"}));
        shares.push_back(part.dict().get<scalar>("share"));
    }
    return laws::mixed(curves, shares);
}


laws::CumulativeCurve statedCurve
(
    const dictionary& dict,
    const wordList& others
)
{
    const word type(dict.get<word>("type"));
    wordList entries{"type", "weighting"};
    entries.append(others);
    if (type == "fixedValue")
    {
        entries.append("value");
        requireEntries(dict, entries);
        return laws::single(dict.get<scalar>("value"));
    }
    if (type == "table")
    {
        entries.append(wordList({"diameters", "cumulative"}));
        requireEntries(dict, entries);
        return laws::sieved
        (
            readNumbers(dict, "diameters"), readNumbers(dict, "cumulative")
        );
    }

    if (type == "sieve")
    {
        entries.append(wordList({"file", "min"}));
        requireEntries(dict, entries);
        return readSieveFile(dict);
    }
    if (type == "sum")
    {
        entries.append("parts");
        requireEntries(dict, entries);
        return readSum(dict);
    }

    const laws::SizeLaw* law = laws::findSizeLaw(type);
    if (!law)
    {
        std::string names;
        for (const laws::SizeLaw& known : laws::sizeLaws())
        {
            names += std::string(known.name) + ", ";
        }
        throw std::invalid_argument
        (
            "type is " + type + ", allowed: " + names
          + "fixedValue, table, sieve, sum"
        );
    }
    std::vector<double> parameters;
    entries.append(wordList({"min", "max"}));
    for (const char* name : law->parameters)
    {
        parameters.push_back(dict.get<scalar>(name));
        entries.append(name);
    }
    requireEntries(dict, entries);
    return laws::truncated
    (
        *law, parameters.data(), dict.get<scalar>("min"), dict.get<scalar>("max")
    );
}


laws::Weighting readWeighting(const dictionary& dict)
{
    const word weighting(dict.getOrDefault<word>("weighting", "mass"));
    if (weighting != "mass" && weighting != "number")
    {
        throw std::invalid_argument
        (
            "weighting is " + weighting + ", allowed: mass, number"
        );
    }
    return
        weighting == "mass" ? laws::Weighting::mass : laws::Weighting::number;
}


laws::SizeCurves readCurves(const dictionary& dict)
{
    try
    {
        return {statedCurve(dict, {}), readWeighting(dict)};
    }
    catch (const std::invalid_argument& refused)
    {
        FatalIOErrorInFunction(dict) << refused.what() << exit(FatalIOError);
        throw;
    }
}

} // End anonymous namespace


SizeDistribution::SizeDistribution(const dictionary& dict)
:
    elutria::laws::SizeCurves(readCurves(dict))
{}


} // End namespace Foam

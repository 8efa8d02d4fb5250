/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/feedRate.H"
#include "foam/foamVersion.H"
#include "foam/requireAllowed.H"
#include "Function1.H"
#include "StringStream.H"
#include "TableBase.H"

#include <stdexcept>

namespace Foam
{

namespace
{

//- A number, as most feeds have
bool isNumber(const entry& e)
{
    return e.isStream() && e.stream().size() == 1 && e.stream()[0].isNumber();
}


[[noreturn]] void refuse(const dictionary& feed, const string& why)
{
    FatalIOErrorInFunction(feed)
        << "massFlowRate: " << why.c_str() << exit(FatalIOError);
    throw std::logic_error("not reached");
}


//- OpenFOAM's function; what it says of a wrong one names no file
autoPtr<Function1<scalar>> readFunction(const dictionary& feed)
{
    const bool threw = FatalError.throwExceptions();
    const bool threwIO = FatalIOError.throwExceptions();
    autoPtr<Function1<scalar>> found;
    string why;
    try
    {
        found = Function1<scalar>::New("massFlowRate", feed);
    }
    catch (const Foam::error& error)
    {
        why = error.message();
    }
    FatalError.throwExceptions(threw);
    FatalIOError.throwExceptions(threwIO);
    if (!found)
    {
        why.replaceAll("\n", " ");
        refuse(feed, why + ", allowed: a number (kg/s), or a table ((s kg/s) ...)");
    }
    return found;
}


//- Between its times a table may be other than linear
void requireLinear(const dictionary& feed)
{
    const dictionary& own = feed.optionalSubDict("massFlowRate");
    const word scheme
    (
        own.getOrDefault<word>("interpolationScheme", "linear")
    );
    if (&own != &feed && scheme != "linear")
    {
        refuse(feed, "interpolationScheme is " + scheme + ", allowed: linear");
    }
}

} // End anonymous namespace


std::unique_ptr<const elutria::laws::RateTable> readRateTable
(
    const dictionary& feed
)
{
    if (isNumber(*feed.findEntry("massFlowRate", keyType::LITERAL)))
    {
        return nullptr;
    }
    const autoPtr<Function1<scalar>> function(readFunction(feed));
    const auto* const table =
        dynamic_cast<const Function1Types::TableBase<scalar>*>(function.get());
    if (!table)
    {
        refuse
        (
            feed, "a function of type " + function->type() + ", allowed: a"
            " number (kg/s), table, tableFile, csvFile"
        );
    }
    requireLinear(feed);
    const scalarField times(table->x()), rates(table->y());
    try
    {
        return std::make_unique<const elutria::laws::RateTable>
        (
            std::vector<double>(times.cbegin(), times.cend()),
            std::vector<double>(rates.cbegin(), rates.cend())
        );
    }
    catch (const std::invalid_argument& refused)
    {
        refuse(feed, refused.what());
    }
}


scalar feedDuration
(
    const dictionary& feed,
    const elutria::laws::RateTable* table
)
{
    if (feed.found("duration"))
    {
        return readAllowed(feed, "duration", above(0, longestFeed));
    }
    return table ? table->end() - feed.getOrDefault<scalar>("start", 0) : GREAT;
}


void stateRate(dictionary& feed)
{
    const auto table = readRateTable(feed);
    if (!table)
    {
        return;
    }
    OStringStream text;
    text.precision(17);
    text<< "massFlowRate table (";
    for (size_t i = 0; i < table->times().size(); ++i)
    {
        text<< " (" << table->times()[i] << ' ' << table->rates()[i] << ')';
    }
    text<< " );";
    IStringStream is(text.str());
    feed.set(dictionary(is).findEntry("massFlowRate")->clone(feed).ptr());
}


} // End namespace Foam

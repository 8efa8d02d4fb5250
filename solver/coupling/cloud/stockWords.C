/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/stockWords.H"
#include "foam/honoured.H"
#include "IOdictionary.H"
#include "Time.H"

namespace Foam
{

using honoured::kind;

namespace
{

//- A switch that is off asks for nothing
bool isAsked(const entry& e)
{
    const ITstream* const value = e.isDict() ? nullptr : &e.stream();
    if (!value || value->size() != 1 || !value->first().isWord())
    {
        return true;
    }
    const word& said = value->first().wordToken();
    return said != "none" && said != "off" && said != "no" && said != "false";
}


//- End the run at the first entry that the list has as refused
void refuseOf(const kind of, const dictionary& dict)
{
    for (const entry& e : dict)
    {
        if (honoured::isRefused(of, e.keyword()) && isAsked(e))
        {
            FatalIOErrorInFunction(dict)
                << e.keyword() << ": "
                << honoured::find(of, e.keyword())->why << exit(FatalIOError);
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void refuseOthersModels(const objectRegistry& mesh, const word& cloud)
{
    const IOdictionary properties
    (
        IOobject
        (
            cloud + "Properties", mesh.time().constant(), mesh,
            IOobject::READ_IF_PRESENT, IOobject::NO_WRITE, false
        )
    );
    const dictionary models(properties.subOrEmptyDict("subModels"));
    refuseOf(kind::cloudModel, models);
    refuseOf(kind::particleForce, models.subOrEmptyDict("particleForces"));
}


wordList entriesWithoutEffect(const dictionary& properties)
{
    wordList found;
    for (const entry& e : properties.subOrEmptyDict("solution"))
    {
        const honoured::Item* const item =
            honoured::find(kind::cloudEntry, e.keyword());
        if (item && item->is == honoured::use::noEffect && isAsked(e))
        {
            found.append(e.keyword());
        }
    }
    return found;
}


} // End namespace Foam

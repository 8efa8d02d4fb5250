/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/contactLimits.H"
#include "cloud/WallHits.H"
#include "contacts/SymmetryWalls.H"
#include "foam/honoured.H"
#include "wordRes.H"

namespace Foam
{

namespace
{

using honoured::kind;

//- Why what is on the list is refused, and what is allowed
std::string contactsAreOurs(const kind of, const word& name)
{
    return
        std::string("since collisionModel cellList resolves the contacts with")
      + " it; allowed: " + honoured::find(of, name)->why;
}


//- Where the patch interaction model would do more than turn particles back
void refuseInteractions(const dictionary& properties, const polyMesh& mesh)
{
    const dictionary& models = properties.subOrEmptyDict("subModels");
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (!isSymmetry(patch))
        {
            continue;
        }
        const word what(interactionAt(patch, models));
        if (honoured::isRefused(kind::symmetryWithContacts, what))
        {
            FatalIOErrorInFunction(models)
                << "patchInteractionModel: '" << what
                << "' would not happen at the plane of symmetry "
                << patch.name() << ", "
                << contactsAreOurs(kind::symmetryWithContacts, what).c_str()
                << exit(FatalIOError);
        }
    }
}


//- Functions of the cloud that are called at hits, of which the engine does not
//  tell
void refuseFunctions(const dictionary& properties, const polyMesh& mesh)
{
    for (const entry& function : properties.subOrEmptyDict("cloudFunctions"))
    {
        if (!function.isDict())
        {
            continue;
        }
        const dictionary& dict = function.dict();
        const word type(dict.getOrDefault<word>("type", ""));
        for (const polyPatch& patch : mesh.boundaryMesh())
        {
            const bool records =
                honoured::isRefused(kind::symmetryFunctionWithContacts, type);
            const wordRes patches
            (
                dict.getOrDefault<wordRes>("patches", wordRes())
            );
            if
            (
                records && isSymmetry(patch)
             && (type == "patchCollisionDensity" || patches.match(patch.name()))
            )
            {
                FatalIOErrorInFunction(dict)
                    << "type: '" << type << "' would record no hit of the plane of symmetry "
                    << patch.name() << ", "
                    << contactsAreOurs
                       (
                           kind::symmetryFunctionWithContacts, type
                       ).c_str()
                    << exit(FatalIOError);
            }
        }
    }
}

//- What models and functions would do at surfaces, which are no patches
void refuseAtSurfaces(const dictionary& properties, const wordList& surfaces)
{
    const dictionary& models = properties.subOrEmptyDict("subModels");
    const word what(interactionAtSurfaces(models));
    for (const word& surface : surfaces)
    {
        if (honoured::isRefused(kind::surfaceWithContacts, what))
        {
            FatalIOErrorInFunction(models)
                << "patchInteractionModel: '" << what << "' would not happen at"
                << " the surface " << surface << ", "
                << contactsAreOurs(kind::surfaceWithContacts, what).c_str()
                << exit(FatalIOError);
        }
        for (const entry& function : properties.subOrEmptyDict("cloudFunctions"))
        {
            const dictionary& dict =
                function.isDict() ? function.dict() : dictionary::null;
            const word type(dict.getOrDefault<word>("type", ""));
            const kind of = kind::surfaceFunctionWithContacts;
            if
            (
                honoured::isRefused(of, type)
             && dict.getOrDefault<wordRes>("patches", wordRes()).match(surface)
            )
            {
                FatalIOErrorInFunction(dict)
                    << "type: '" << type << "' would record no hit of the"
                    << " surface " << surface << ", "
                    << contactsAreOurs(of, type).c_str() << exit(FatalIOError);
            }
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void refuseWithContacts
(
    const dictionary& properties,
    const polyMesh& mesh,
    const wordList& surfaces
)
{
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (honoured::isRefused(kind::patchWithContacts, patch.type()))
        {
            FatalErrorInFunction
                << "constant/polyMesh/boundary: " << patch.name() << ": '"
                << patch.type() << "': "
                << honoured::find(kind::patchWithContacts, patch.type())->why
                << " in " << properties.name() << exit(FatalError);
        }
    }
    refuseInteractions(properties, mesh);
    refuseFunctions(properties, mesh);
    refuseAtSurfaces(properties, surfaces);
}


} // End namespace Foam

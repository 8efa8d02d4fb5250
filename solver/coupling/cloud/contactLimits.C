/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/contactLimits.H"
#include "contacts/SymmetryWalls.H"
#include "foam/honoured.H"
#include "patchInteractionDataList.H"
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
      + " walls; allowed: " + honoured::find(of, name)->why;
}


//- What happens to a particle at a wall, by the model that would rule there
word interactionAt
(
    const polyPatch& wall,
    const word& model,
    const dictionary& coeffs
)
{
    if (model == "standardWallInteraction")
    {
        return coeffs.getOrDefault<word>("type", "rebound");
    }
    if (model == "localInteraction")
    {
        const patchInteractionDataList all(wall.boundaryMesh().mesh(), coeffs);
        const label k = all.applyToPatch(wall.index());
        return k < 0 ? word("rebound") : all[k].interactionTypeName();
    }
    return word("rebound");
}


void refuseInteractions(const dictionary& properties, const polyMesh& mesh)
{
    const dictionary& models = properties.subOrEmptyDict("subModels");
    const word model
    (
        models.getOrDefault<word>("patchInteractionModel", "none")
    );
    const dictionary& coeffs = models.subOrEmptyDict(model + "Coeffs");
    const bool never = honoured::isRefused(kind::wallModelWithContacts, model);
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (!isContactPatch(patch))
        {
            continue;
        }
        const word what = never ? model : interactionAt(patch, model, coeffs);
        const kind of =
            never ? kind::wallModelWithContacts : kind::wallWithContacts;
        if (honoured::isRefused(of, what))
        {
            FatalIOErrorInFunction(models)
                << "patchInteractionModel: " << model << ": '" << what
                << "' would not happen at the wall " << patch.name() << ", "
                << contactsAreOurs(of, what).c_str() << exit(FatalIOError);
        }
    }
}


//- Functions of the cloud that are called at hits, which the engine does not
//  tell them
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
                honoured::isRefused(kind::wallFunctionWithContacts, type);
            const wordRes patches
            (
                dict.getOrDefault<wordRes>("patches", wordRes())
            );
            if
            (
                records && isContactPatch(patch)
             && (type == "patchCollisionDensity" || patches.match(patch.name()))
            )
            {
                FatalIOErrorInFunction(dict)
                    << "type: '" << type << "' would record no hit of the wall "
                    << patch.name() << ", "
                    << contactsAreOurs
                       (
                           kind::wallFunctionWithContacts, type
                       ).c_str()
                    << exit(FatalIOError);
            }
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void refuseWithContacts(const dictionary& properties, const polyMesh& mesh)
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
}


} // End namespace Foam

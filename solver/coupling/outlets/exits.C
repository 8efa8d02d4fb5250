/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "outlets/exits.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "patchInteractionDataList.H"
#include "wallPolyPatch.H"

namespace Foam
{

namespace
{

//- What parcels do that come to a patch
enum class way { out, closed, unknown };


//- Where a patchInteractionModel says it for each patch
way localWay(const dictionary& subModels, const polyPatch& patch)
{
    const patchInteractionDataList patches
    (
        patch.boundaryMesh().mesh(), subModels.subDict("localInteractionCoeffs")
    );
    const label group = patches.applyToPatch(patch.index());
    if (group < 0)
    {
        return way::unknown;
    }
    return
        patches[group].interactionTypeName() == "escape"
      ? way::out : way::closed;
}


way wayOf(const dictionary& subModels, const polyPatch& patch)
{
    if (patch.coupled() || polyPatch::constraintType(patch.type()))
    {
        return way::closed;
    }
    const word model(subModels.get<word>("patchInteractionModel"));
    if (model == "localInteraction")
    {
        return localWay(subModels, patch);
    }
    if (model != "none" && model != "standardWallInteraction")
    {
        return way::unknown;
    }
    const dictionary& coeffs = subModels.subOrEmptyDict(model + "Coeffs");
    const bool escapes = coeffs.getOrDefault<word>("type", "") == "escape";
    return isA<wallPolyPatch>(patch) && !escapes ? way::closed : way::out;
}

} // End anonymous namespace


void requireExits
(
    const Feed& feed,
    const fvMesh& mesh,
    const dictionary& subModels
)
{
    const dictionary& outlets = feed.subDict("outlets");
    const word* open = nullptr;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        const label product = feed.productOfPatch(patch.index());
        const way leads = wayOf(subModels, patch);
        if (product >= 0 && leads == way::closed)
        {
            FatalIOErrorInFunction(outlets)
                << feed.products()[product] << ": the patch " << patch.name()
                << " has the type " << patch.type() << ", through which nothing"
                << " leaves, allowed: a patch of the type patch"
                << exit(FatalIOError);
        }
        if (product < 0 && leads == way::out && !open)
        {
            open = &patch.name();
        }
    }
    if (open)
    {
        FatalIOErrorInFunction(outlets)
            << "the open patch " << *open << " belongs to no product, and"
            << " particles that leave through it would be lost, allowed: its"
            << " name in " << listed(feed.products()).c_str()
            << ", in a product other (" << *open << "), or the type wall in the"
            << " mesh" << exit(FatalIOError);
    }
}


} // End namespace Foam

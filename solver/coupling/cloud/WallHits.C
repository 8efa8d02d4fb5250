/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/WallHits.H"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "parallel/CopyTransfer.H"
#include "patchInteractionDataList.H"
#include "wallPolyPatch.H"

#include <algorithm>
#include <set>

namespace Foam
{

namespace
{

using elutria::dem::WallAnswer;
using elutria::dem::WallHit;


bool takes(const word& interaction)
{
    return interaction == "stick" || interaction == "escape";
}


//- At a patch; null: at a wall that is none
word interactionOf
(
    const polyPatch* patch,
    const word& model,
    const dictionary& coeffs
);


//- What is left of all models that act in turn: each sets the parcel's fate
//  anew
word interactionOfMany(const polyPatch* patch, const dictionary& models)
{
    const bool onlyOne = models.getOrDefault<bool>("oneInteractionOnly", false);
    word last("none");
    for (const entry& e : models)
    {
        if (!e.isDict() || (onlyOne && last != "none"))
        {
            continue;
        }
        const word model(e.dict().get<word>("patchInteractionModel"));
        const word what = interactionOf
        (
            patch, model, e.dict().subOrEmptyDict(model + "Coeffs")
        );
        last = what == "none" ? last : what;
    }
    return last;
}


word interactionOf
(
    const polyPatch* patch,
    const word& model,
    const dictionary& coeffs
)
{
    if (model == "standardWallInteraction")
    {
        return
            !patch || isA<wallPolyPatch>(*patch)
          ? coeffs.getOrDefault<word>("type", "rebound") : word("none");
    }
    if (model == "localInteraction" && patch)
    {
        const patchInteractionDataList all(patch->boundaryMesh().mesh(), coeffs);
        const label k = all.applyToPatch(patch->index());
        return k < 0 ? word("none") : all[k].interactionTypeName();
    }
    if (model == "multiInteraction")
    {
        return interactionOfMany(patch, coeffs);
    }
    return model == "none" ? word("none") : word("rebound");
}


word interactionIn(const polyPatch* patch, const dictionary& subModels)
{
    const word model
    (
        subModels.getOrDefault<word>("patchInteractionModel", "none")
    );
    return interactionOf(patch, model, subModels.subOrEmptyDict(model + "Coeffs"));
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

bool WallHits::functionsWantHits() const
{
    // Those of stock that are not called at faces or patches, and ours, which
    // looks for outlets
    static const std::set<word> blind
    {
        "outletRecorder", "particleCollector", "particleTracks", "particleTrap",
        "voidFraction"
    };
    for (const auto& function : cloud_.functions())
    {
        if (!blind.count(function.type()))
        {
            return true;
        }
    }
    return false;
}


void WallHits::collect
(
    const std::vector<WallHit>& hits,
    StepParcels& step,
    const scalar dt,
    IDLList<StockParcel>& copies,
    List<Hit>& told
) const
{
    // By parcel, each one's in order of time
    std::vector<WallHit> ofParcels(hits);
    std::stable_sort
    (
        ofParcels.begin(), ofParcels.end(),
        [](const WallHit& a, const WallHit& b) { return a.id < b.id; }
    );
    const uint32_t firstMaterial = contacts_->nParticleMaterials();
    const auto& walls = contacts_->engine().walls();
    const std::vector<WallFace>& faces = contacts_->wallFaces();

    told.resize(hits.size());
    step.takenAt.resize(cloud_.size());
    step.takenAt = -1;
    label i = 0, n = 0;
    for (const StockParcel& p : cloud_)
    {
        const uint64_t name = parcelName(p);
        auto hit = std::lower_bound
        (
            ofParcels.begin(), ofParcels.end(), name,
            [](const WallHit& h, const uint64_t wanted) { return h.id < wanted; }
        );
        for (; hit != ofParcels.end() && hit->id == name; ++hit)
        {
            const WallFace& face = faces[hit->triangle];
            told[n++] =
            {
                scalar(face.proci), scalar(face.facei),
                toFoam(hit->position), toFoam(hit->velocity),
                toFoam(hit->normal), min(hit->time/dt, scalar(1))
            };
            copies.append(new StockParcel(p));
            if (hit->answer == WallAnswer::takes)
            {
                step.takenAt[i] =
                    wallPatches_[walls.material(hit->triangle) - firstMaterial];
            }
        }
        ++i;
    }
    told.resize(n);
}


bool WallHits::putOnFace(StockParcel& p, const Hit& hit) const
{
    const label facei = hit.facei;
    const label celli = mesh().faceOwner()[facei];
    const point& centre = mesh().C()[celli];
    const auto& box = contacts_->engine().settings().box;
    const point touched(hit.position - 0.5*p.d()*hit.normal);
    const vector way
    (
        toFoam(box.shortest(toEngine(touched) - toEngine(centre)))
    );

    // Beyond where it touches; at a rim, to the face's centre
    for
    (
        const vector& displacement :
        {2*way, 2*(mesh().faceCentres()[facei] - centre)}
    )
    {
        p.relocate(centre, celli);
        p.trackToFace(displacement, 0);
        if (p.onFace() && p.face() == facei)
        {
            return true;
        }
    }
    return false;
}


void WallHits::tellHere
(
    IDLList<StockParcel>& copies,
    const UList<Hit>& told,
    StockTracking& td
)
{
    label n = 0;
    for (StockParcel& p : copies)
    {
        const Hit& hit = told[n++];
        if (!putOnFace(p, hit))
        {
            continue;
        }
        p.U() = hit.velocity;
        p.age() += (hit.stepFraction - p.stepFraction())*mesh().time().deltaTValue();
        p.stepFraction() = hit.stepFraction;
        td.keepParticle = true;
        callPostFace(cloud_.functions(), p, td);
        p.hitFace(hit.velocity, cloud_, td);
    }
    td.keepParticle = true;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

WallHits::WallHits(StockCloud& cloud, CloudContacts* contacts)
:
    cloud_(cloud),
    contacts_(contacts),
    sticks_(mesh().boundaryMesh().size(), false),
    any_(false)
{
    if (!contacts_)
    {
        return;
    }
    const dictionary& models = cloud_.subModelProperties();
    const bool functions = functionsWantHits();
    std::vector<WallAnswer> answers(contacts_->nParticleMaterials());
    for (const polyPatch& patch : mesh().boundaryMesh())
    {
        if (!isA<wallPolyPatch>(patch))
        {
            continue;
        }
        wallPatches_.append(patch.index());
        const word interaction = interactionAt(patch, models);
        sticks_[patch.index()] = interaction == "stick";
        answers.push_back
        (
            takes(interaction) ? WallAnswer::takes
          : functions ? WallAnswer::told : WallAnswer::silent
        );
        any_ = any_ || answers.back() != WallAnswer::silent;
    }
    if (any_)
    {
        contacts_->engine().setWallAnswers(answers);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void WallHits::tell
(
    const std::vector<WallHit>& hits,
    StepParcels& step,
    StockTracking& td,
    const scalar dt
)
{
    step.takenAt.clear();
    if (!any_)
    {
        return;
    }
    IDLList<StockParcel> copies;
    List<Hit> told;
    collect(hits, step, dt, copies, told);
    sendCopies(mesh(), copies, told);
    tellHere(copies, told, td);
}


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

word interactionAt(const polyPatch& patch, const dictionary& subModels)
{
    return interactionIn(&patch, subModels);
}


word interactionAtSurfaces(const dictionary& subModels)
{
    return interactionIn(nullptr, subModels);
}


} // End namespace Foam

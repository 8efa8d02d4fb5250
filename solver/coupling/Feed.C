/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "Feed.H"
#include "foamVersion.H"
#include "volFields.H"
#include "mathematicalConstants.H"
#include "wordRes.H"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace Foam
{

defineTypeNameAndDebug(Feed, 0);

namespace
{

constexpr scalar piBy6 = constant::mathematical::pi/6;

scalar readAtLeast(const dictionary& dict, const word& entry, scalar least)
{
    const scalar value = dict.get<scalar>(entry);
    if (!(value >= least) || !std::isfinite(value))
    {
        FatalIOErrorInFunction(dict)
            << entry << " is " << value << ", allowed: >= " << least
            << exit(FatalIOError);
    }
    return value;
}


scalar readPositive(const dictionary& dict, const word& entry)
{
    return readAtLeast(dict, entry, VSMALL);
}


//- Sort places by their coordinates: the same order for any decomposition
template<class Place, class Key>
void sortByPosition(List<Place>& places, const Key& key)
{
    std::sort
    (
        places.begin(), places.end(),
        [&](const Place& a, const Place& b)
        {
            const point p = key(a), q = key(b);
            return std::tie(p.x(), p.y(), p.z()) < std::tie(q.x(), q.y(), q.z());
        }
    );
}


vector areaNormal(const triPoints& t)
{
    return 0.5*((t[1] - t[0]) ^ (t[2] - t[0]));
}


scalarList cumulativeShares(const scalarList& weights)
{
    scalarList shares(weights.size());
    std::partial_sum(weights.cbegin(), weights.cend(), shares.begin());
    for (scalar& share : shares)
    {
        share /= shares.last();
    }
    return shares;
}


//- Index of the class in which u lies
label select(const scalarList& cumulative, const scalar u)
{
    return min
    (
        label
        (
            std::upper_bound(cumulative.cbegin(), cumulative.cend(), u)
          - cumulative.cbegin()
        ),
        cumulative.size() - 1
    );
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Material  * * * * * * * * * * * * * * * * //

Feed::Material::Material(const word& name, const dictionary& dict)
:
    name(name),
    density(readPositive(dict, "density")),
    sphericity(dict.getOrDefault<scalar>("sphericity", 1)),
    massFraction(readAtLeast(dict, "massFraction", 0)),
    numberFraction(0),
    sizes(dict.subDict("sizeDistribution"))
{
    if (!(sphericity > 0 && sphericity <= 1))
    {
        FatalIOErrorInFunction(dict)
            << "sphericity is " << sphericity << ", allowed: 0 < value <= 1"
            << exit(FatalIOError);
    }
}


scalar Feed::Material::meanMass() const
{
    return density*piBy6*sizes.meanCube();
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Feed::readMaterials()
{
    const dictionary& dict = subDict("materials");
    scalar massSum = 0, numberSum = 0;

    materials_.resize(dict.size());
    label n = 0;
    for (const entry& e : dict)
    {
        if (!e.isDict())
        {
            FatalIOErrorInFunction(dict)
                << e.keyword() << " is not a dictionary of a material"
                << exit(FatalIOError);
        }
        materials_.set(n, new Material(e.keyword(), e.dict()));
        massSum += materials_[n].massFraction;
        numberSum += materials_[n].massFraction/materials_[n].meanMass();
        ++n;
    }

    if (n == 0 || mag(massSum - 1) > 1e-6)
    {
        FatalIOErrorInFunction(dict)
            << "massFraction of all materials adds up to " << massSum
            << ", allowed: 1" << exit(FatalIOError);
    }
    for (Material& m : materials_)
    {
        m.numberFraction = m.massFraction/m.meanMass()/numberSum;
    }
}


void Feed::readOutlets()
{
    const dictionary& dict = subDict("outlets");
    const polyBoundaryMesh& patches = mesh_.boundaryMesh();

    productOfPatch_ = labelList(patches.size(), -1);

    for (const entry& e : dict)
    {
        const label product = products_.size();
        products_.append(e.keyword());

        for (const word& name : dict.get<wordList>(e.keyword()))
        {
            const label patchi = patches.findPatchID(name);
            if (patchi < 0)
            {
                FatalIOErrorInFunction(dict)
                    << "outlet " << e.keyword() << " names the patch " << name
                    << ", allowed: " << patches.names() << exit(FatalIOError);
            }
            productOfPatch_[patchi] = product;
        }
    }
}


void Feed::collectPatch(const polyPatch& patch)
{
    List<List<triPoints>> ofProcessor(Pstream::nProcs());
    DynamicList<triPoints> own;

    for (const face& f : patch)
    {
        // A fan around the first point is enough for a feed patch
        for (label i = 1; i < f.size() - 1; ++i)
        {
            const pointField& p = mesh_.points();
            own.append(triPoints(p[f[0]], p[f[i]], p[f[i+1]]));
        }
    }
    ofProcessor[Pstream::myProcNo()] = own;
    Pstream::gatherList(ofProcessor);
    Pstream::scatterList(ofProcessor);

    for (const List<triPoints>& list : ofProcessor)
    {
        triangles_.append(list);
    }
    sortByPosition
    (
        triangles_,
        [](const triPoints& t) { return (t[0] + t[1] + t[2])/3.0; }
    );

    scalarList areas(triangles_.size());
    forAll(areas, i)
    {
        areas[i] = mag(areaNormal(triangles_[i]));
    }
    cumulativeShare_ = cumulativeShares(areas);
}


void Feed::collectZone(const labelUList& cells)
{
    typedef Tuple2<point, scalar> Place;
    List<List<Place>> ofProcessor(Pstream::nProcs());

    for (const label celli : cells)
    {
        ofProcessor[Pstream::myProcNo()].append
        (
            Place(mesh_.C()[celli], mesh_.V()[celli])
        );
    }
    Pstream::gatherList(ofProcessor);
    Pstream::scatterList(ofProcessor);

    List<Place> places;
    for (const List<Place>& list : ofProcessor)
    {
        places.append(list);
    }
    sortByPosition(places, [](const Place& p) { return p.first(); });

    centres_.resize(places.size());
    extents_.resize(places.size());
    scalarList volumes(places.size());
    forAll(places, i)
    {
        centres_[i] = places[i].first();
        volumes[i] = places[i].second();
        extents_[i] = cbrt(volumes[i]);
    }
    cumulativeShare_ = cumulativeShares(volumes);
}


void Feed::readEntrance()
{
    if (found("patch") == found("zone"))
    {
        FatalIOErrorInFunction(*this)
            << "give either patch or zone: where the feed enters"
            << exit(FatalIOError);
    }

    if (found("patch"))
    {
        const word name(get<word>("patch"));
        const label patchi = mesh_.boundaryMesh().findPatchID(name);
        if (patchi < 0)
        {
            FatalIOErrorInFunction(*this)
                << "patch is " << name << ", allowed: "
                << mesh_.boundaryMesh().names() << exit(FatalIOError);
        }
        collectPatch(mesh_.boundaryMesh()[patchi]);
    }
    else
    {
        const word name(get<word>("zone"));
        const label zonei = mesh_.cellZones().findZoneID(name);
        if (returnReduce(zonei, maxOp<label>()) < 0)
        {
            FatalIOErrorInFunction(*this)
                << "zone is " << name << ", allowed: "
                << mesh_.cellZones().names() << exit(FatalIOError);
        }
        collectZone
        (
            zonei < 0 ? labelUList() : labelUList(mesh_.cellZones()[zonei])
        );
    }

    if (cumulativeShare_.empty())
    {
        FatalIOErrorInFunction(*this)
            << "the feed's patch or zone has no faces or cells"
            << exit(FatalIOError);
    }
    velocity_ = getOrDefault<vector>("velocity", Zero);
}


scalar Feed::gasMassFlow(const word& phaseName) const
{
    const auto& U = mesh_.lookupObject<volVectorField>
    (
        IOobject::groupName("U", phaseName)
    );
    const auto& rho = mesh_.lookupObject<volScalarField>
    (
        IOobject::groupName("rho", phaseName)
    );

    scalar flow = 0;
    forAll(mesh_.boundary(), patchi)
    {
        const fvPatch& patch = mesh_.boundary()[patchi];
        if (patch.coupled())
        {
            continue;
        }
        const scalarField inward
        (
           -(U.boundaryField()[patchi] & patch.Sf())
           *rho.boundaryField()[patchi]
        );
        flow += sum(max(inward, scalar(0)));
    }
    return returnReduce(flow, sumOp<scalar>());
}


void Feed::readSchedule(const word& phaseName)
{
    if (found("loading") == found("massFlowRate"))
    {
        FatalIOErrorInFunction(*this)
            << "give either loading (kg solids per kg gas) or"
            << " massFlowRate (kg/s)" << exit(FatalIOError);
    }

    const scalar massFlow =
        found("massFlowRate")
      ? readPositive(*this, "massFlowRate")
      : readPositive(*this, "loading")*gasMassFlow(phaseName);

    if (!(massFlow > 0))
    {
        FatalIOErrorInFunction(*this)
            << "loading gives a feed of " << massFlow << " kg/s: no gas flows"
            << " in; allowed: an inflow, or massFlowRate"
            << exit(FatalIOError);
    }

    for (const Material& m : materials_)
    {
        meanMass_ += m.numberFraction*m.meanMass();
    }
    rate_ = massFlow/meanMass_;

    const word parcels(getOrDefault<word>("parcels", "particles"));
    evenMass_ = parcels == "evenMass";
    if (!evenMass_ && parcels != "particles")
    {
        FatalIOErrorInFunction(*this)
            << "parcels is " << parcels << ", allowed: particles, evenMass"
            << exit(FatalIOError);
    }

    start_ = found("start") ? readAtLeast(*this, "start", 0) : 0;
    if (!found("duration") && !found("particles"))
    {
        FatalIOErrorInFunction(*this)
            << "give duration (s), particles (a whole number) or both"
            << exit(FatalIOError);
    }
    duration_ = found("duration") ? readPositive(*this, "duration") : GREAT;
    drainTime_ = getOrDefault<scalar>("drainTime", GREAT);
    maxParticles_ = getOrDefault<label>("particles", labelMax);
    seed_ = scrambled(uint64_t(seedEntry()) + 0x9e3779b97f4a7c15ULL);
}


label Feed::seedEntry() const
{
    return getOrDefault<label>("seed", 1);
}


scalar Feed::random(const label i, const label k) const
{
    const uint64_t bits =
        scrambled(seed_ + scrambled((uint64_t(uint32_t(i)) << 8) + uint64_t(k) + 1));

    // 53 bits: the mantissa of a double
    return scalar(bits >> 11)*0x1.0p-53;
}


label Feed::material(const label i) const
{
    scalar u = random(i, 0);
    label m = 0;
    const auto share = [&](const Material& material)
    {
        return evenMass_ ? material.massFraction : material.numberFraction;
    };
    while (m < materials_.size() - 1 && u >= share(materials_[m]))
    {
        u -= share(materials_[m]);
        ++m;
    }
    return m;
}


scalar Feed::diameter(const label i, const label material) const
{
    // Van der Corput's sequence: the digits of i in base 2, mirrored
    uint32_t mirrored = 0;
    for (int bit = 0; bit < 32; ++bit)
    {
        mirrored = (mirrored << 1) | ((uint32_t(i) >> bit) & 1);
    }
    scalar u = mirrored*0x1.0p-32 + random(material, 7);
    u -= std::floor(u);

    const SizeDistribution& sizes = materials_[material].sizes;
    return evenMass_ ? sizes.quantileByMass(u) : sizes.quantileByNumber(u);
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Feed::Feed(const fvMesh& mesh, const word& phaseName)
:
    IOdictionary
    (
        IOobject
        (
            "feed",
            mesh.time().constant(),
            mesh,
            IOobject::MUST_READ,
            IOobject::NO_WRITE
        )
    ),
    mesh_(mesh),
    start_(0),
    duration_(0),
    drainTime_(GREAT),
    maxParticles_(labelMax),
    seed_(0),
    evenMass_(false),
    meanMass_(0),
    rate_(0)
{
    readMaterials();
    readOutlets();
    readEntrance();
    readSchedule(phaseName);
}


const Feed* Feed::find(const fvMesh& mesh, const word& phaseName)
{
    if (const Feed* known = mesh.findObject<Feed>("feed"))
    {
        return known;
    }

    IOobject header("feed", mesh.time().constant(), mesh, IOobject::MUST_READ);
    if (!header.typeHeaderOk<IOdictionary>(false))
    {
        return nullptr;
    }

    Feed* feed = new Feed(mesh, phaseName);
    feed->store();
    return feed;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

scalar Feed::end() const
{
    return start_ + min(duration_, maxParticles_/rate_);
}


label Feed::fedUntil(const scalar time) const
{
    // Particle i enters at start + (i + u_i)/rate
    const scalar slots = (min(time, start_ + duration_) - start_)*rate_;
    if (slots <= 0)
    {
        return 0;
    }

    const label i = label(min(slots, scalar(labelMax - 1)));
    const bool entered = i + random(i, 2) < slots;

    return min(i + label(entered), maxParticles_);
}


scalar Feed::mass(const label i) const
{
    const label m = material(i);
    return materials_[m].density*piBy6*pow3(diameter(i, m));
}


Feed::Particle Feed::particle(const label i) const
{
    Particle p;
    p.time = start_ + (i + random(i, 2))/rate_;
    p.material = material(i);
    p.diameter = diameter(i, p.material);
    p.number = number(i);

    const label k = select(cumulativeShare_, random(i, 3));
    const scalar r = random(i, 4), s = random(i, 5), t = random(i, 6);

    if (triangles_.size())
    {
        // Uniform over the triangle, a radius inside the domain
        const triPoints& tri = triangles_[k];
        const scalar root = std::sqrt(r);
        const vector outward = normalised(areaNormal(tri));
        p.position =
            (1 - root)*tri[0] + root*(1 - s)*tri[1] + root*s*tri[2]
          - 0.5*(1 + 1e-6)*p.diameter*outward;
    }
    else
    {
        const vector within(r - 0.5, s - 0.5, t - 0.5);
        p.position = centres_[k] + extents_[k]*within;
    }
    return p;
}


} // End namespace Foam

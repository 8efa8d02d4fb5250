/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "foam/foamVersion.H"
#include "foam/requirePositive.H"
#include "laws/FeedRules.hpp"
#include "volFields.H"
#include "mathematicalConstants.H"
#include "wordRes.H"

#include <cmath>

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
    const scalar value = dict.get<scalar>(entry);
    requirePositive(entry, value, dict);
    return value;
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Material  * * * * * * * * * * * * * * * * //

Feed::Material::Material(const word& name, const dictionary& dict)
:
    name(name),
    density(readAtLeast(dict, "density", elutria::laws::leastDensity)),
    sphericity(dict.getOrDefault<scalar>("sphericity", 1)),
    massFraction(readAtLeast(dict, "massFraction", 0)),
    numberFraction(0),
    focus(0),
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

    massFlow_ =
        found("massFlowRate")
      ? readPositive(*this, "massFlowRate")
      : readPositive(*this, "loading")*gasMassFlow(phaseName);

    if (!(massFlow_ > 0))
    {
        FatalIOErrorInFunction(*this)
            << "loading gives a feed of " << massFlow_ << " kg/s: no gas flows"
            << " in; allowed: an inflow, or massFlowRate"
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
    asked_ = maxParticles_;

    sampling_ = readSampling();
    rate_ = massFlow_/meanMass();
    if (weighted() && found("duration") && found("particles"))
    {
        addParcels(phaseName);
        rate_ = maxParticles_/duration_;
    }

    seed_ = scrambled(uint64_t(seedEntry()) + 0x9e3779b97f4a7c15ULL);
}


void Feed::addParcels(const word& phaseName)
{
    if (!found("particlesPerParcel"))
    {
        return;
    }
    const scalar most = readPositive(*this, "particlesPerParcel");
    if (!isDilute(phaseName))
    {
        const scalar fed =
            elutria::laws::parcelsFed(asked_, rate_*duration_, most);
        maxParticles_ = label(min(fed, scalar(labelMax)));
    }
}


bool Feed::isDilute(const word& phaseName) const
{
    return
        massFlow_
      < elutria::laws::largestDiluteLoading*gasMassFlow(phaseName);
}


Feed::Sampling Feed::readSampling() const
{
    const word parcels(getOrDefault<word>("parcels", "particles"));
    if (parcels == "evenMass")
    {
        return Sampling::evenMass;
    }
    if (parcels == "evenSizes")
    {
        return Sampling::evenSizes;
    }
    if (parcels != "particles")
    {
        FatalIOErrorInFunction(*this)
            << "parcels is " << parcels
            << ", allowed: particles, evenMass, evenSizes"
            << exit(FatalIOError);
    }
    return Sampling::particles;
}


word Feed::place() const
{
    return found("patch") ? get<word>("patch") : get<word>("zone");
}


label Feed::seedEntry() const
{
    return getOrDefault<label>("seed", 1);
}


scalar Feed::massFactor(const scalar time) const
{
    if (steering_.empty())
    {
        return 1;
    }
    const Steering::Change now = steering_.at(time);
    return now.loading*(found("loading") ? now.gas : 1);
}


scalar Feed::entryTime(const label i) const
{
    return start_ + (i + random(i, 2))/rate_;
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
        return weighted() ? material.massFraction : material.numberFraction;
    };
    while (m < materials_.size() - 1 && u >= share(materials_[m]))
    {
        u -= share(materials_[m]);
        ++m;
    }
    return m;
}


scalar Feed::place(const label i, const label material) const
{
    // Van der Corput's sequence: the digits of i in base 2, mirrored
    uint32_t mirrored = 0;
    for (int bit = 0; bit < 32; ++bit)
    {
        mirrored = (mirrored << 1) | ((uint32_t(i) >> bit) & 1);
    }
    const scalar u = mirrored*0x1.0p-32 + random(material, 7);
    return u - std::floor(u);
}


scalar Feed::diameter(const label i, const label material) const
{
    const SizeDistribution& sizes = materials_[material].sizes;
    const scalar u = place(i, material);
    switch (sampling_)
    {
        case Sampling::evenMass:
            return sizes.quantileByMass(u);
        case Sampling::evenSizes:
            return sizes.quantileBySize(u);
        default:
            return sizes.quantileByNumber(u);
    }
}


point Feed::place
(
    const label i,
    const scalar diameter,
    const bool retreat
) const
{
    return entrance_.place
    (
        {random(i, 3), random(i, 4), random(i, 5), random(i, 6)},
        0.5*diameter,
        retreat
    );
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
    entrance_(mesh, *this),
    start_(0),
    duration_(0),
    drainTime_(GREAT),
    maxParticles_(labelMax),
    asked_(labelMax),
    seed_(0),
    sampling_(Sampling::particles),
    massFlow_(0),
    rate_(0),
    steering_(mesh.time())
{
    readMaterials();
    readOutlets();
    velocity_ = getOrDefault<vector>("velocity", Zero);
    readSchedule(phaseName);
    readFocus(phaseName);
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


const Feed& Feed::require
(
    const fvMesh& mesh,
    const word& phaseName,
    const char* const model
)
{
    const Feed* feed = find(mesh, phaseName);
    if (!feed)
    {
        FatalErrorInFunction
            << (mesh.time().constant()/"feed").c_str()
            << ": file not found; " << model
            << " of the cloud's properties needs it" << exit(FatalError);
    }
    return *feed;
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


scalar Feed::number(const label i) const
{
    if (!weighted())
    {
        return 1;
    }
    scalar massOverMean = 1;
    if (sampling_ == Sampling::evenSizes)
    {
        const label m = material(i);
        massOverMean = materials_[m].sizes.massOverEven(place(i, m));
    }
    return
        massFactor(entryTime(i))*massOverMean*massFlow_/(rate_*mass(i));
}


scalar Feed::meanMass() const
{
    scalar mean = 0;
    for (const Material& m : materials_)
    {
        mean += m.numberFraction*m.meanMass();
    }
    return mean;
}


scalar Feed::heaviestParcel() const
{
    scalar heaviest = 0;
    for (label i = 0; i < 1000; ++i)
    {
        heaviest = max(heaviest, number(i)*mass(i));
    }
    return heaviest;
}


Feed::Particle Feed::particle(const label i) const
{
    Particle p;
    p.time = entryTime(i);
    p.material = material(i);
    p.diameter = diameter(i, p.material);
    p.number = number(i);

    p.position = place(i, p.diameter, false);
    return p;
}


point Feed::retreat(const label i) const
{
    return place(i, diameter(i, material(i)), true);
}


} // End namespace Foam

#pragma once

#include "core/PeriodicBox.hpp"
#include "impacts/FirstContact.hpp"
#include "impacts/ParticleState.hpp"
#include "laws/Coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

// Impacts of spheres that stand for several particles each, or for a share of one.
//
// Sphere i must hit the n_j particles of sphere j as often as those would be hit. So a pair has
// f = max(n_i, n_j) times the spheres' own cross-section s, and an impact changes i with the
// chance n_j/f and j with n_i/f (Schmidt & Rutland 2000, J. Comput. Phys. 164, 62: collisions of
// parcels of unequal numbers). Frequencies, and the mean exchange of momentum between any two kinds,
// are those of the particles; a single event need not conserve it.
//
// Where in its cross-section a pair meets says nothing of the particles, so it meets by chance: while
// the two pass each other closer than R, at the rate f s |v|/(4/3 pi R^3), touching at any place
// alike. Chance does not remember, and leaves the places of spheres uncorrelated: if they were turned
// back at R they would crowd each other out, and meet too often. R is the sum of their reaches; the
// larger it is, the fewer impacts fall on one passage, where they find a pair already slowed, and
// the less local they are.
//
// Such spheres leave each other all the room there is. Particles do not, and so meet oftener
// (Enskog): the rate grows by their pair correlation at contact.

namespace elutria::dem
{

/// Pair correlation at contact, that is collisions over those of a dilute gas, of equal spheres at
/// a volume fraction of solids (Carnahan & Starling 1969, doi 10.1063/1.1672048, up to one half).
inline double contactCorrelation(double solidFraction)
{
    const double solids = std::clamp(solidFraction, 0.0, 0.5), room = 1 - solids;
    return (1 - 0.5*solids)/(room*room*room);
}

inline bool isWeighted(const ParticleState& a, const ParticleState& b)
{
    return a.weight != 1 || b.weight != 1;
}

/// By how much a pair's cross-section is larger than its spheres', in a dilute cloud.
inline double crossSectionFactor(const ParticleState& a, const ParticleState& b)
{
    return std::max(a.weight, b.weight);
}

/// A sphere's reach in a cloud with weights, m: half an impact a passage of two equal spheres.
/// One of few, hit several times a passage by those of many, takes a little less from them; if it
/// reached further it would meet across the layers of a dense feed.
inline double collisionReach(double radius, double weight)
{
    constexpr double least = 2, most = 128;      // of the weight: 2 to 16 radii
    return radius*std::sqrt(2*std::clamp(weight, least, most));
}

/// Another number for every number, with no pattern left (the mixing of MurmurHash3).
inline std::uint64_t scrambled(std::uint64_t z)
{
    z = (z ^ (z >> 33))*0xff51afd7ed558ccdULL;
    z = (z ^ (z >> 33))*0xc4ceb9fe1a85ec53ULL;
    return z ^ (z >> 33);
}

/// Reproducible numbers in [0, 1) for a pair on certain segments of its paths. They depend on the piece
/// of a step (`seed`), and on no value that rounding could change.
class RandomStream
{
public:
    RandomStream(std::uint64_t seed, const ParticleState& a, std::size_t segmentA, const ParticleState& b,
                   std::size_t segmentB)
        : state_(seed)
    {
        if (a.id > b.id) add(b.id), add(a.id), add(segmentB), add(segmentA);
        else add(a.id), add(b.id), add(segmentA), add(segmentB);
    }

    double next()
    {
        state_ += 0x9e3779b97f4a7c15ULL;       // SplitMix64, Steele, Lea & Flood 2014
        return double(scrambled(state_) >> 11)*0x1.0p-53;
    }

private:
    void add(std::uint64_t key) { state_ = scrambled(state_ + key); }

    std::uint64_t state_;
};

/// Relative course of a pair from a time to another, along its chord.
struct Passage
{
    double from, end;          // s
    Vector3 start, way;        // m, of a from b

    /// From the places of both at either time.
    Passage(double from, double end, const Vector3& startA, const Vector3& endA,
            const Vector3& startB, const Vector3& endB, const PeriodicBox& box)
        : from(from), end(end), start(box.shortest(startA - startB)),
          way(endA - endB - (startA - startB))
    {}
};

/// When a pair with a weight meets by chance, the first of its stream; never if not.
inline double stochasticCollision(const ParticleState& a, const ParticleState& b, const Passage& passage,
                              RandomStream stream)
{
    const double distance = a.reach + b.reach, length2 = squaredNorm(passage.way);
    const double approach = -dot(passage.start, passage.way);
    const double outside = squaredNorm(passage.start) - distance*distance;
    if (!(length2 > 0) || (outside > 0 && approach < 0)) return never;
    const double root2 = approach*approach - outside*length2;
    if (!(root2 > 0)) return never;
    const double root = std::sqrt(root2);
    const double enters = std::max((approach - root)/length2, 0.0);      // parts of the way
    const double leaves = std::min((approach + root)/length2, 1.0);
    if (!(leaves > enters)) return never;

    const double sum = a.radius + b.radius;
    const double meanWay = 4*distance*distance*distance
        /(3*sum*sum*crossSectionFactor(a, b)*0.5*(a.enskogFactor + b.enskogFactor));
    const double chance = stream.next(), length = std::sqrt(length2);
    if (chance*meanWay > (leaves - enters)*length) return never;     // less than the way below
    const double meets = enters - meanWay*std::log1p(-chance)/length;
    return meets < leaves ? passage.from + meets*(passage.end - passage.from) : never;
}

/// Unit vector from b to a where they touch, for a place of touching as likely as any other.
inline Vector3 randomNormal(const Vector3& velocityOfAFromB, RandomStream& stream)
{
    const Vector3 along = velocityOfAFromB*(1/norm(velocityOfAFromB));
    const Vector3 any = std::abs(along.x) < 0.7 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    const Vector3 across = cross(along, any)*(1/norm(cross(along, any)));
    const double sine2 = stream.next(), turn = 2*laws::pi*stream.next();
    const Vector3 aside = std::cos(turn)*across + std::sin(turn)*cross(along, across);
    return std::sqrt(sine2)*aside - std::sqrt(1 - sine2)*along;
}

} // namespace elutria::dem

#pragma once

#include "core/PeriodicBox.hpp"
#include "impacts/FirstContact.hpp"
#include "impacts/ParticleState.hpp"
#include "laws/Coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

// Stochastic collisions of spheres whose statistical weight is not one.
//
// Sphere i must be hit as often as the n_j particles of sphere j would hit it. So a pair has
// f = max(n_i, n_j) times the spheres' own cross-section s, and a collision changes i with the
// probability n_j/f and j with n_i/f (Schmidt & Rutland 2000, J. Comput. Phys. 164, 62: collisions
// of parcels of unequal weights). Rates, and the mean exchange of momentum between any two kinds of
// particles, are those of the particles; a single collision need not conserve momentum.
//
// Where in its cross-section a pair collides says nothing of the particles, so it is drawn at random:
// while the two pass each other closer than R, collisions occur at the rate f s |v|/(4/3 pi R^3),
// with every place of contact equally likely. A random draw has no memory, and leaves the positions
// of spheres uncorrelated: if spheres were turned back at R they would exclude volume, and collide
// too often. R is the sum of their ranges. The larger it is, the fewer collisions fall into one
// passage, where they find a pair that is already slowed, and the less local they are.
//
// Weighted spheres may overlap and exclude no volume. Real particles at the same solid fraction
// collide g0 times as often (Enskog); the collision rate is multiplied by g0, the radial
// distribution function at contact.

namespace elutria::dem
{

/// Enskog factor g0: radial distribution function at contact of equal spheres at a volume fraction of
/// solids, that is their collision rate over that of a dilute gas (Carnahan & Starling 1969, doi 10.1063/1.1672048, up to one half).
inline double contactCorrelation(double solidFraction)
{
    const double solids = std::clamp(solidFraction, 0.0, 0.5), room = 1 - solids;
    return (1 - 0.5*solids)/(room*room*room);
}

inline bool isWeighted(const ParticleState& a, const ParticleState& b)
{
    return a.weight != 1 || b.weight != 1;
}

/// Cross-section of a pair over that of its spheres, in a dilute cloud.
inline double crossSectionFactor(const ParticleState& a, const ParticleState& b)
{
    return std::max(a.weight, b.weight);
}

/// Range of a sphere's stochastic collisions, m: two equal spheres collide in half of their passages.
/// A sphere of small weight collides several times in a passage of one of large weight, and takes a
/// little less momentum from it; a larger range would let it collide across the layers of a dense
/// feed.
inline double collisionReach(double radius, double weight)
{
    constexpr double least = 2, most = 128;      // of the weight: 2 to 16 radii
    return radius*std::sqrt(2*std::clamp(weight, least, most));
}

/// Mixes the bits of a number, one to one (the finalizer of MurmurHash3).
inline std::uint64_t scrambled(std::uint64_t z)
{
    z = (z ^ (z >> 33))*0xff51afd7ed558ccdULL;
    z = (z ^ (z >> 33))*0xc4ceb9fe1a85ec53ULL;
    return z ^ (z >> 33);
}

/// Random stream in [0, 1) of a pair on two segments of its paths. It depends on the seed (of the
/// piece), the ids and the segments, and on no value that rounding could change.
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

/// Time of a stochastic collision of a pair, from the first number of its stream; never if none.
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

/// Unit normal from b to a of a collision, every place of the cross-section equally likely.
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

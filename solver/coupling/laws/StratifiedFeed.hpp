// Which material, size and mass each parcel of a feed has, so that what is fed is what was asked.
//
// Parcels are drawn in blocks. A block has so many parcels of each size class of each material as
// its share among the parcels asks for, at least one where there is any mass; those of a class share
// its sizes in equal strata, one each. A parcel has the mass of its stratum, and a size drawn from
// the mass within it. So every block, and the feed, has the asked mass of each material and of each
// class, to round-off, at any seed. In order of time the strata of a block follow van der Corput's
// sequence: any stretch of the feed has nearly the composition of the whole.
//
// Where every parcel is one particle, its size gives its mass: strata are those of the number of
// particles, and how many of them are a material's is made up for in the blocks after. A sum over
// strata of a rising function, here the mass of a size, is off by less than one largest particle.
// The last block moves its sizes within their strata until the mass of the feed is met; a surplus of
// part of a large particle, fed before, may be more than that can take back.
//
// Where a material's density scatters, the densities of a block follow van der Corput's sequence in
// base 3 along its sizes: any range of sizes has nearly the stated curve of densities. Masses stay
// exact, since a parcel's is that of its stratum; a lighter parcel is more particles.
//
// A parcel is a function of the seed, its number and the feed's composition. Where the feed ends is
// part of that for the last block only. A feed that goes on after its end keeps that end among its
// own: up to each of them the masses are exact, and what was fed stays what it was.
#pragma once

#include "DensityScatter.hpp"
#include "SizeCurves.hpp"

#include <cstdint>
#include <vector>

namespace elutria::laws
{

/// What decides the share of a size among the parcels: its number of particles, its mass, or its
/// length on a log axis.
enum class Sampling { particles, evenMass, evenSizes };

struct Ingredient
{
    double massFraction;        // of the feed
    double density;             // kg/m3, the mean over the numbers where it scatters
    const SizeCurves* sizes;    // outlives the feed
    const DensityScatter* scatter = nullptr;    // likewise; null: all grains have the density

    double meanMass() const;    // of a particle, by number, kg
};

struct FedParcel
{
    int material;
    double diameter;    // m
    double mass;        // kg, of all its particles
    double density;     // kg/m3
};

class StratifiedFeed
{
public:
    /// massOfParcel: mean, kg; ends: mass of the feed up to each of its ends over that, rising. The
    /// nearest whole number of parcels has that mass, at least one.
    StratifiedFeed(std::vector<Ingredient>, Sampling, std::uint64_t seed, double massOfParcel,
                   const std::vector<double>& ends);

    /// Parcel i of those of the feed.
    FedParcel operator[](std::size_t i) const;

    std::size_t parcels() const { return blocks_.back().end; }

    /// First parcel of those that depend on where the feed ends.
    std::size_t lastBlock() const { return blocks_.size() > 1 ? blocks_[blocks_.size() - 2].end : 0; }

private:
    /// An interval of a material's curve of mass, or of number where parcels are particles
    struct Stratum
    {
        int material;
        double low, high;       // cumulative shares
        double mass;            // kg
        double density;         // kg/m3
    };
    typedef std::vector<Stratum> Strata;

    /// A class of a material, or all of its sizes: its sampling curve from low to high
    struct Cell
    {
        int material;
        double low, high;
        double parcels;         // share of all parcels
    };

    /// Parcels up to an end, and whether the mass of all up to there is to be met, kg
    struct Block
    {
        std::size_t end;
        bool last;
        double mass;
    };

    void addBlocks(double end);

    std::vector<Cell> cells(bool byClass) const;
    std::vector<std::size_t> counts(const std::vector<Cell>&, std::size_t n) const;
    Strata weightedStrata(std::size_t n, double mass) const;
    Strata particleStrata(std::size_t first, std::size_t n) const;

    void drawBlock() const;
    void scatterDensities(std::size_t block, Strata&) const;
    double diameter(const Stratum&, double at) const;
    double particleMass(const Stratum&, double at) const;

    /// Moves places within the strata of each material until the feed so far has its mass, kg.
    void meetMass(double mass, const Strata&, std::vector<double>& at) const;

    const std::vector<Ingredient> materials_;
    const Sampling sampling_;
    const std::uint64_t seed_;
    const double massOfParcel_;
    double numberOverMass_;     // particles per kg of the feed
    std::vector<Block> blocks_;

    // Drawn so far, block by block, and of each material in them
    mutable std::vector<FedParcel> drawn_;
    mutable std::size_t blocksDrawn_;
    mutable std::vector<double> drawnNumber_, drawnMass_;
};

} // namespace elutria::laws

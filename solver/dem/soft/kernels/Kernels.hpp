#pragma once

#include "laws/LawList.hpp"

#include <cstddef>
#include <cstdint>

// The two inner loops of the soft integrator, compiled once per instruction set and chosen when
// the program starts. Layout: what a pair needs of a particle is one cache line; differences of
// positions are taken in double precision, what follows from them is computed in single precision
// (rounding 6e-8 of the force, equal and opposite for both partners), sums are double again.

namespace elutria::dem
{

/// What contacts read of a particle.
struct alignas(64) Row
{
    double x, y, z, radius;
    float vx, vy, vz, inverseMass;          // velocity predicted, relative to the common motion
    float sx, sy, sz, inverseRadius;        // radius times spin, predicted
};

/// State between evaluations: velocities without the step's own contact part.
struct alignas(64) Base
{
    double vx, vy, vz, inverseMass;
    double sx, sy, sz, radius;
};

/// Sums over the contacts of a particle: force, N, and torque over radius, N.
struct alignas(64) Load
{
    double fx, fy, fz, unused1;
    double mx, my, mz, unused2;
};

/// Zeros for the particles of a chunk whose loads do not hold sums yet: where nothing touches, loads
/// are neither written nor read.
ELUTRIA_INLINE void startSums(Load* loads, std::size_t begin, std::size_t end, bool& loaded)
{
    if (loaded) return;
    for (std::size_t i = begin; i < end; ++i) loads[i] = {};
    loaded = true;
}

/// Linear forcing by the gas, prepared for one step length.
struct alignas(64) Forcing
{
    double ax, ay, az;                      // acceleration + dragRate*gasVelocity
    double decay, first, second;            // exp(-k h), h phi1, h phi2
};

/// Force and torque of one contact, as the kernel leaves it.
struct alignas(32) Contribution
{
    float fx, fy, fz, unused1, mx, my, mz, unused2;
};

constexpr std::size_t contactBlock = 64;    // contacts worked on at a time

/// Contacts of one chunk of particles; arrays hold contactBlock entries beyond `count`.
struct ContactArrays
{
    std::size_t count;
    const std::uint32_t *first, *second;
    float *displacementX, *displacementY, *displacementZ;
    std::uint8_t* touching;
};

struct PairWork
{
    const Row* rows;
    ContactArrays contacts;
    std::size_t inside;                     // contacts before this one have both partners here
    std::size_t begin, end;                 // the chunk's particles
    Load* loads;
    bool loaded;                            // in, out: their loads hold sums; if not, what memory holds
    Contribution* across;                   // of the others, for the second partner
    bool acrossActs;                        // out: one of these is not zero
    double length[3], inverseLength[3];     // periodic box, 0 where not periodic
    double before, after;                   // s, half steps
    const laws::CoefficientsOf<float>* coefficients;   // of material pairs
    const std::uint8_t* material;           // null: one material
    std::size_t materials;
    /// Recomputes contact `k` in full, where it begins or ends; returns its contribution.
    Contribution (*transition)(void* self, std::size_t k);
    void* self;
    float largestOverlap;                   // out: overlap over twice the effective radius
};

struct MoveWork
{
    std::size_t begin, end;
    Row* rows;
    Base* bases;
    const Load* loads;                      // null: none
    const Forcing* forcing;                 // null: no drag, `push` for all
    double push[3], step;
    double frame[3];                        // common motion, taken off in the rows, m/s
    double ownFrame[3];                     // of these particles, m/s
    double fastest, fastestInFrame;         // out: bounds of squared speeds; the latter in ownFrame
    double sum[3];                          // out: of velocities
};

struct Kernels
{
    const char* name;
    void (*pairs[ContactLaws::size])(PairWork&);   // by place in the list of laws
    void (*move)(MoveWork&);
};

/// The best this processor can run; ELUTRIA_SIMD=baseline|avx2|avx512 in the environment lowers it.
const Kernels& kernels();

extern const Kernels baselineKernels;
#if defined(__x86_64__)
extern const Kernels avx2Kernels, avx512Kernels;
#endif

} // namespace elutria::dem

// Size laws: the cumulative share Q(d) finer than d, as a material of the feed states it.
//
//   RosinRammler  d63 n                    Q = 1 - exp(-(d/d63)^n), ISO 9276-3
//   logNormal     d50 sigma                Q = Phi(ln(d/d50)/ln(sigma)), ISO 9276-5
//   normal        mean standardDeviation   Q = Phi((d - mean)/standardDeviation)
//   GatesGaudinSchuhmann  d100 m           Q = (d/d100)^m, Schuhmann 1940
//   uniform                                Q ~ d
//
// each truncated to [min, max] and scaled to end at 1. Besides: a single size, and the table of a
// sieve analysis, linear between its sieves; SizeTables.hpp reads one, and adds several curves up. Sizes are diameters in m.
//
// A curve's classes are those of ISO 3's series R20, in which partition tables are told, and of the
// sieve analysis itself: shares at their limits are exact.
//
// To add a law: a row in SizeLaws.cpp.
#pragma once

#include <string>
#include <vector>

namespace elutria::laws
{

/// Cumulative shares on a grid of diameters, between which they are linear.
struct CumulativeCurve
{
    std::vector<double> diameter;    // m, rising
    std::vector<double> finer;       // 0 to 1
    std::vector<double> limit;       // those of the diameters at which classes meet, m
};

struct SizeLaw
{
    const char* name;
    std::vector<const char*> parameters;       // in the order of finer()
    double (*finer)(double diameter, const double* parameters);    // not yet truncated
};

/// A larger one is a mistake, m.
constexpr double largestSize = 1;

const std::vector<SizeLaw>& sizeLaws();

/// Null: not known.
const SizeLaw* findSizeLaw(const std::string& name);

/// The part of a law between two sizes, on equal steps of log size. Throws std::invalid_argument
/// that says what is allowed where a parameter is not, a size is above `most`, or nothing of the law
/// lies between.
CumulativeCurve truncated(const SizeLaw&, const double* parameters, double min, double max,
                          double most = largestSize);

/// Throws std::invalid_argument unless diameters and shares are lists of one length, rising, the
/// shares from 0 to 1, and no diameter is above `most`. `named`: what the message calls the
/// diameters.
CumulativeCurve sieved(const std::vector<double>& diameters, const std::vector<double>& finer,
                       const char* named = "diameters", double most = largestSize);

/// A single size.
CumulativeCurve single(double diameter);

} // namespace elutria::laws

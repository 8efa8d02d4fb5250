// Sizes as plants have them: the table of a sieve analysis as text, and feeds that are several at once.
#pragma once

#include "SizeLaws.hpp"

namespace elutria::laws
{

/// The curve of a sieve analysis, linear between its sieves. The text is a csv with a header of two
/// columns in either order, its rows in any order:
///
///     diameter_m, diameter_mm or diameter_um      apertures; 0 is the pan
///     cumulative or cumulative_percent            share finer than the aperture, or
///     retained or retained_UNIT                   what lies on the sieve, in any unit of mass or share
///
/// What passed the finest sieve lies between `min` (m) and it; min 0: nothing may have passed. Throws
/// std::invalid_argument that says what is allowed.
CumulativeCurve sieveTable(const std::string& csv, double min);

/// Several curves at once, each with its share; the shares are scaled to add up to 1. Throws
/// std::invalid_argument for a share that is not above 0.
CumulativeCurve mixed(const std::vector<CumulativeCurve>&, const std::vector<double>& shares);

} // namespace elutria::laws

#pragma once

#include <doctest/doctest.h>

namespace elutria::dem
{

/// doctest's Approx adds 1 to the numbers before it compares: small ones are always near. This one
/// is relative, to the given share of the larger.
inline doctest::Approx near(double value, double share)
{
    return doctest::Approx(value).scale(0).epsilon(share);
}

} // namespace elutria::dem

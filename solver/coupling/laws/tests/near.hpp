#pragma once

#include <doctest/doctest.h>

/// Within a share of the number. doctest's own Approx adds 1 to the numbers before it compares.
inline doctest::Approx near(double value, double share)
{
    return doctest::Approx(value).scale(0).epsilon(share);
}

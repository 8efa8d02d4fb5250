#pragma once

#include <cstdio>
#include <stdexcept>
#include <string>

namespace elutria::dem
{

/// A number as messages show it: six significant digits, of small ones too.
inline std::string text(double value)
{
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.6g", value);
    return digits;
}

/// Throws std::invalid_argument in one line: what it is, its value, what is allowed.
inline void require(bool allowed, const std::string& what, double value, const std::string& range)
{
    if (!allowed)
        throw std::invalid_argument(what + " is " + text(value) + "; allowed: " + range);
}

} // namespace elutria::dem

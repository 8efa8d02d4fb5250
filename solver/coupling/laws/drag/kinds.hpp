// What drag laws of a kind say of themselves.
#pragma once

namespace elutria::laws
{

/// Laws of single grains were made without neighbours, and know none.
struct OfGrains
{
    static constexpr double minAlpha = 0.9;
    static constexpr bool knowsVoid = false, knowsShape = false, knowsMean = false;
};

/// And those that know their shape.
struct OfShapes : OfGrains
{
    static constexpr bool knowsShape = true;
};

/// Each law of suspensions has its own range of void fractions.
struct OfSuspensions
{
    static constexpr bool knowsVoid = true, knowsShape = false, knowsMean = false;
};

} // namespace elutria::laws

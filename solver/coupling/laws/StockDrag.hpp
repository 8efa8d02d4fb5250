// What OpenFOAM's own drag forces are: the law among ours, and what they take of a grain's shape.
#pragma once

#include <string>
#include <vector>

namespace elutria::laws
{

/// A drag force of OpenFOAM's own.
struct StockDrag
{
    enum class Shape
    {
        sphere,
        ownSphericity   // its entry phi, of all particles
    };

    const char* name;
    const char* law;    // the same law among ours; empty: none
    Shape takes;
};

const std::vector<StockDrag>& stockDrags();

/// By the name of the particle force; null: not OpenFOAM's.
const StockDrag* findStockDrag(const std::string& name);

} // namespace elutria::laws

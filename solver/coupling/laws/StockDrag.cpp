#include "StockDrag.hpp"
#include "DragLaws.hpp"

namespace elutria::laws
{

const std::vector<StockDrag>& stockDrags()
{
    using Shape = StockDrag::Shape;
    static const std::vector<StockDrag> all{
        {"sphereDrag", Putnam::name, Shape::sphere},
        {"distortedSphereDrag", "", Shape::sphere},
        {"nonSphereDrag", HaiderLevenspiel::name, Shape::ownSphericity},
        {"WenYuDrag", WenYu::name, Shape::sphere},
        {"ErgunWenYuDrag", Gidaspow::name, Shape::sphere},
        {"PlessisMasliyahDrag", "", Shape::sphere},
    };
    return all;
}


const StockDrag* findStockDrag(const std::string& name)
{
    for (const StockDrag& drag : stockDrags())
        if (name == drag.name) return &drag;
    return nullptr;
}

} // namespace elutria::laws

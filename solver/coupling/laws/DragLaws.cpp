#include "DragLaws.hpp"
#include "StockDrag.hpp"

namespace elutria::laws
{

namespace
{

template<class Law>
DragLaw described()
{
    return {Law::name,      Law::title,      Law::maxRe,     Law::minAlpha,
            Law::knowsVoid, Law::knowsShape, Law::knowsMean, Law::CdRe};
}

} // namespace


const std::vector<DragLaw>& dragLaws()
{
#define ELUTRIA_DESCRIBE(Law) described<Law>(),
    static const std::vector<DragLaw> all{
        ELUTRIA_FOR_EACH_DRAG_LAW(ELUTRIA_DESCRIBE) described<Putnam>()};
#undef ELUTRIA_DESCRIBE
    return all;
}


const DragLaw* findDragLaw(const std::string& name)
{
    const StockDrag* stock = findStockDrag(name);
    const std::string own = stock ? stock->law : name;
    for (const DragLaw& law : dragLaws())
        if (own == law.name || own == law.title) return &law;
    return nullptr;
}

} // namespace elutria::laws

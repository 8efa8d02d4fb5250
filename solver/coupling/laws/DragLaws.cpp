#include "DragLaws.hpp"

#include <map>

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

/// OpenFOAM's particle forces that are one of these laws under another name
const std::map<std::string, std::string> stockNames{
    {"nonSphereDrag", HaiderLevenspiel::name},
    {"WenYuDrag", WenYu::name},
    {"ErgunWenYuDrag", Gidaspow::name},
};

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
    const auto stock = stockNames.find(name);
    const std::string& own = stock == stockNames.end() ? name : stock->second;
    for (const DragLaw& law : dragLaws())
        if (own == law.name || own == law.title) return &law;
    return nullptr;
}

} // namespace elutria::laws

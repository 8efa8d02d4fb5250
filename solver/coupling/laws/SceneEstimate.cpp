#include "SceneEstimate.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <limits>

namespace elutria::laws
{

SceneEstimate estimate(const Solids& solids, const GasStream& gas, double gravity)
{
    SceneEstimate e{};
    const double stay = gas.throughTime;
    e.loading = solids.massFlow*stay/(gas.density*gas.volume);
    e.inside = solids.massFlow*stay;
    e.gasChange = e.inside*gravity*stay/(gas.density*gas.speed*gas.volume);

    double crossSection = 0;
    for (const FedMaterial& m : solids.materials)
    {
        crossSection += m.numberFraction*pi*(m.medianSize*m.medianSize);
        e.solidFraction += m.massFraction*e.inside/m.density/gas.volume;
    }
    e.collisions = e.inside/solids.meanMass/gas.volume*crossSection*0.5*gas.speed*stay;
    return e;
}


double collisionStep(const SceneEstimate& e, const GasStream& gas, double collisionsPerStep)
{
    constexpr double least = std::numeric_limits<double>::min();
    return gas.throughTime*collisionsPerStep/std::max(e.collisions, least);
}

} // namespace elutria::laws

// What a feed and a gas stream lead one to expect: orders of magnitude, from closed forms. The
// solver plans with them, and tells them before a run. SI units.
//
// A particle is taken to stay as long as the gas, and to meet others at half the gas' speed.
#pragma once

#include <vector>

namespace elutria::laws
{

struct GasStream
{
    double density;        // kg/m3
    double speed;          // m/s, mean
    double volume;         // m3, of the column
    double throughTime;    // s, volume over inflow
};

struct FedMaterial
{
    double density;           // kg/m3
    double massFraction;
    double numberFraction;    // of the particle numbers
    double medianSize;        // m, by number
};

struct Solids
{
    double massFlow;    // kg/s
    double meanMass;    // kg, of a particle, by number
    std::vector<FedMaterial> materials;
};

struct SceneEstimate
{
    double loading;           // kg solids per kg gas
    double inside;            // kg of solids in the column
    double solidFraction;     // of the column's volume
    double collisions;        // of a particle before it leaves
    double gasChange;         // of the gas velocity by the particles' weight, relative
};

SceneEstimate estimate(const Solids&, const GasStream&, double gravity);

/// Time step in which a particle collides `collisionsPerStep` times, s.
double collisionStep(const SceneEstimate&, const GasStream&, double collisionsPerStep);

} // namespace elutria::laws

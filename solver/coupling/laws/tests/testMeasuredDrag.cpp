// Drag from measured terminal velocities, against the measurements.
#include "MeasuredDrag.hpp"

#include "Settling.hpp"
#include "near.hpp"

#include <stdexcept>

using namespace elutria::laws;

namespace
{

// Gunn and Kinzer 1949: drops of water in air
constexpr Gas air{1.204, 1.818e-5};
const char* const drops = "diameter_mm,velocity_m_s\n0.8,3.27\n0.2,0.72\n0.4,1.62\n\n0.6,2.47\n1,4.03\n";

double falls(const MeasuredDrag& measured, double diameter, double density = 998)
{
    Grain grain{density, {}};
    grain.form.measured = &measured;
    return terminalVelocity(MeasuredVelocity::CdRe, grain, diameter, air, 9.81);
}

std::string refusal(const std::string& csv)
{
    try
    {
        MeasuredDrag(velocityTable(csv), 998, air.density, air.viscosity);
    }
    catch (const std::invalid_argument& refused)
    {
        return refused.what();
    }
    return "";
}

} // namespace

TEST_SUITE("measured drag")
{

TEST_CASE("a grain falls as it was measured, and between as what was left out")
{
    const MeasuredDrag measured(velocityTable(drops), 998, air.density, air.viscosity);
    const struct { double diameter, velocity; } told[]{
        {0.2e-3, 0.72}, {0.4e-3, 1.62}, {0.6e-3, 2.47}, {0.8e-3, 3.27}, {1e-3, 4.03}};
    for (const auto& drop : told) CHECK(falls(measured, drop.diameter) == near(drop.velocity, 1e-9));

    // 1.5 %: the measurement is good to 1 %, this one and those beside it
    const struct { double diameter, velocity; } others[]{
        {0.3e-3, 1.17}, {0.5e-3, 2.06}, {0.7e-3, 2.87}, {0.9e-3, 3.67}};
    for (const auto& drop : others) CHECK(falls(measured, drop.diameter) == near(drop.velocity, 0.015));
}

TEST_CASE("beyond the measured sizes grains keep their drag over a sphere's")
{
    // spheres' speeds, but grains twice as heavy in the gas: everywhere twice a sphere's drag
    const double size[]{1e-3, 2e-3};
    std::vector<TerminalVelocity> table;
    for (const double d : size)
        table.push_back({d, terminalVelocity(SchillerNaumann::CdRe, {1500, {}}, d, air, 9.81)});
    const MeasuredDrag measured(table, 2*1500 - air.density, air.density, air.viscosity);
    for (const double Re : {1.0, 100.0, 900.0})
        CHECK(measured.CdRe(Re)/SchillerNaumann::CdRe(Re, 1, {}) == near(2, 1e-9));
}

TEST_CASE("a table that cannot be says why")
{
    CHECK(refusal("d,v\n1,2\n") == "the first line is 'd,v', allowed: one of diameter_m, diameter_mm,"
                                   " diameter_um");
    CHECK(refusal("diameter_mm,v\n1,2\n")
          == "the first line is 'diameter_mm,v', allowed: velocity_m_s, beside the sizes");
    CHECK(refusal("diameter_mm,velocity_m_s\n1,2\n")
          == "it has fewer than two sizes, allowed: at least two");
    CHECK(refusal("diameter_mm,velocity_m_s\n1,2\n2,fast\n")
          == "line 3 has 'fast', allowed: a number >= 0");
    CHECK(refusal("diameter_mm,velocity_m_s\n1,2\n2,1.5\n")
          == "velocity 1.5 m/s at 0.002 m, allowed: above 0, and rising with the size");
    CHECK(refusal("diameter_mm,velocity_m_s\n1,2\n1,3\n")
          == "diameter 0.001 m, allowed: sizes above 0, each once");
}

}

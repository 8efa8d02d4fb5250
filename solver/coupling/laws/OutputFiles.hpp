// What the files of a run hold, where others read them.
#pragma once

namespace elutria::laws
{

/// Columns of particles.csv and inside.csv.
constexpr const char* particleColumns =
    "time_s,outlet,material,id,diameter_m,density_kg_m3,n_particle,"
    "ux_m_s,uy_m_s,uz_m_s,residence_time_s";

} // namespace elutria::laws

// What the files of a run hold, where others read them.
#pragma once

namespace elutria::laws
{

/// Columns of particles.csv and inside.csv.
constexpr const char* particleColumns =
    "time_s,outlet,material,id,diameter_m,density_kg_m3,n_particle,"
    "ux_m_s,uy_m_s,uz_m_s,residence_time_s";

/// Columns of crossings.csv in postProcessing/crossings/TIME.
constexpr const char* crossingColumns =
    "time_s,plane,height_m,direction,material,id,diameter_m,n_particle";

/// Columns of gas.csv in postProcessing/gas/TIME.
constexpr const char* gasColumns =
    "time_s,patch,area_m2,volume_flow_m3_s,mass_flow_kg_s,velocity_m_s,pressure_pa,"
    "asked_volume_flow_m3_s";

/// Columns of ranks.csv in postProcessing.
constexpr const char* rankColumns =
    "rank,cells,particles,particle_steps,ghost_steps,shared_islands,exchanges,exchange_s,sent_bytes";

} // namespace elutria::laws

#pragma once

#include "core/PeriodicBox.hpp"
#include "laws/ContactLaw.hpp"
#include "laws/HertzMindlin.hpp"

namespace elutria::dem
{

enum class NeighbourSearch { automatic, bruteForce, cells, verlet, hierarchical };
enum class ContactTreatment { automatic, soft, impact };

struct Settings
{
    const ContactLaw* law = &contactLaw<HertzMindlin>;
    const ContactLaw* wallLaw = nullptr;    // of particles with walls; null: as between particles
    ContactTreatment treatment = ContactTreatment::automatic;
    NeighbourSearch search = NeighbourSearch::automatic;
    int cellLayers = 1;          // cells: layers looked through around a particle's own cell
    unsigned threads = 1;
    PeriodicBox box;

    double stepFraction = 0.02;  // sub-step over the shortest contact time
    double step = 0;             // s; > 0: asked sub-step instead (duration/ceil(duration/step))
    double skin = 0;             // m; 0: tuned while running
    double largestOverlap = 0.05;   // of the smaller radius: above it a warning is reported

    const ContactLaw& lawAtWalls() const { return wallLaw ? *wallLaw : *law; }
};

} // namespace elutria::dem

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    The plan as a file that programs read: postProcessing/plan.json.

\*---------------------------------------------------------------------------*/

#include "schedule/ScenePlan.H"
#include "run/exitHandling.H"
#include "foam/Json.H"
#include "foam/foamVersion.H"
#include "OSspecific.H"
#include "processorPolyPatch.H"

#include <fstream>

namespace Foam
{

namespace
{

std::string numbers(const UList<scalar>& values)
{
    std::vector<std::string> all;
    for (const scalar value : values)
    {
        all.push_back(json::number(value));
    }
    return json::list(all);
}


std::string words(const UList<word>& values)
{
    std::vector<std::string> all;
    for (const word& value : values)
    {
        all.push_back(json::text(value));
    }
    return json::list(all);
}


//- What is decided, and why
std::string decision(const PlanTable::Decision& made)
{
    return json::object
    ({
        {"what", json::text(made.first)},
        {"why", json::text(made.second)}
    });
}


//- Patches of each product
std::string outlets(const Feed& feed, const polyBoundaryMesh& patches)
{
    std::vector<std::string> all;
    forAll(feed.products(), product)
    {
        DynamicList<word> names;
        forAll(patches, patchi)
        {
            if (feed.productOfPatch(patchi) == product)
            {
                names.append(patches[patchi].name());
            }
        }
        all.push_back
        (
            json::object
            ({
                {"product", json::text(feed.products()[product])},
                {"patches", words(names)}
            })
        );
    }
    return json::list(all);
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

std::string ScenePlan::meshAsJson() const
{
    const fvMesh& mesh = gas_.U().mesh();
    const boundBox box(mesh.bounds());
    std::vector<std::string> patches;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (!isA<processorPolyPatch>(patch))
        {
            patches.push_back
            (
                json::object
                ({
                    {"name", json::text(patch.name())},
                    {"type", json::text(patch.type())}
                })
            );
        }
    }
    const scalarField& V = mesh.V().field();
    return json::object
    ({
        {"cells", json::number(returnReduce(mesh.nCells(), sumOp<label>()))},
        {"volume_m3", json::number(gSum(V))},
        {
            "size_m",
            numbers(scalarList({box.span().x(), box.span().y(), box.span().z()}))
        },
        {"smallest_cell_m", json::number(cbrt(gMin(V)))},
        {"largest_cell_m", json::number(cbrt(gMax(V)))},
        {"patches", json::list(patches)}
    });
}


std::string ScenePlan::inletsAsJson() const
{
    std::vector<std::string> inlets;
    for (const GasPhase::Opening& o : gas_.openings())
    {
        if (o.flow > 0)
        {
            inlets.push_back
            (
                json::object
                ({
                    {
                        "patch",
                        json::text(gas_.U().mesh().boundary()[o.patch].name())
                    },
                    {"volume_flow_m3_s", json::number(o.flow)},
                    {"velocity_m_s", json::number(o.flow/o.area)}
                })
            );
        }
    }
    return json::list(inlets);
}


std::string ScenePlan::gasAsJson(const ElutriaCloud& cloud) const
{
    static const char* const basis[] = {"inlet", "settled", "start"};
    const elutria::laws::Gas means(gas());
    const Feed* feed = cloud.feed();
    return json::object
    ({
        {"basis", json::text(basis[label(basis_)])},
        {"speed_m_s", json::number(feed ? stream(*feed).speed : gas_.meanSpeed())},
        {
            "superficial_m_s",
            feed && feed->gasMassFlow() > 0
          ? json::number(feed->superficialSpeed(gas_.name())) : "null"
        },
        {"inflow_is_fixed", gas_.inflowIsFixed() ? "true" : "false"},
        {"inlets", inletsAsJson()},
        {"density_kg_m3", json::number(means.density)},
        {"viscosity_pa_s", json::number(means.viscosity)},
        {"through_time_s", json::number(gas_.throughTime())},
        {"changes_at", json::number(tolerance_)},
        {"solved", decision(gasSolves())},
        {"by_itself", decision(gasByItself())}
    });
}


std::string ScenePlan::feedAsJson(const Feed& feed, const CaseDrag& drag) const
{
    const scalar speed = feed.superficialSpeed(gas_.name());
    std::vector<std::string> materials;
    for (const Feed::Material& m : feed.materials())
    {
        const auto axis = [&](const scalar value)
        {
            return m.form.hasAxes() ? json::number(value) : "null";
        };
        const scalar cut =
            drag.settlingSize(m, speed, gas(), mag(gas_.gravity()));
        materials.push_back
        (
            json::object
            ({
                {"name", json::text(m.name)},
                {"density_kg_m3", json::number(m.density)},
                {"least_density_kg_m3", json::number(m.leastDensity())},
                {"largest_density_kg_m3", json::number(m.largestDensity())},
                {"sphericity", json::number(m.form.sphericity)},
                {"flatness", axis(m.form.flatness)},
                {"elongation", axis(m.form.elongation)},
                {"mass_fraction", json::number(m.massFraction)},
                {"number_fraction", json::number(feed.numberFraction(m))},
                {"smallest_m", json::number(m.sizes.min())},
                {"largest_m", json::number(m.sizes.max())},
                {"d10_m", json::number(m.sizes.quantileByMass(0.1))},
                {"d50_m", json::number(m.sizes.quantileByMass(0.5))},
                {"d90_m", json::number(m.sizes.quantileByMass(0.9))},
                {"focus_m", m.focus > 0 ? json::number(m.focus) : "null"},
                {"cut_m", cut > 0 ? json::number(cut) : "null"}
            })
        );
    }
    // Not more than the duration has, which the rate must be known for
    const bool asked = feed.parcels() < labelMax;
    const label fed =
        feed.massFlow() > 0 ? feed.fedUntil(GREAT) : feed.parcels();
    const auto rated = [&](const scalar value)
    {
        return feed.massFlow() > 0 ? json::number(value) : "null";
    };
    return json::object
    ({
        {"through", json::text(feed.place())},
        {"outlets", outlets(feed, gas_.U().mesh().boundaryMesh())},
        {"rate_kg_s", rated(feed.massFlow())},
        {"peak_rate_kg_s", rated(feed.peakFlow())},
        {
            "rate_times",
            feed.table() ? json::number(feed.table()->times().size()) : "null"
        },
        {"particles_per_s", rated(feed.massFlow()/feed.meanMass())},
        {"particles_per_parcel", rated(feed.particlesPerParcel())},
        {"parcels", fed < labelMax - 1 ? json::number(fed) : "null"},
        {
            "parcels_asked",
            asked ? json::number(feed.parcels() - feed.added()) : "null"
        },
        {"start_s", json::number(feed.start())},
        {"end_s", json::number(feed.end())},
        {"run_ends_s", json::number(feed.drained())},
        {"seed", json::number(feed.seedEntry())},
        {"materials", json::list(materials)}
    });
}


std::string ScenePlan::expectedAsJson
(
    const Feed& feed,
    const CaseDrag& drag
) const
{
    const elutria::laws::GasStream gas(stream(feed));
    const elutria::laws::SceneEstimate e(expect(feed, gas));
    const auto relaxation = relaxationTimes(feed, drag, gas.speed);
    scalar fastest = 0;
    for (const Feed::Material& m : feed.materials())
    {
        fastest = max
        (
            fastest,
            drag.terminalVelocity
            (
                m, m.sizes.max(), this->gas(), mag(gas_.gravity())
            )
        );
    }

    // Nothing is known of a column through which no gas flows yet
    const bool flows = gas.throughTime < GREAT && feed.massFlow() > 0;
    const auto known = [=](const scalar value)
    {
        return flows ? json::number(value) : "null";
    };
    return json::object
    ({
        {"loading", known(e.loading)},
        {"inside_kg", known(e.inside)},
        {"particles_inside", known(e.inside/feed.meanMass())},
        {"solid_fraction", known(e.solidFraction)},
        {"collisions", known(e.collisions)},
        {"gas_change", known(e.gasChange)},
        {"shortest_relaxation_s", json::number(relaxation.first)},
        {"longest_relaxation_s", json::number(relaxation.second)},
        {"fastest_settling_m_s", json::number(fastest)}
    });
}


std::string ScenePlan::stepAsJson
(
    const ElutriaCloud& cloud,
    const Time& runTime
) const
{
    const dictionary& control = runTime.controlDict();
    const bool adjusts = control.getOrDefault("adjustTimeStep", false);
    return json::object
    ({
        {"first_s", json::number(runTime.deltaTValue())},
        {"adjusts", adjusts ? "true" : "false"},
        {
            "courant",
            json::number(gas_.courantRate()*runTime.deltaTValue())
        },
        {
            "largest_courant",
            adjusts
          ? json::number(control.getOrDefault<scalar>("maxCo", 1)) : "null"
        },
        {"largest_by_collisions_s", json::number(largestStep(cloud))}
    });
}


void ScenePlan::writePlan
(
    const PlanTable& table,
    const ElutriaCloud& cloud,
    const Time& runTime
) const
{
    std::vector<std::string> rows, warnings;
    for (const PlanTable::Row& row : table.rows())
    {
        rows.push_back
        (
            json::list
            ({
                json::text(row.what), json::text(row.decision),
                json::text(row.why)
            })
        );
    }
    for (const std::string& warning : table.warnings())
    {
        warnings.push_back(json::text(warning));
    }

    const CaseDrag drag(cloud.particleProperties());
    const Feed* feed = cloud.feed();
    const std::string plan = json::object
    ({
        {"time_s", json::number(runTime.value())},
        {"mesh", meshAsJson()},
        {"gas", gasAsJson(cloud)},
        {"gravity_m_s2", json::number(mag(gas_.gravity()))},
        {
            "drag",
            json::object
            ({
                {"forces", words(drag.forces())},
                {"law", json::text(drag.law().title)}
            })
        },
        {"feed", feed ? feedAsJson(*feed, drag) : "null"},
        {"expected", feed ? expectedAsJson(*feed, drag) : "null"},
        {"step", stepAsJson(cloud, runTime)},
        {"decisions", json::list(rows)},
        {"warnings", json::list(warnings)}
    });

    exitHandling::caseIsRead();
    if (Pstream::master())
    {
        const fileName folder(runTime.globalPath()/"postProcessing");
        mkDir(folder);
        std::ofstream file(folder/"plan.json");
        file << plan << '\n';
        if (!file.flush())
        {
            FatalErrorInFunction
                << "cannot write " << (folder/"plan.json")
                << ": is the disk full or the folder read-only?"
                << exit(FatalError);
        }
    }
}


} // End namespace Foam

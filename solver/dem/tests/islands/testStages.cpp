#include "islands/CandidateSearch.hpp"
#include "islands/FreeFlight.hpp"
#include "islands/IslandPartition.hpp"
#include "islands/IslandStepper.hpp"
#include "islands/OverlapSeparation.hpp"
#include "islands/PathCheck.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

// The adaptive integrator's stages, each alone.

using namespace scenes;

namespace
{

ParticleState sphere(std::uint64_t id, Vector3 position, Vector3 velocity, double radius = 1e-3,
                     Vector3 force = {})
{
    ParticleState s;
    s.id = id;
    s.radius = s.reach = radius;
    s.mass = 4.0/3*pi*radius*radius*radius*2500;
    s.force = force;
    s.flight = Flight(position, velocity, force, {}, 0);
    return s;
}

/// The stages and what they hand on, up to the candidates.
struct Stages
{
    Settings settings;
    Walls walls;
    SortedContacts history;
    BoundPairs boundPairs{settings};
    FreeFlights flights;
    Candidates candidates;

    explicit Stages(WallGeometry geometry = {}) : walls(std::move(geometry)) {}

    Piece piece(const std::vector<ParticleState>& start, double duration) const
    {
        return {start, history, duration, 1};
    }
    void find(const Piece& piece)
    {
        REQUIRE(flyFreely(piece, settings, flights));
        CandidateSearch(settings, walls, boundPairs).find(piece, flights, candidates);
    }
};

std::vector<ParticleState> thrownTogether(std::size_t count, double side, double speed)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(0, side), component(-speed, speed);
    std::vector<ParticleState> all;
    while (all.size() < count)
    {
        const ParticleState s =
            sphere(all.size() + 1, {place(random), place(random), place(random)},
                   {component(random), component(random), component(random)});
        if (std::all_of(all.begin(), all.end(), [&](const ParticleState& other)
            { return norm(s.flight.position - other.flight.position) > 2.1e-3; }))
            all.push_back(s);
    }
    return all;
}

ContactMaterials elasticGrain()
{
    PairProperties elastic;
    elastic.restitution = 1, elastic.friction = 0;
    return oneMaterial(elastic);
}

} // namespace

TEST_SUITE_BEGIN("stages");

TEST_CASE("free flight: the closed form, and bounds that hold every path in the moving frame")
{
    Stages stages;
    const Vector3 g{0, 0, -9.81};
    const std::vector<ParticleState> start{sphere(1, {}, {1, 0, 3}, 1e-3, g),
                                           sphere(2, {0.5, 0, 0}, {-2, 0.5, 0}, 2e-3, g)};
    const double time = 0.2;
    REQUIRE(flyFreely(stages.piece(start, time), stages.settings, stages.flights));
    CHECK(norm(stages.flights.end[0].position - Vector3{0.2, 0, 0.6 - 0.5*9.81*0.04}) < 1e-12);
    CHECK(norm(stages.flights.end[1].velocity - Vector3{-2, 0.5, -9.81*0.2}) < 1e-12);
    CHECK(norm(stages.flights.frame - Vector3{-0.5, 0.25, 1.5 - 0.981}) < 1e-12);
    for (std::size_t i = 0; i < 2; ++i)
        for (double t = 0; t <= time; t += 0.01)
        {
            const Vector3 place = start[i].flight.position + t*start[i].flight.velocity
                                  + (0.5*t*t)*g - t*stages.flights.frame;
            const Bound& bound = stages.flights.bounds[i];
            CHECK(norm(place - bound.centre) + start[i].radius <= bound.reach*(1 + 1e-12));
        }
}

TEST_CASE("free flight: refused where a path is too long for the periodic box")
{
    Stages stages;
    stages.settings.box = {{}, {0.1, 1, 1}, {true, false, false}};
    const auto fits = [&](double speed)
    {
        const std::vector<ParticleState> start{sphere(1, {}, {speed, 0, 0}),
                                               sphere(2, {}, {-speed, 0, 0})};
        return flyFreely(stages.piece(start, 0.01), stages.settings, stages.flights);
    };
    CHECK(fits(1));
    CHECK_FALSE(fits(10));
}

TEST_CASE("candidates: the pairs that brute force in small steps finds to touch")
{
    Stages stages;
    const std::vector<ParticleState> start = thrownTogether(300, 0.04, 1);
    const double time = 5e-3;
    stages.find(stages.piece(start, time));
    constexpr int looks = 500;
    std::vector<std::vector<Vector3>> places(start.size());
    for (std::size_t i = 0; i < start.size(); ++i)
        for (int k = 0; k <= looks; ++k)
            places[i].push_back(start[i].flight.at(k*time/looks).position);
    std::vector<Pair> touching;
    for (std::uint32_t i = 0; i < start.size(); ++i)
        for (std::uint32_t j = i + 1; j < start.size(); ++j)
            for (int k = 0; k <= looks; ++k)
                if (norm(places[i][k] - places[j][k]) < 2e-3)
                {
                    touching.push_back({i, j});
                    break;
                }
    REQUIRE(touching.size() > 20);
    for (const Pair& pair : touching)
        CHECK(std::count(stages.candidates.pairs.begin(), stages.candidates.pairs.end(), pair) == 1);
    CHECK(stages.candidates.pairs.size() <= touching.size() + 2);     // between two small steps
}

TEST_CASE("candidates: walls, contacts that last and overlaps that nobody knows")
{
    Stages stages(floorAt(0, 1));
    const std::vector<ParticleState> start{
        sphere(1, {0, 0, 0.01}, {0, 0, -2}),              // reaches the floor
        sphere(2, {0.1, 0, 0.05}, {0, 0, -2}),            // does not
        sphere(3, {0.2, 0, 0.9e-3}, {}),                  // lies on it, as it did before
        sphere(4, {0.3, 0, 0.9e-3}, {}),                  // was put into it
        sphere(5, {0, 0.2, 0.1}, {}), sphere(6, {1.9e-3, 0.2, 0.1}, {}),    // touch, as before
        sphere(7, {0, 0.3, 0.1}, {}), sphere(8, {1.9e-3, 0.3, 0.1}, {})};   // put into each other
    stages.history = SortedContacts({{3, 77, true, {}}, {5, 6, false, {}}});
    stages.find(stages.piece(start, 0.01));
    CHECK(stages.candidates.atWall == std::vector<std::uint32_t>{0, 2, 3});
    CHECK(stages.candidates.pairs == std::vector<Pair>{{4, 5}, {6, 7}});
    std::vector<std::uint32_t> touching = stages.candidates.touching;
    std::sort(touching.begin(), touching.end());
    CHECK(touching == std::vector<std::uint32_t>{2, 4, 5});
    REQUIRE(stages.candidates.overlaps.size() == 2);
    CHECK(stages.candidates.overlaps[0].first == 6);
    CHECK(stages.candidates.overlaps[0].second == 7);
    CHECK(stages.candidates.overlaps[1].first == 3);
    CHECK(stages.candidates.overlaps[1].second == Overlap::wall);

    std::vector<ParticleState> apart = start;
    separate(apart, stages.candidates.overlaps, stages.walls, {});
    CHECK(apart[3].flight.position.z == near(1e-3, 1e-9));
    const Vector3 &a = apart[6].flight.position, &b = apart[7].flight.position;
    CHECK(b.x - a.x == near(2e-3, 1e-9));
    CHECK(a.x + b.x == near(1.9e-3, 1e-9));               // the centre of mass stays
    CHECK(apart[4].flight.position.x == start[4].flight.position.x);
}

TEST_CASE("islands: the connected components of the candidates")
{
    constexpr std::uint32_t n = 60;
    std::mt19937 random(2);
    std::uniform_int_distribution<std::uint32_t> any(0, n - 1);
    Candidates candidates;
    std::vector<std::uint32_t> label(n);
    for (std::uint32_t i = 0; i < n; ++i) label[i] = i;
    for (int k = 0; k < 30; ++k)
    {
        const std::uint32_t a = any(random), b = any(random);
        if (a == b) continue;
        candidates.pairs.push_back({std::min(a, b), std::max(a, b)});
        const std::uint32_t from = label[a], to = label[b];
        for (std::uint32_t& l : label) if (l == from) l = to;
    }
    candidates.atWall = {3, 40};
    candidates.touching = {candidates.pairs[0].first};
    IslandPartition made;
    partition(n, candidates, made);

    const auto involved = [&](std::uint32_t i)
    {
        return i == 3 || i == 40
            || std::any_of(candidates.pairs.begin(), candidates.pairs.end(), [&](const Pair& p)
               { return p.first == i || p.second == i; });
    };
    for (std::uint32_t i = 0; i < n; ++i)
    {
        CHECK(made.isFree(i) != involved(i));
        if (made.isFree(i)) continue;
        CHECK(made.islands[made.islandOf[i]].particles[made.placeIn[i]] == i);
        CHECK(made.islands[made.islandOf[i]].touching
              == (label[i] == label[candidates.touching[0]]));
        for (std::uint32_t j = 0; j < n; ++j)
            if (!made.isFree(j) && i != j) CHECK(made.share(i, j) == (label[i] == label[j]));
    }
}

TEST_CASE("islands: a hit joins two islands, and a free particle to one")
{
    Candidates candidates;
    candidates.pairs = {{0, 1}, {3, 4}, {6, 7}};
    candidates.touching = {3, 4};
    IslandPartition made;
    partition(8, candidates, made);
    REQUIRE(made.islands.size() == 3);
    CHECK(made.largestWithoutContacts() == 2);
    std::size_t mergedAway = 0;
    const std::vector<std::uint32_t> grown = made.merge({{1, 3}, {2, 4}}, mergedAway);
    CHECK(grown == std::vector<std::uint32_t>{0});
    CHECK(mergedAway == 2);
    CHECK(made.islands[0].particles == std::vector<std::uint32_t>{0, 1, 2, 3, 4});
    CHECK(made.islands[0].touching);
    CHECK(made.islands[made.islandOf[6]].particles == std::vector<std::uint32_t>{6, 7});
    CHECK(made.isFree(5));
    for (std::uint32_t i = 0; i < 5; ++i) CHECK(made.placeIn[i] == i);
}

TEST_CASE("island stepper: equal elastic spheres exchange their velocities at the time of contact")
{
    Stages stages;
    const ContactMaterials materials = elasticGrain();
    const LawTables laws(stages.settings, materials);
    const ImpactLaws impacts(laws, materials);
    IslandStepper stepper(stages.settings, laws, stages.walls, impacts,
                          [](const Particles&, double) { return 1e-6; });
    const std::vector<ParticleState> start{sphere(1, {}, {1, 0, 0}), sphere(2, {0.9, 0, 0}, {}),
                                           sphere(3, {12e-3, 0, 0}, {-1, 0, 0})};
    IslandResult result;
    stepper.run(stages.piece(start, 0.01), {{0, 2}, false}, result);
    CHECK(result.impacts == 1);
    CHECK(result.subSteps == 0);
    CHECK(result.end[0].flight.velocity.x == near(-1, 1e-12));
    CHECK(result.end[1].flight.velocity.x == near(1, 1e-12));
    CHECK(std::abs(result.end[0].flight.position.x) < 1e-11);       // met at 5 mm after 5 ms
    REQUIRE(result.paths[0].size() == 2);
    CHECK(result.paths[0][1].begin == near(5e-3, 1e-9));
}

TEST_CASE("island stepper: spheres that touch from before take the soft law and part")
{
    Stages stages;
    stages.settings.law = &contactLaw<LinearSpringDashpot>;
    const ContactMaterials materials = elasticGrain();
    const LawTables laws(stages.settings, materials);
    const ImpactLaws impacts(laws, materials);
    IslandStepper stepper(stages.settings, laws, stages.walls, impacts,
                          [](const Particles&, double) { return 2e-6; });
    stages.history = SortedContacts({{1, 2, false, {}}});
    const double overlap = 1e-5;
    const std::vector<ParticleState> start{sphere(1, {}, {}), sphere(2, {2e-3 - overlap, 0, 0}, {})};
    IslandResult result;
    stepper.run(stages.piece(start, 5e-3), {{0, 1}, true}, result);
    CHECK(result.soft());
    CHECK(result.contacts.empty());
    // the spring's energy k overlap^2/2 becomes that of both: k = 1e4 N/m
    const double speed = std::sqrt(0.5*1e4/start[0].mass)*overlap;
    CHECK(result.end[0].flight.velocity.x == near(-speed, 1e-3));
    CHECK(result.end[1].flight.velocity.x == near(speed, 1e-3));
}

TEST_CASE("path check: who is hit by a path that an impact has changed, and nobody else")
{
    Stages stages;
    const ContactMaterials materials = elasticGrain();
    const LawTables laws(stages.settings, materials);
    const ImpactLaws impacts(laws, materials);
    IslandStepper stepper(stages.settings, laws, stages.walls, impacts,
                          [](const Particles&, double) { return 1e-6; });
    const std::vector<ParticleState> start{
        sphere(1, {}, {1, 0, 0}), sphere(2, {5e-3, 0, 0}, {}),    // 2 is thrown along x
        sphere(3, {9e-3, 0, 0}, {}),                              // in its way
        sphere(4, {9e-3, 5e-3, 0}, {})};                          // beside it
    const Piece piece = stages.piece(start, 0.01);
    stages.find(piece);
    CHECK(std::find(stages.candidates.pairs.begin(), stages.candidates.pairs.end(), Pair{1, 2})
          == stages.candidates.pairs.end());
    IslandPartition made;
    Candidates known;
    known.pairs = {{0, 1}};
    partition(start.size(), known, made);
    std::vector<IslandResult> results(1);
    stepper.run(piece, made.islands[0], results[0]);
    std::vector<Pair> hits = PathCheck(stages.settings, stages.boundPairs)
        .find(piece, made, results, {0}, stages.flights.frame, stages.flights.bounds);
    for (Pair& hit : hits)
        if (hit.first > hit.second) std::swap(hit.first, hit.second);
    CHECK(hits == std::vector<Pair>{{1, 2}});
}

TEST_CASE("contact records: those of a particle are found by its id")
{
    const SortedContacts contacts({{9, 12, false, {}}, {2, 5, false, {}}, {2, 70, true, {}},
                                   {2, 1, true, {}}});
    CHECK(contacts.holdsPair(5, 2));
    CHECK_FALSE(contacts.holdsPair(2, 9));
    CHECK_FALSE(contacts.holdsPair(2, 70));
    CHECK(contacts.holdsWall(2));
    CHECK_FALSE(contacts.holdsWall(9));
    CHECK(contacts.ends() == 6);
    std::vector<ContactRecord> of;
    contacts.copy(2, of);
    CHECK(of.size() == 3);
}

TEST_SUITE_END();

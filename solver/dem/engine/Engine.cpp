#include "engine/Engine.hpp"

#include "core/TooMuchWork.hpp"
#include "core/text.hpp"
#include "islands/AdaptiveIntegrator.hpp"
#include "islands/Census.hpp"
#include "parallel/Agreement.hpp"
#include "soft/SoftIntegrator.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace elutria::dem
{

struct Engine::Implementation
{
    Settings settings;
    ContactMaterials materials;
    Walls walls;
    LawTables laws;
    SoftIntegrator soft;
    Exchange& exchange;
    AdaptiveIntegrator adaptive;
    bool warnedOfSeparation = false;   // once is enough: a feed may do so in every step

    Implementation(Settings s, ContactMaterials m, Walls w, Exchange& e)
      : settings(std::move(s)), materials(std::move(m)), walls(std::move(w)),
        laws(settings, materials), soft(settings, laws, walls, e), exchange(e),
        adaptive(settings, materials, laws, walls, soft,
               [this](const Particles& p, double speed)
               { return settings.step > 0 ? settings.step : stepLimit(p, speed); }, exchange)
    {}

    bool softOnly() const { return settings.treatment == ContactTreatment::soft; }
    double stepLimit(const Particles& particles, double speed) const;
    void runSoft(Particles& particles, double duration, StepReport& report);
};

namespace
{

constexpr double mostSizeRatio = 1 << 20;

void check(const Settings& s)
{
    require(s.cellLayers >= 1 && s.cellLayers <= 8, "cellLayers", s.cellLayers, "1 to 8");
    require(s.threads >= 1 && s.threads <= 1024, "threads", s.threads, "1 to 1024");
    require(s.stepFraction > 0 && s.stepFraction <= 2, "stepFraction", s.stepFraction,
            "above 0, up to 2");
    require(s.step >= 0 && std::isfinite(s.step), "step", s.step, "0 s (automatic) or more");
    require(s.skin >= 0 && std::isfinite(s.skin), "skin", s.skin, "0 m (automatic) or more");
}

/// Every column is as long as `id`, or empty if the engine can do without it.
void checkLengths(const Particles& p)
{
    struct Column
    {
        const char* name;
        std::size_t size;
        bool optional;
    };
    for (const Column& c : {Column{"material", p.material.size(), false},
                            Column{"radius", p.radius.size(), false},
                            Column{"mass", p.mass.size(), false},
                            Column{"position", p.position.size(), false},
                            Column{"velocity", p.velocity.size(), false},
                            Column{"spin", p.spin.size(), false},
                            Column{"statisticalWeight", p.statisticalWeight.size(), true},
                            Column{"solidFraction", p.solidFraction.size(), true},
                            Column{"dragRate", p.dragRate.size(), true},
                            Column{"gasVelocity", p.gasVelocity.size(), true},
                            Column{"acceleration", p.acceleration.size(), true}})
    {
        if (c.size == p.size() || (c.optional && c.size == 0)) continue;
        throw std::invalid_argument(std::string("particle array ") + c.name + " has "
            + std::to_string(c.size) + " entries; allowed: " + std::to_string(p.size())
            + (c.optional ? " or 0" : ""));
    }
}

void check(const Particles& p, std::size_t materials)
{
    checkLengths(p);
    const auto finite = [](const Vector3& v)
    {
        return std::isfinite(v.x + v.y + v.z);
    };
    double smallest = 1e300, largest = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        smallest = std::min(smallest, p.radius[i]), largest = std::max(largest, p.radius[i]);
        const auto of = [&](const char* what)
        {
            return std::string(what) + " of particle " + std::to_string(p.id[i]);
        };
        const auto refuse = [&](const char* what, double value, const std::string& range)
        {
            require(false, of(what), value, range);
        };
        if (!(p.radius[i] > 0 && std::isfinite(p.radius[i])))
            refuse("radius", p.radius[i], "above 0 m");
        if (!(p.mass[i] > 0 && std::isfinite(p.mass[i])))
            refuse("mass", p.mass[i], "above 0 kg");
        if (p.material[i] >= materials)
            refuse("material", p.material[i], "0 to " + std::to_string(materials - 1));
        if (!finite(p.position[i]) || !finite(p.velocity[i]) || !finite(p.spin[i]))
            throw std::invalid_argument(of("position, velocity or spin") + " is not finite");
        if (!p.dragRate.empty() && !(p.dragRate[i] >= 0 && std::isfinite(p.dragRate[i])))
            refuse("dragRate", p.dragRate[i], "0 1/s or more");
        const double weight = p.statisticalWeight.empty() ? 1 : p.statisticalWeight[i];
        if (!(weight > 0 && std::isfinite(weight))) refuse("statisticalWeight", weight, "above 0");
    }
    require(largest <= mostSizeRatio*smallest,
            "radius ratio of largest and smallest particle", largest/smallest,
            "up to " + text(mostSizeRatio) + ", what the levels of cells span");
}

void warn(const Settings& settings, StepReport& report, bool& warnedOfSeparation)
{
    if (report.largestOverlap > settings.largestOverlap)
    {
        report.warnings.push_back({"overlap", "contacts are too soft for these speeds",
            "overlap of " + text(std::round(1e4*report.largestOverlap)/100)
            + " % of a particle's radius, allowed: " + text(100*settings.largestOverlap) + " %",
            "raise youngsModulus or normalStiffness, unless particles were inserted into each other",
            report.largestOverlap});
    }
    if (report.separated > 0 && !warnedOfSeparation)
    {
        warnedOfSeparation = true;
        report.warnings.push_back({"separated",
            "particles that overlapped each other or a wall without a contact were separated",
            std::to_string(report.separated) + " of them in a step",
            "widen the feed's patch or zone: it inserts particles into each other or into a wall",
            double(report.separated)});
    }
}

} // namespace

Engine::Engine(Settings settings, ContactMaterials materials, Walls walls, Exchange& exchange)
{
    check(settings);
    materials.check();
    for (std::uint32_t m : walls.geometry().material)
    {
        require(m < materials.size(), "wall material", m,
                "0 to " + std::to_string(materials.size() - 1));
    }
    self_ = std::make_unique<Implementation>(std::move(settings), std::move(materials),
                                             std::move(walls), exchange);
}

Engine::~Engine() = default;
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;

StepReport Engine::advance(Particles& particles, double duration)
{
    require(duration > 0 && std::isfinite(duration), "duration", duration, "above 0 s");
    together(self_->exchange, [&] { check(particles, self_->materials.size()); });
    StepReport report;
    report.particles = particles.size();
    if (self_->softOnly()) self_->runSoft(particles, duration, report);
    else self_->adaptive.advance(particles, duration, report);
    sortHits(report.hits);
    report.own = report;
    StepCounts all;
    for (const StepCounts& ofRank : shareEach<StepCounts>(self_->exchange, report)) all.add(ofRank);
    static_cast<StepCounts&>(report) = all;
    warn(self_->settings, report, self_->warnedOfSeparation);
    return report;
}

void Engine::contactForces(const Particles& particles, double step, VectorArray& force,
                           VectorArray& torque)
{
    together(self_->exchange, [&] { check(particles, self_->materials.size()); });
    self_->adaptive.useSoft();
    self_->soft.contactForces(particles, step, force, torque);
}

void Engine::Implementation::runSoft(Particles& particles, double duration, StepReport& report)
{
    const Census all = takeCensus(exchange, particles, 0);
    const double limit = settings.step > 0 ? settings.step : stepLimit(all.decisive(particles), 0);
    const double steps = stepsOf(duration, limit);
    refuseTooMuchWork(duration, steps, all.particles);
    soft.run(particles, duration, std::size_t(steps), report);
}

std::vector<ContactRecord> Engine::exportContacts() const
{
    return self_->softOnly() ? self_->soft.exportContacts() : self_->adaptive.exportContacts();
}

void Engine::importContacts(const std::vector<ContactRecord>& records)
{
    if (self_->softOnly()) self_->soft.importContacts(records);
    else self_->adaptive.importContacts(records);
}

void Engine::setWallMotions(std::vector<WallMotion> motions)
{
    self_->walls.setMotions(std::move(motions));
}

void Engine::setWallAnswers(std::vector<WallAnswer> answers)
{
    self_->walls.setAnswers(std::move(answers));
}

double Engine::stepLimit(const Particles& particles, double speed) const
{
    return self_->stepLimit(particles, speed);
}

double Engine::Implementation::stepLimit(const Particles& particles, double speed) const
{
    if (particles.size() == 0) return 1e300;
    double radius = 1e300, mass = 1e300, fastest = 0;
    std::uint64_t moving = 0;       // bits of the particles' materials: walls do not meet each other
    const auto bit = [](std::uint32_t material) { return 1ull << std::min(material, 63u); };
    for (std::size_t i = 0; i < particles.size(); ++i)
    {
        moving |= bit(particles.material[i]);
        radius = std::min(radius, particles.radius[i]);
        mass = std::min(mass, particles.mass[i]);
        fastest = std::max(fastest, norm(particles.velocity[i]));
    }
    if (!(speed > 0)) speed = std::max(2*fastest, 0.1);
    double shortest = 1e300;
    laws.forEach([&](const LawTable& table, std::uint32_t a, std::uint32_t b)
    {
        if (!(moving & (bit(a) | bit(b)))) return;
        shortest = std::min(shortest,
                            table.law().contactTime(table(a, b), radius/2, mass/2, speed));
    });
    return settings.stepFraction*shortest;
}

double Engine::expectedOverlap(double radius, double density, double speed) const
{
    const double mass = 0.5*density*4.0/3*laws::pi*radius*radius*radius;
    double deepest = 0;
    self_->laws.forEach([&](const LawTable& table, std::uint32_t a, std::uint32_t b)
    {
        deepest = std::max(deepest,
                           table.law().largestOverlap(table(a, b), radius/2, mass, speed));
    });
    return deepest/radius;
}

double Engine::storedEnergy(double radius, double overlap) const
{
    double most = 0;
    self_->laws.forEach([&](const LawTable& table, std::uint32_t a, std::uint32_t b)
    {
        most = std::max(most, table.law().storedEnergy(table(a, b), radius, overlap));
    });
    return most;
}

const Settings& Engine::settings() const { return self_->settings; }
const ContactMaterials& Engine::materials() const { return self_->materials; }
const Walls& Engine::walls() const { return self_->walls; }
Exchange& Engine::exchange() const { return self_->exchange; }

} // namespace elutria::dem

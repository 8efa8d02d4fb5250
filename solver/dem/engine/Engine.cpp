#include "engine/Engine.hpp"

#include "islands/AdaptiveIntegrator.hpp"
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
    LawTable laws, wallLaws;
    SoftIntegrator soft;
    AdaptiveIntegrator adaptive;
    bool separationTold = false;       // a feed may do so in every step: once will do

    Implementation(Settings s, ContactMaterials m, Walls w)
      : settings(std::move(s)), materials(std::move(m)), walls(std::move(w)),
        laws(*settings.law, materials), wallLaws(settings.lawAtWalls(), materials),
        soft(settings, materials, walls),
        adaptive(settings, materials, walls, soft,
               [this](const Particles& p)
               { return settings.step > 0 ? settings.step : stepLimit(p, 0); })
    {}

    bool softOnly() const { return settings.treatment == ContactTreatment::soft; }
    double stepLimit(const Particles& particles, double speed) const;
};

namespace
{

constexpr double mostSizeRatio = 1 << 20;

void check(const Settings& s)
{
    const auto require = [](bool allowed, const std::string& what, double value,
                            const std::string& range)
    {
        if (!allowed)
        {
            throw std::invalid_argument(what + " is " + std::to_string(value) + "; allowed: "
                                        + range);
        }
    };
    require(s.cellLayers >= 1 && s.cellLayers <= 8, "cellLayers", s.cellLayers, "1 to 8");
    require(s.threads >= 1 && s.threads <= 1024, "threads", s.threads, "1 to 1024");
    require(s.stepFraction > 0 && s.stepFraction <= 2, "stepFraction", s.stepFraction,
            "above 0, up to 2");
    require(s.step >= 0 && std::isfinite(s.step), "step", s.step, "0 s (automatic) or more");
    require(s.skin >= 0 && std::isfinite(s.skin), "skin", s.skin, "0 m (automatic) or more");
}

void check(const Particles& p, std::size_t materials)
{
    const std::size_t n = p.size();
    const auto length = [n](std::size_t size, const char* name, bool optional = false)
    {
        if (size != n && !(optional && size == 0))
        {
            throw std::invalid_argument(std::string("particle array ") + name + " has "
                + std::to_string(size) + " entries; expected " + std::to_string(n));
        }
    };
    length(p.material.size(), "material");
    length(p.radius.size(), "radius");
    length(p.mass.size(), "mass");
    length(p.position.size(), "position");
    length(p.velocity.size(), "velocity");
    length(p.spin.size(), "spin");
    length(p.dragRate.size(), "dragRate", true);
    length(p.gasVelocity.size(), "gasVelocity", true);
    length(p.acceleration.size(), "acceleration", true);
    const auto finite = [](const Vector3& v)
    {
        return std::isfinite(v.x + v.y + v.z);
    };
    double smallest = 1e300, largest = 0;
    for (std::size_t i = 0; i < n; ++i)
    {
        smallest = std::min(smallest, p.radius[i]), largest = std::max(largest, p.radius[i]);
        const auto of = [&](const char* what)
        {
            return std::string(what) + " of particle " + std::to_string(p.id[i]);
        };
        if (!(p.radius[i] > 0 && std::isfinite(p.radius[i])))
            throw std::invalid_argument(of("radius") + " is " + std::to_string(p.radius[i])
                                        + "; allowed: above 0 m");
        if (!(p.mass[i] > 0 && std::isfinite(p.mass[i])))
            throw std::invalid_argument(of("mass") + " is " + std::to_string(p.mass[i])
                                        + "; allowed: above 0 kg");
        if (p.material[i] >= materials)
            throw std::invalid_argument(of("material") + " is " + std::to_string(p.material[i])
                                        + "; allowed: 0 to " + std::to_string(materials - 1));
        if (!finite(p.position[i]) || !finite(p.velocity[i]) || !finite(p.spin[i]))
            throw std::invalid_argument(of("position, velocity or spin") + " is not finite");
        if (!p.dragRate.empty() && !(p.dragRate[i] >= 0 && std::isfinite(p.dragRate[i])))
            throw std::invalid_argument(of("dragRate") + " is " + std::to_string(p.dragRate[i])
                                        + "; allowed: 0 1/s or more");
    }
    if (largest > mostSizeRatio*smallest)
    {
        throw std::invalid_argument("radius ratio of largest and smallest particle is "
            + std::to_string(largest/smallest) + "; allowed: up to "
            + std::to_string(std::size_t(mostSizeRatio)) + ", what the levels of cells span");
    }
}

void warn(const Settings& settings, StepReport& report, bool& separationTold)
{
    if (report.largestOverlap > settings.largestOverlap)
    {
        report.warnings.push_back("overlap of " + std::to_string(100*report.largestOverlap)
            + " % of the radius is above " + std::to_string(100*settings.largestOverlap)
            + " %: the contacts are too soft for these speeds, or particles started in each other");
    }
    if (report.separated > 0 && !separationTold)
    {
        separationTold = true;
        report.warnings.push_back(std::to_string(report.separated) + " overlaps at the start of the "
            "step were nobody's contact, and were moved apart: particles are put into each other "
            "or into a wall");
    }
}

} // namespace

Engine::Engine(Settings settings, ContactMaterials materials, Walls walls)
{
    check(settings);
    materials.check();
    for (std::uint32_t m : walls.geometry().material)
    {
        if (m >= materials.size())
        {
            throw std::invalid_argument("wall material is " + std::to_string(m)
                                        + "; allowed: 0 to " + std::to_string(materials.size() - 1));
        }
    }
    self_ = std::make_unique<Implementation>(std::move(settings), std::move(materials),
                                             std::move(walls));
}

Engine::~Engine() = default;
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;

StepReport Engine::advance(Particles& particles, double duration)
{
    if (!(duration > 0 && std::isfinite(duration)))
    {
        throw std::invalid_argument("duration is " + std::to_string(duration)
                                    + "; allowed: above 0 s");
    }
    check(particles, self_->materials.size());
    StepReport report;
    if (self_->softOnly())
    {
        const double limit =
            self_->settings.step > 0 ? self_->settings.step : stepLimit(particles);
        const double steps = std::max(1.0, std::ceil(duration/limit*(1 - 1e-12)));
        self_->soft.run(particles, duration, std::size_t(steps), report);
    }
    else
    {
        self_->adaptive.advance(particles, duration, report);
    }
    warn(self_->settings, report, self_->separationTold);
    return report;
}

void Engine::contactForces(const Particles& particles, double step, VectorArray& force,
                           VectorArray& torque)
{
    check(particles, self_->materials.size());
    self_->adaptive.useSoft();
    self_->soft.contactForces(particles, step, force, torque);
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
    for (std::uint32_t a = 0; a < materials.size(); ++a)
    {
        for (std::uint32_t b = 0; b <= a; ++b)
        {
            if (!(moving & (bit(a) | bit(b)))) continue;
            for (const LawTable* table : {&laws, &wallLaws})
                shortest = std::min(shortest, table->law().contactTime((*table)(a, b), radius/2,
                                                                       mass/2, speed));
        }
    }
    return settings.stepFraction*shortest;
}

double Engine::expectedOverlap(double radius, double density, double speed) const
{
    const double mass = 0.5*density*4.0/3*laws::pi*radius*radius*radius;
    double deepest = 0;
    for (std::uint32_t a = 0; a < self_->materials.size(); ++a)
    {
        for (std::uint32_t b = 0; b <= a; ++b)
        {
            for (const LawTable* table : {&self_->laws, &self_->wallLaws})
                deepest = std::max(deepest, table->law().largestOverlap((*table)(a, b), radius/2,
                                                                        mass, speed));
        }
    }
    return deepest/radius;
}

double Engine::storedEnergy(double radius, double overlap) const
{
    double most = 0;
    for (const LawTable* table : {&self_->laws, &self_->wallLaws})
        for (std::uint32_t a = 0; a < table->size(); ++a)
            for (std::uint32_t b = 0; b <= a; ++b)
                most = std::max(most, table->law().storedEnergy((*table)(a, b), radius, overlap));
    return most;
}

const Settings& Engine::settings() const { return self_->settings; }
const ContactMaterials& Engine::materials() const { return self_->materials; }
const Walls& Engine::walls() const { return self_->walls; }

} // namespace elutria::dem

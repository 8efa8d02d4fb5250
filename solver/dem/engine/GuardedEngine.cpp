#include "engine/GuardedEngine.hpp"

#include "core/ParticleName.hpp"
#include "core/TooMuchWork.hpp"
#include "core/text.hpp"
#include "islands/Census.hpp"
#include "parallel/Message.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <stdexcept>

namespace elutria::dem
{

namespace
{

constexpr double margin = 1.5;           // energy above the allowed one: a sub-step is not exact
constexpr std::size_t neighbours = 12;   // spheres that a sphere of no smaller ones can touch

bool isFinite(const Particles& p, std::size_t i)
{
    const auto finite = [](const Vector3& v) { return std::isfinite(v.x + v.y + v.z); };
    return finite(p.position[i]) && finite(p.velocity[i]) && finite(p.spin[i]);
}

bool isFinite(const Particles& p)
{
    for (std::size_t i = 0; i < p.size(); ++i)
        if (!isFinite(p, i)) return false;
    return true;
}

double kineticEnergy(const Particles& p)
{
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        sum += 0.5*p.mass[i]*(squaredNorm(p.velocity[i])
                              + 0.4*p.radius[i]*p.radius[i]*squaredNorm(p.spin[i]));
    return sum;
}

double largestSpeed(const Particles& p)
{
    double square = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        square = std::max(square, squaredNorm(p.velocity[i]));
    return std::sqrt(square);
}

/// Most that walls of this speed can give: seen from a wall that moves along itself, a contact only
/// takes energy, so that no speed grows by more than twice the wall's.
double wallWork(const Particles& p, double wallSpeed)
{
    double sum = 0;
    for (std::size_t i = 0; wallSpeed > 0 && i < p.size(); ++i)
    {
        const double speed = norm(p.velocity[i]) + p.radius[i]*norm(p.spin[i]);
        sum += 2*p.mass[i]*wallSpeed*(speed + wallSpeed);
    }
    return sum;
}

/// Most that the forcing can give: drag (u - v) v is largest at v = u/2, a body force works along
/// the fastest path.
double forcingWork(const Particles& p, double fastest, double duration)
{
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        if (!p.dragRate.empty())
            sum += 0.25*p.mass[i]*p.dragRate[i]*duration
                   *squaredNorm(p.gasVelocity.empty() ? Vector3{} : p.gasVelocity[i]);
        if (!p.acceleration.empty())
            sum += p.mass[i]*norm(p.acceleration[i])*duration*fastest;
    }
    return sum;
}

} // namespace


StepReport GuardedEngine::advance(Particles& particles, double duration, int retakes)
{
    const Settings settings = engine_->settings();
    overlapRemoval_.place(particles, engine_->walls(), settings.box,
                          settings.treatment == ContactTreatment::soft, engine_->exchange());
    const Particles before = particles;
    const std::vector<ContactRecord> history = engine_->exportContacts();
    std::vector<Warning> warnings = shortenStep(particles, history);
    double firstEnergy = 0;
    for (int attempt = 0;; ++attempt)
    {
        Outcome outcome = tryStep(particles, before, history, duration, attempt == 0);
        if (attempt == 0) firstEnergy = kineticEnergy(particles);
        const bool last = attempt == retakes;
        if (last && attempt > 0 && !outcome.trouble.empty() && !outcome.broken
            && sum(kineticEnergy(particles)) > 0.5*sum(firstEnergy))
        {
            // Smaller steps give the same: overlaps that the call was given
            warnings.push_back({"contactEnergy", "contacts are not sound at any sub-step",
                outcome.trouble,
                "widen the feed's patch or zone: it inserts particles into each other or into a wall",
                1.0});
            reset(settings);
            outcome.trouble.clear();
        }
        if (outcome.trouble.empty())
        {
            StepReport report = accepted(std::move(outcome.report), warnings);
            if (attempt > 0 && !last) report.warnings.push_back(repeated(attempt));
            return report;
        }
        particles = before;
        if (last)
        {
            engine_->importContacts(history);
            throw std::runtime_error(outcome.trouble + ", also after " + std::to_string(retakes)
                + " retakes with smaller sub-steps; likely causes: particles inserted into each "
                  "other or into a wall, a contact step too large, or a gas that diverges");
        }
        refine(0.5, history);
    }
}


/// Shortens a contact step that was asked for and is too long, and says so.
std::vector<Warning> GuardedEngine::shortenStep(const Particles& particles,
                                                const std::vector<ContactRecord>& history)
{
    const Settings& settings = engine_->settings();
    if (!(settings.step > 0)) return {};
    const double limit =
        engine_->stepLimit(takeCensus(engine_->exchange(), particles, 0).decisive(particles));
    const double most = limit/settings.stepFraction*largestFraction_;
    if (settings.step <= most) return {};
    Warning warning{"contactStep", "the contact step asked for is too long",
        text(settings.step) + " s, allowed: " + text(most) + " s, " + text(largestFraction_)
        + " of the shortest contact",
        "set step of cellListCoeffs to at most that, or leave it out", settings.step/most};
    refine(most/settings.step, history);
    return {std::move(warning)};
}


GuardedEngine::Outcome GuardedEngine::tryStep(Particles& particles, const Particles& before,
                                              const std::vector<ContactRecord>& history,
                                              double duration, bool first)
{
    Outcome outcome;
    try
    {
        outcome.report = engine_->advance(particles, duration);
        outcome.trouble = unsound(before, particles, duration);
    }
    catch (const TooMuchWork&)
    {
        particles = before;
        engine_->importContacts(history);
        throw;
    }
    catch (const std::exception& error)
    {
        if (!overlapKnown_ && first) throw;     // of the first call: what was given
        return {{}, error.what(), true};
    }
    outcome.broken = !outcome.trouble.empty() && sum(isFinite(particles) ? 0 : 1) > 0;
    return outcome;
}


Warning GuardedEngine::repeated(int attempt) const
{
    return Warning{"contactRetaken",
        "a step of the contacts was rejected and repeated with smaller ones",
        "sub-steps of 1/" + std::to_string(1 << attempt) + ", which stay",
        "set stepFraction of cellListCoeffs to " + text(engine_->settings().stepFraction)
        + " or less", double(1 << attempt)};
}


/// Keeps what the next step's judgement needs; the report gets the warnings in front of its own.
StepReport GuardedEngine::accepted(StepReport report, const std::vector<Warning>& warnings)
{
    overlapKnown_ = true;
    overlap_ = report.largestOverlap;
    contacts_ = report.touching + report.wallTouching;
    report.warnings.insert(report.warnings.begin(), warnings.begin(), warnings.end());
    return report;
}


void GuardedEngine::reset(const Settings& settings)
{
    const std::vector<ContactRecord> history = engine_->exportContacts();
    engine_ = std::make_unique<Engine>(settings, engine_->materials(), engine_->walls(),
                                       engine_->exchange());
    engine_->importContacts(history);
}


void GuardedEngine::refine(double factor, const std::vector<ContactRecord>& history)
{
    Settings finer = engine_->settings();
    if (finer.step > 0) finer.step *= factor;
    else finer.stepFraction *= factor;
    engine_ = std::make_unique<Engine>(finer, engine_->materials(), engine_->walls(),
                                       engine_->exchange());
    engine_->importContacts(history);
}


double GuardedEngine::sum(double ofRank) const
{
    double all = 0;
    for (const double each : shareEach(engine_->exchange(), ofRank)) all += each;
    return all;
}


/// Energy that the contacts can hold, J. A contact counts for the smaller of the two: its radius bounds
/// the effective one. The most that as many contacts can hold is with the largest particles.
double GuardedEngine::held(std::vector<double> radius) const
{
    const ContactMaterials& materials = engine_->materials();
    double friction = 0;
    for (std::uint32_t a = 0; a < materials.size(); ++a)
        for (std::uint32_t b = 0; b <= a; ++b)
            friction = std::max(friction, materials.pair(a, b).friction);
    const std::size_t enough = contacts_/neighbours + 1;
    const auto largestFirst = [&]
    {
        std::sort(radius.begin(), radius.end(), std::greater<>());
        radius.resize(std::min(radius.size(), enough));
    };
    largestFirst();
    radius = joined(shareEach(engine_->exchange(), radius));
    largestFirst();
    double sum = 0;
    std::size_t left = std::min(contacts_, neighbours*radius.size());
    for (std::size_t i = 0; left > 0; ++i)
    {
        const std::size_t here = std::min(left, neighbours);
        sum += double(here)*engine_->storedEnergy(radius[i], overlap_*radius[i]);
        left -= here;
    }
    return sum*(1 + 2*friction*friction);                // with what tangential springs hold
}


double GuardedEngine::energyAllowed(const Particles& before, const Particles& after,
                                    double duration) const
{
    if (!overlapKnown_) return std::numeric_limits<double>::infinity();

    double fastest = 0;
    for (const double ofRank : shareEach(engine_->exchange(),
                                         std::max(largestSpeed(before), largestSpeed(after))))
        fastest = std::max(fastest, ofRank);
    return margin*(held(before.radius)
                   + sum(kineticEnergy(before) + wallWork(before, engine_->walls().largestSpeed())
                         + forcingWork(before, fastest, duration)));
}


std::string GuardedEngine::unsound(const Particles& before, const Particles& after,
                                   double duration) const
{
    Exchange& exchange = engine_->exchange();
    std::string lost;
    for (std::size_t i = 0; lost.empty() && i < after.size(); ++i)
        if (!isFinite(after, i))
            lost = "the motion of particle " + std::to_string(ParticleName(after.id[i]).number)
                   + " is not finite";
    Outgoing mine;
    mine << lost << kineticEnergy(before) << kineticEnergy(after);
    double energyBefore = 0, energy = 0;
    for (const Bytes& bytes : exchange.share(mine.take()))
    {
        Incoming in(bytes);
        lost = in.get<std::string>();
        if (!lost.empty()) return lost;
        energyBefore += in.get<double>(), energy += in.get<double>();
    }
    if (energy <= margin*energyBefore) return "";        // mostly: no need to look closer
    const double allowed = energyAllowed(before, after, duration);
    if (energy <= allowed) return "";

    struct Fastest { double square; std::uint64_t id; Vector3 place; };
    Fastest fastest{-1, 0, {}};
    for (std::size_t i = 0; i < after.size(); ++i)
        if (squaredNorm(after.velocity[i]) > fastest.square)
            fastest = {squaredNorm(after.velocity[i]), after.id[i], before.position[i]};
    for (const Fastest& ofRank : shareEach(exchange, fastest))
        if (ofRank.square > fastest.square) fastest = ofRank;
    const Vector3 place = fastest.place;
    return "contacts made energy: " + text(energy) + " J where at most " + text(allowed)
           + " J can be; the fastest is particle "
           + std::to_string(ParticleName(fastest.id).number) + " at (" + text(place.x) + " "
           + text(place.y) + " " + text(place.z) + ") m";
}

} // namespace elutria::dem

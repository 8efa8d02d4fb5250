#include "islands/ParticleStates.hpp"

#include "core/forEach.hpp"
#include "impacts/StochasticCollisions.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

namespace elutria::dem
{

void ParticleStates::load(const Particles& p, bool weighted)
{
    const std::size_t n = p.size();
    taken_.clear(), orderOfTaken_.clear();
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), 0u);
    if (!std::is_sorted(p.id.begin(), p.id.end()))
        std::sort(order_.begin(), order_.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return p.id[a] < p.id[b]; });
    all_.resize(n);
    forElements(settings_.threads, n, [&](std::size_t i)
    {
        const std::uint32_t k = order_[i];
        ParticleState& s = all_[i];
        s.id = p.id[k], s.material = p.material[k], s.mass = p.mass[k];
        s.radius = s.reach = p.radius[k];
        s.weight = p.statisticalWeight.empty() ? 1 : p.statisticalWeight[k];
        s.spin = p.spin[k];
        s.force = p.acceleration.empty() ? Vector3{} : p.acceleration[k];
        s.gasVelocity = p.gasVelocity.empty() ? Vector3{} : p.gasVelocity[k];
        s.flight = Flight(p.position[k], p.velocity[k], s.force, s.gasVelocity,
                          p.dragRate.empty() ? 0 : p.dragRate[k]);
        s.dragGain = {};
        s.taken = false;
    });
    for (std::size_t i = 1; i < n; ++i)
        if (all_[i - 1].id == all_[i].id)
            throw std::invalid_argument("particle id " + std::to_string(all_[i].id)
                                        + " is given twice; allowed: once");
    weighted_ = weighted || std::any_of(all_.begin(), all_.end(),
                                        [](const ParticleState& s) { return s.weight != 1; });
    if (weighted_) prepareStochasticCollisions(p);
}


/// How far and how often particles collide stochastically.
void ParticleStates::prepareStochasticCollisions(const Particles& p)
{
    double room = never;                  // in the periodic box, so that images stay apart
    for (int axis = 0; axis < 3; ++axis)
        if (settings_.box.periodic[axis])
            room = std::min(room, (settings_.box.high[axis] - settings_.box.low[axis])/16);
    for (std::size_t i = 0; i < all_.size(); ++i)
    {
        ParticleState& s = all_[i];
        s.reach = std::max(s.radius, std::min(collisionReach(s.radius, s.weight), room));
        if (!p.solidFraction.empty())
            s.enskogFactor = contactCorrelation(p.solidFraction[order_[i]]);
    }
}


void ParticleStates::setTakenAside()
{
    std::size_t left = 0;
    for (std::size_t i = 0; i < all_.size(); ++i)
    {
        if (all_[i].taken)
        {
            taken_.push_back(all_[i]), orderOfTaken_.push_back(order_[i]);
            continue;
        }
        if (left != i) all_[left] = all_[i], order_[left] = order_[i];
        ++left;
    }
    all_.resize(left), order_.resize(left);
}


void ParticleStates::store(const ParticleState& s, std::uint32_t k, const PeriodicBox& box,
                           Particles& p)
{
    p.position.set(k, box.wrapped(s.flight.position));
    p.velocity.set(k, s.flight.velocity);
    p.spin.set(k, s.spin);
    if (!p.dragRate.empty()) p.dragImpulse.set(k, s.mass*s.dragGain);
}


bool ParticleStates::storeTaken(Particles& p) const
{
    for (std::size_t i = 0; i < taken_.size(); ++i)
        store(taken_[i], orderOfTaken_[i], settings_.box, p);
    return !taken_.empty();
}


void ParticleStates::store(Particles& p) const
{
    if (!p.dragRate.empty()) p.dragImpulse.resize(p.size());
    forElements(settings_.threads, all_.size(),
                [&](std::size_t i) { store(all_[i], order_[i], settings_.box, p); });
    storeTaken(p);
}

} // namespace elutria::dem

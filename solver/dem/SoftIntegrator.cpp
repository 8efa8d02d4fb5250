#include "SoftIntegrator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace elutria::dem
{

SoftIntegrator::SoftIntegrator(const Settings& settings, const ContactMaterials& materials,
                               const Walls& walls)
  : settings_(settings), walls_(walls), laws_(settings.law, materials)
{}

void SoftIntegrator::load(const Particles& p)
{
    const std::size_t n = p.size();
    keepHistory();
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return p.id[a] < p.id[b]; });
    const auto gather = [&](auto& to, const auto& from)
    {
        to.resize(n);
        for (std::size_t i = 0; i < n; ++i) to[i] = from[order_[i]];
    };
    const auto gatherVectors = [&](VectorArray& to, const VectorArray& from)
    {
        to.assign(n, {});
        if (from.empty()) return;
        for (std::size_t i = 0; i < n; ++i) to.set(i, from[order_[i]]);
    };
    gather(id_, p.id);
    gather(material_, p.material);
    gather(radius_, p.radius);
    gather(mass_, p.mass);
    drag_ = !p.dragRate.empty();
    dragRate_.assign(n, 0);
    if (drag_) gather(dragRate_, p.dragRate);
    gatherVectors(position_, p.position);
    gatherVectors(velocity_, p.velocity);
    gatherVectors(surface_, p.spin);
    gatherVectors(gasVelocity_, p.gasVelocity);
    gatherVectors(acceleration_, p.acceleration);
    push_.assign(n, {});
    for (std::size_t i = 0; i < n; ++i)
    {
        position_.set(i, settings_.box.wrapped(position_[i]));
        surface_.set(i, radius_[i]*surface_[i]);
        push_.set(i, acceleration_[i] + dragRate_[i]*gasVelocity_[i]);
    }
    velocityBase_ = velocity_;
    surfaceBase_ = surface_;
    dragImpulse_.assign(n, {});
    force_.assign(n, {});
    moment_.assign(n, {});
}

void SoftIntegrator::store(Particles& p) const
{
    if (drag_) p.dragImpulse.resize(p.size());
    for (std::size_t i = 0; i < id_.size(); ++i)
    {
        const std::uint32_t k = order_[i];
        p.position.set(k, settings_.box.wrapped(position_[i]));
        p.velocity.set(k, velocity_[i]);
        p.spin.set(k, (1/radius_[i])*surface_[i]);
        if (drag_) p.dragImpulse.set(k, dragImpulse_[i]);
    }
}

void SoftIntegrator::buildLists(double skin)
{
    keepHistory();
    skin_ = skin;
    built_ = position_;
    std::vector<double> reach(radius_);
    for (double& r : reach) r += 0.5*skin;
    std::vector<Pair> found;
    findPairs({id_.size(), position_.x.data(), position_.y.data(), position_.z.data(),
               reach.data()}, settings_.box, settings_.search, settings_.cellLayers, found);
    const auto remembered = [&](std::uint64_t first, std::uint64_t second, bool wall)
    {
        const auto before = [](const ContactRecord& a, const ContactRecord& b)
        {
            if (a.wall != b.wall) return b.wall;
            return a.first != b.first ? a.first < b.first : a.second < b.second;
        };
        const ContactRecord key{first, second, wall, {}};
        const auto at = std::lower_bound(kept_.begin(), kept_.end(), key, before);
        return at != kept_.end() && !before(key, *at) ? &*at : nullptr;
    };
    pairs_.clear();
    for (const Pair& pair : found)     // order_ is by id, so first has the smaller id
    {
        PairContact contact{pair.first, pair.second, {}};
        if (const ContactRecord* r = remembered(id_[pair.first], id_[pair.second], false))
        {
            contact.history = {r->tangential, true};
        }
        pairs_.push_back(contact);
    }
    wallCandidates_.clear();
    for (std::uint32_t i = 0; i < id_.size(); ++i)
    {
        if (walls_.distanceBound(position_[i]) > reach[i]) continue;
        WallCandidate candidate{i, {}, {}};
        walls_.collect(position_[i], reach[i], candidate.images);
        if (candidate.images.empty()) continue;
        for (const ContactRecord& r : kept_)
        {
            if (r.wall && r.first == id_[i])
            {
                candidate.histories.push_back({r.second, {r.tangential, true}});
            }
        }
        wallCandidates_.push_back(std::move(candidate));
    }
    kept_.clear();
}

bool SoftIntegrator::listsHold() const
{
    const double limit = 0.25*skin_*skin_;
    for (std::size_t i = 0; i < id_.size(); ++i)
    {
        if (!(squaredNorm(position_[i] - built_[i]) < limit)) return false;
    }
    return true;
}

void SoftIntegrator::keepHistory()
{
    for (const PairContact& c : pairs_)
    {
        if (c.history.touching)
        {
            kept_.push_back({id_[c.first], id_[c.second], false, c.history.tangential});
        }
    }
    for (const WallCandidate& w : wallCandidates_)
    {
        for (const auto& [feature, history] : w.histories)
        {
            if (history.touching)
            {
                kept_.push_back({id_[w.particle], feature, true, history.tangential});
            }
        }
    }
    pairs_.clear();
    wallCandidates_.clear();
    std::sort(kept_.begin(), kept_.end(), [](const ContactRecord& a, const ContactRecord& b)
    {
        if (a.wall != b.wall) return b.wall;
        return a.first != b.first ? a.first < b.first : a.second < b.second;
    });
}

template<ContactLaw law>
void SoftIntegrator::evaluatePairsWith(StepWeights w, StepReport* report)
{
    std::size_t touching = 0;
    double largest = 0;
    for (PairContact& c : pairs_)
    {
        const std::uint32_t i = c.first, j = c.second;
        const Vector3 apart = settings_.box.shortest(position_[i] - position_[j]);
        const double sum = radius_[i] + radius_[j], distance2 = squaredNorm(apart);
        if (distance2 >= sum*sum && !c.history.touching) continue;
        const double distance = std::sqrt(distance2), share = distance/sum;
        Encounter e;
        e.normal = (1/distance)*apart;
        e.overlap = sum - distance;
        e.slip = velocity_[i] - velocity_[j] - share*cross(surface_[i] + surface_[j], e.normal);
        e.radius = radius_[i]*radius_[j]/sum;
        e.mass = mass_[i]*mass_[j]/(mass_[i] + mass_[j]);
        const Vector3 past = velocity_[i] - velocity_[j];
        e.turning = (1/distance)*(past - dot(past, e.normal)*e.normal);
        const ContactForce f =
            contactForce<law>(laws_(material_[i], material_[j]), e, c.history, w);
        const Vector3 total = f.normal*e.normal + f.tangential;
        const Vector3 moment = -share*cross(e.normal, f.tangential);
        force_.set(i, force_[i] + total);
        force_.set(j, force_[j] - total);
        moment_.set(i, moment_[i] + moment);
        moment_.set(j, moment_[j] + moment);
        touching += c.history.touching;
        largest = std::max(largest, e.overlap/std::min(radius_[i], radius_[j]));
    }
    if (report)
    {
        report->touching = touching;
        report->largestOverlap = std::max(report->largestOverlap, largest);
    }
}

void SoftIntegrator::evaluatePairs(StepWeights w, StepReport* report)
{
    switch (settings_.law)
    {
        case ContactLaw::linear: return evaluatePairsWith<ContactLaw::linear>(w, report);
        case ContactLaw::hertz: return evaluatePairsWith<ContactLaw::hertz>(w, report);
        case ContactLaw::springSliderDashpot:
            return evaluatePairsWith<ContactLaw::springSliderDashpot>(w, report);
    }
}

void SoftIntegrator::evaluateWalls(StepWeights w, StepReport* report)
{
    std::vector<WallContact> found;
    std::vector<std::pair<std::uint64_t, ContactHistory>> next;
    std::size_t touching = 0;
    for (WallCandidate& candidate : wallCandidates_)
    {
        const std::uint32_t i = candidate.particle;
        const Vector3 position = position_[i];
        walls_.contacts(position, radius_[i], 0.5*skin_, candidate.images, found);
        next.clear();
        for (const WallContact& wall : found)
        {
            ContactHistory history;
            for (const auto& [feature, old] : candidate.histories)
            {
                if (feature == wall.feature) history = old;
            }
            if (wall.gap >= 0 && !history.touching) continue;
            Encounter e;
            e.normal = wall.normal;
            e.overlap = -wall.gap;
            const double share = (radius_[i] + wall.gap)/radius_[i];
            e.slip = velocity_[i] - share*cross(surface_[i], e.normal);
            e.radius = radius_[i];
            e.mass = mass_[i];
            const laws::Coefficients& c = laws_(material_[i], wall.material);
            const ContactForce f = settings_.law == ContactLaw::linear
                ? contactForce<ContactLaw::linear>(c, e, history, w)
                : settings_.law == ContactLaw::hertz
                ? contactForce<ContactLaw::hertz>(c, e, history, w)
                : contactForce<ContactLaw::springSliderDashpot>(c, e, history, w);
            force_.set(i, force_[i] + f.normal*e.normal + f.tangential);
            moment_.set(i, moment_[i] - share*cross(e.normal, f.tangential));
            if (history.touching) next.push_back({wall.feature, history}), ++touching;
            if (report)
            {
                report->largestOverlap = std::max(report->largestOverlap, e.overlap/radius_[i]);
            }
        }
        candidate.histories.assign(next.begin(), next.end());
    }
    if (report) report->wallTouching = touching;
}

void SoftIntegrator::evaluate(StepWeights w, StepReport* report)
{
    const std::size_t n = id_.size();
    force_.assign(n, {});
    moment_.assign(n, {});
    evaluatePairs(w, report);
    evaluateWalls(w, report);
}

/// phi1 = (1 - exp(-z))/z, phi2 = (z - 1 + exp(-z))/z^2, series where these cancel.
static void exponentialWeights(double z, double& phi1, double& phi2)
{
    if (z < 1e-2)
    {
        phi1 = 1 - z/2*(1 - z/3*(1 - z/4*(1 - z/5*(1 - z/6))));
        phi2 = 0.5*(1 - z/3*(1 - z/4*(1 - z/5*(1 - z/6*(1 - z/7)))));
        return;
    }
    phi1 = -std::expm1(-z)/z;
    phi2 = (1 - phi1)/z;
}

void SoftIntegrator::prepareStep(double step)
{
    step_ = step;
    const std::size_t n = id_.size();
    decay_.resize(n), first_.resize(n), second_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        double phi1, phi2;
        const double z = dragRate_[i]*step;
        exponentialWeights(z, phi1, phi2);
        decay_[i] = std::exp(-z);
        first_[i] = step*phi1;
        second_[i] = step*phi2;
    }
}

/// From t to t + h: positions, predicted velocities; contact forces are those of t.
void SoftIntegrator::startStep()
{
    for (std::size_t i = 0; i < id_.size(); ++i)
    {
        const double inverse = 1/mass_[i];
        const Vector3 contact = inverse*force_[i], spinUp = 2.5*inverse*moment_[i];
        const Vector3 v = velocityBase_[i] + second_[i]*contact;
        const Vector3 total = push_[i] + contact;
        const Vector3 moved = first_[i]*v + step_*second_[i]*total;
        const Vector3 predicted = decay_[i]*v + first_[i]*total;
        if (drag_)
        {
            // m k (u h - moved), with the contact force taken as constant
            dragImpulse_.set(i, dragImpulse_[i] + mass_[i]*dragRate_[i]
                                    *(step_*gasVelocity_[i] - moved));
        }
        position_.set(i, position_[i] + moved);
        velocity_.set(i, predicted);
        velocityBase_.set(i, predicted - second_[i]*contact);
        const Vector3 s = surfaceBase_[i] + 0.5*step_*spinUp;
        surface_.set(i, s + step_*spinUp);
        surfaceBase_.set(i, s + 0.5*step_*spinUp);
    }
}

void SoftIntegrator::finish()
{
    for (std::size_t i = 0; i < id_.size(); ++i)
    {
        const double inverse = 1/mass_[i];
        velocity_.set(i, velocityBase_[i] + (second_[i]*inverse)*force_[i]);
        surface_.set(i, surfaceBase_[i] + (0.5*step_*2.5*inverse)*moment_[i]);
    }
}

void SoftIntegrator::run(Particles& particles, double duration, std::size_t subSteps,
                         StepReport& report)
{
    load(particles);
    if (id_.empty()) return;
    prepareStep(duration/double(subSteps));
    const double skin = settings_.skin > 0 ? settings_.skin
        : 0.4*(*std::min_element(radius_.begin(), radius_.end()));
    buildLists(skin);
    report.listBuilds = 1;
    evaluate({0, 0.5*step_}, &report);
    // v(t) = base + second*F/m must hold for the first step: take the force out of the base
    for (std::size_t i = 0; i < id_.size(); ++i)
    {
        velocityBase_.set(i, velocity_[i] - (second_[i]/mass_[i])*force_[i]);
        surfaceBase_.set(i, surface_[i] - (0.5*step_*2.5/mass_[i])*moment_[i]);
    }
    for (std::size_t s = 1; s <= subSteps; ++s)
    {
        startStep();
        if (!listsHold())
        {
            buildLists(skin);
            ++report.listBuilds;
        }
        evaluate({0.5*step_, s == subSteps ? 0 : 0.5*step_}, &report);
    }
    finish();
    store(particles);
    report.subSteps = subSteps;
    report.step = step_;
    report.candidates = pairs_.size();
    report.softParticles = id_.size();
}

void SoftIntegrator::contactForces(const Particles& particles, double step, VectorArray& force,
                                   VectorArray& torque)
{
    load(particles);
    force.assign(particles.size(), {});
    torque.assign(particles.size(), {});
    if (id_.empty()) return;
    buildLists(settings_.skin > 0 ? settings_.skin
        : 0.4*(*std::min_element(radius_.begin(), radius_.end())));
    evaluate({0.5*step, 0.5*step}, nullptr);
    for (std::size_t i = 0; i < id_.size(); ++i)
    {
        force.set(order_[i], force_[i]);
        torque.set(order_[i], radius_[i]*moment_[i]);
    }
}

std::vector<ContactRecord> SoftIntegrator::exportContacts() const
{
    SoftIntegrator copy(*this);
    copy.keepHistory();
    return copy.kept_;
}

void SoftIntegrator::importContacts(const std::vector<ContactRecord>& records)
{
    pairs_.clear();
    wallCandidates_.clear();
    kept_ = records;
    std::sort(kept_.begin(), kept_.end(), [](const ContactRecord& a, const ContactRecord& b)
    {
        if (a.wall != b.wall) return b.wall;
        return a.first != b.first ? a.first < b.first : a.second < b.second;
    });
}

} // namespace elutria::dem

#include "soft/SoftIntegrator.hpp"

#include "core/forEach.hpp"
#include "core/text.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace elutria::dem
{

SoftIntegrator::SoftIntegrator(const Settings& settings, const LawTables& laws, const Walls& walls,
                               Exchange& exchange)
  : settings_(settings), walls_(walls), laws_(laws), exchange_(exchange),
    contacts_(laws.pairs, settings.threads), atWalls_(laws.walls, walls), halo_(exchange)
{
    cloud_.box = settings.box;
    cloud_.threads = settings.threads;
}

// ---------------------------------------------------------------------------------- history

std::vector<ContactRecord> SoftIntegrator::exportContacts() const
{
    if (!valid_) return kept_;
    std::vector<ContactRecord> records;
    for (const LastingPair& p : contacts_.lasting())
    {
        ContactRecord r{idOf(p.first), idOf(p.second), false, {p.x, p.y, p.z}};
        if (r.first > r.second)
        {
            if (p.second >= cloud_.size()) continue;       // the other rank has it, too

            std::swap(r.first, r.second);
            r.tangential = -r.tangential;
        }
        records.push_back(r);
    }
    for (const LastingWall& w : atWalls_.lasting())
    {
        records.push_back({cloud_.id(w.particle), w.feature, true, w.displacement});
    }
    std::sort(records.begin(), records.end(), pairsFirst);
    return records;
}

void SoftIntegrator::importContacts(const std::vector<ContactRecord>& records)
{
    kept_ = records;
    std::sort(kept_.begin(), kept_.end(), pairsFirst);
    cloud_.forget();
    forgetLists();
}

/// Puts the history away under ids, before the cloud changes.
void SoftIntegrator::keep()
{
    kept_ = exportContacts();
    forgetLists();
}

/// Nothing learnt stays either: other particles come out as in a fresh integrator, to the bit.
void SoftIntegrator::forgetLists()
{
    valid_ = false;
    listBuffer_.forget(), nearBuffer_.forget();
    list_.begin.clear(), list_.second.clear();
    density_ = firstDensity;
    halo_.forget();
}

/// Gives the history put away under ids to the contact tables.
void SoftIntegrator::install()
{
    std::vector<LastingPair> pairs;
    std::vector<LastingWall> walls;
    const std::vector<std::uint32_t> byId =
        kept_.empty() ? std::vector<std::uint32_t>{} : cloud_.byId();
    for (const ContactRecord& r : kept_)
    {
        const std::uint32_t i = placeOf(byId, r.first);
        if (i == SoftCloud::none) continue;
        if (r.wall)
        {
            walls.push_back({i, r.second, r.tangential});
            continue;
        }
        const std::uint32_t j = placeOf(byId, r.second);
        if (j == SoftCloud::none || std::min(i, j) >= cloud_.size()) continue;
        const Vector3& s = r.tangential;
        pairs.push_back({i, j, float(s.x), float(s.y), float(s.z)});
    }
    kept_.clear();
    install(pairs, walls);
}

void SoftIntegrator::install(std::vector<LastingPair>& pairs, std::vector<LastingWall>& walls)
{
    forElements(settings_.threads, pairs.size(), [&](std::size_t k)
    {
        LastingPair& p = pairs[k];
        if (p.first > p.second) p = {p.second, p.first, -p.x, -p.y, -p.z};
    });
    std::sort(walls.begin(), walls.end(), [](const LastingWall& a, const LastingWall& b)
    {
        return a.particle != b.particle ? a.particle < b.particle : a.feature < b.feature;
    });
    contacts_.reset(Chunks(cloud_.size(), halo_.size()), pairs);
    atWalls_.reset(contacts_.chunks(), walls);
}

// ----------------------------------------------------------------------------------- motion

void SoftIntegrator::load(const Particles& particles, double step)
{
    step_ = step;
    double shifted = 0;
    if (exchange_.alone())
    {
        if (valid_ && !cloud_.holds(particles)) keep();
        shifted = cloud_.load(particles, step);
        cloud_.settle(cloud_.totals());
        everyone_ = cloud_.size();
    }
    else shifted = loadTogether(particles, step);
    mean_ = cloud_.frame;
    if (!valid_) return;
    if (halo_.size() > 0) halo_.fill(cloud_);
    if (!exchange_.alone()) followGhosts(0);
    measureMotion();
    for (std::size_t c = 0; c < contacts_.chunks().count(); ++c)
    {
        contacts_.forgetSums(c);
        nearBuffer_.use(c, shifted, {});
        motion_[c].wallWay += shifted;
    }
}

/// Forces on all particles; leaves those from other chunks and from walls to receive().
void SoftIntegrator::evaluate(StepWeights weights)
{
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c)
    {
        contacts_.evaluate(c, cloud_, weights);
        if (laws_.pairs.rolls()) contacts_.addRolling(c, cloud_, weights);
    });
}

void SoftIntegrator::receive(std::size_t chunk, StepWeights weights)
{
    contacts_.receive(chunk, cloud_);
    if (!atWalls_.near(chunk)) return;
    contacts_.startSums(chunk, cloud_);
    atWalls_.evaluate(chunk, cloud_, weights, time_);
}

/// base + sign*(h phi2 a): between base and velocity.
void SoftIntegrator::kick(std::size_t chunk, double sign)
{
    if (!contacts_.loaded(chunk)) return;
    for (std::size_t i = contacts_.chunks().begin(chunk); i < contacts_.chunks().end(chunk); ++i)
    {
        Base& b = cloud_.bases[i];
        const Load& l = cloud_.loads[i];
        const double second = cloud_.forcing.empty() ? 0.5*step_ : cloud_.forcing[i].second;
        const double s = sign*second*b.inverseMass, t = sign*0.5*step_*2.5*b.inverseMass;
        b.vx += s*l.fx, b.vy += s*l.fy, b.vz += s*l.fz;
        b.sx += t*l.mx, b.sy += t*l.my, b.sz += t*l.mz;
    }
}

/// First evaluation: velocities are those of the caller.
void SoftIntegrator::start()
{
    const StepWeights weights{0, 0.5*step_};
    evaluate(weights);
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c)
    {
        receive(c, weights);
        kick(c, -1);
    });
}

/// One step of all particles, after what is left of the forces at its start.
void SoftIntegrator::move(StepWeights weights, bool received)
{
    works_.resize(contacts_.chunks().count());
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c)
    {
        if (!received) receive(c, weights);
        MoveWork& w = works_[c];
        w.begin = contacts_.chunks().begin(c), w.end = contacts_.chunks().end(c);
        w.rows = cloud_.rows.data(), w.bases = cloud_.bases.data();
        w.loads = contacts_.loaded(c) ? cloud_.loads.data() : nullptr;
        w.forcing = cloud_.forcing.empty() ? nullptr : cloud_.forcing.data();
        w.step = step_;
        for (int a = 0; a < 3; ++a)
        {
            w.push[a] = cloud_.push[a], w.frame[a] = mean_[a], w.ownFrame[a] = motion_[c].frame[a];
        }
        kernels().move(w);
        contacts_.forgetSums(c);
        follow(c, w);
    });
    sum_ = {};
    for (const MoveWork& w : works_) sum_ += {w.sum[0], w.sum[1], w.sum[2]};
    sinceList_ += step_, sinceNear_ += step_;
    cloud_.frame = mean_;                  // the rows' from now on
    if (exchange_.alone()) takeMean(sum_);
    else followGhosts(step_);
}

void SoftIntegrator::takeMean(const Vector3& sum)
{
    if (!std::isfinite(squaredNorm(sum)))
    {
        throw std::runtime_error("particle motion diverged: a velocity is not finite (sub-step "
                                 + text(step_) + " s)");
    }
    mean_ = (1/double(everyone_))*sum;
}

/// Takes a chunk's step off its buffer.
void SoftIntegrator::follow(std::size_t chunk, const MoveWork& work)
{
    ChunkMotion& m = motion_[chunk];
    m.speed = std::sqrt(work.fastestInFrame);
    m.wallSpeed = std::sqrt(work.fastest);
    m.wallWay += m.wallSpeed*step_;
    nearBuffer_.use(chunk, m.speed*step_, step_*m.frame);
    m.frame = (1/double(work.end - work.begin))*Vector3{work.sum[0], work.sum[1], work.sum[2]};
}

/// Base velocities become the velocities.
void SoftIntegrator::finish()
{
    const StepWeights weights{0.5*step_, 0};
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c)
    {
        receive(c, weights);
        kick(c, 1);
    });
}

void SoftIntegrator::runAll(Particles& particles, double duration, std::size_t subSteps,
                            StepReport& report)
{
    load(particles, duration/double(subSteps));
    if (everyone_ == 0) return;
    const std::size_t rebuilds = rebuilds_;
    ensureLists();
    time_ = 0;
    start();
    for (std::size_t s = 1; s <= subSteps; ++s)
    {
        move({0.5*step_, 0.5*step_}, s == 1);
        time_ = double(s)*step_;
        ensureLists();
        evaluate({0.5*step_, s == subSteps ? 0 : 0.5*step_});
    }
    finish();
    cloud_.store(particles, duration);
    if (exchange_.rank() == 0) report.subSteps += subSteps, report.listBuilds += rebuilds_ - rebuilds;
    report.step = step_;
    report.candidates = candidates();
    report.touching = touchingHere();
    report.wallTouching = atWalls_.touching();
    report.softParticles += cloud_.size();
    report.ghosts += halo_.size();
    report.largestOverlap = std::max({report.largestOverlap, contacts_.takeLargestOverlap(),
                                      atWalls_.takeLargestOverlap()});
    report.bytes = bytes();
}

void SoftIntegrator::run(Particles& particles, double duration, std::size_t subSteps,
                         StepReport& report)
{
    if (!walls_.take())
    {
        runAll(particles, duration, subSteps, report);
        takeHits(particles, report);
        return;
    }
    Particles moving = particles;
    moving.dragImpulse = {};
    if (!particles.dragRate.empty()) particles.dragImpulse.assign(particles.size(), {});
    std::vector<std::uint32_t> place(particles.size());
    std::iota(place.begin(), place.end(), 0u);
    for (std::size_t done = 0, steps; done < subSteps; done += steps)
    {
        steps = std::min(stepsOfTaken, subSteps - done);
        StepReport part;
        runAll(moving, duration*double(steps)/double(subSteps), steps, part);
        const std::vector<bool> taken = takeHits(moving, part);
        for (std::size_t i = 0; i < moving.size(); ++i)
        {
            const std::uint32_t k = place[i];
            particles.position.set(k, moving.position[i]);
            particles.velocity.set(k, moving.velocity[i]);
            particles.spin.set(k, moving.spin[i]);
            if (!particles.dragRate.empty())
                particles.dragImpulse.set(k, particles.dragImpulse[k] + moving.dragImpulse[i]);
        }
        for (WallHit& hit : part.hits)
        {
            hit.time += duration*double(done)/double(subSteps);
            report.hits.push_back(hit);
        }
        if (done == 0) report.softParticles += moving.size(), report.ghosts += part.ghosts;
        report.subSteps += part.subSteps, report.listBuilds += part.listBuilds;
        report.step = part.step, report.candidates = part.candidates, report.bytes = part.bytes;
        report.touching = part.touching, report.wallTouching = part.wallTouching;
        report.largestOverlap = std::max(report.largestOverlap, part.largestOverlap);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < taken.size(); ++i)
            if (!taken[i]) place[kept++] = place[i];
        if (kept < place.size()) keepOnly(moving, [&](std::size_t i) { return !taken[i]; });
        place.resize(kept);
    }
}

/// What a wall has taken is put back to where that was, at the end of a run: kernels do not leave a
/// particle out. What it did in between is forgotten, but for what it gave to others. Which were taken.
std::vector<bool> SoftIntegrator::takeHits(Particles& particles, StepReport& report)
{
    std::vector<bool> taken(particles.size(), false);
    const std::vector<WallHit> hits = atWalls_.takeHits();
    if (hits.empty()) return taken;
    const std::vector<std::uint32_t> byId = cloud_.byId();
    for (const WallHit& hit : hits)
    {
        const std::uint32_t k = cloud_.caller(cloud_.find(byId, hit.id));
        if (taken[k]) continue;
        report.hits.push_back(hit);
        if (hit.answer != WallAnswer::takes) continue;
        taken[k] = true;
        particles.position.set(k, settings_.box.wrapped(hit.position));
        particles.velocity.set(k, {});
        particles.spin.set(k, {});
    }
    return taken;
}

void SoftIntegrator::contactForces(const Particles& particles, double step, VectorArray& force,
                                   VectorArray& torque)
{
    force.assign(particles.size(), {});
    torque.assign(particles.size(), {});
    load(particles, step);
    if (everyone_ == 0) return;
    ensureLists();
    const StepWeights weights{0.5*step, 0.5*step};
    evaluate(weights);
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c)
    {
        receive(c, weights);
        contacts_.startSums(c, cloud_);
        for (std::size_t i = contacts_.chunks().begin(c); i < contacts_.chunks().end(c); ++i)
        {
            const Load& l = cloud_.loads[i];
            const double r = cloud_.rows[i].radius;
            force.set(cloud_.caller(i), {l.fx, l.fy, l.fz});
            torque.set(cloud_.caller(i), {r*l.mx, r*l.my, r*l.mz});
        }
    });
}

std::size_t SoftIntegrator::bytes() const
{
    return cloud_.bytes() + 4*(list_.begin.capacity() + list_.second.capacity())
           + contacts_.bytes() + atWalls_.bytes() + kept_.capacity()*sizeof(ContactRecord)
           + works_.capacity()*sizeof(MoveWork)
           + listBuffer_.bytes() + nearBuffer_.bytes() + halo_.bytes();
}

} // namespace elutria::dem

#include "SoftIntegrator.hpp"

#include "threads.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace elutria::dem
{

namespace
{

bool before(const ContactRecord& a, const ContactRecord& b)
{
    if (a.wall != b.wall) return b.wall;
    return a.first != b.first ? a.first < b.first : a.second < b.second;
}

} // namespace

SoftIntegrator::SoftIntegrator(const Settings& settings, const ContactMaterials& materials,
                               const Walls& walls)
  : settings_(settings), walls_(walls), laws_(settings.law, materials), contacts_(laws_),
    atWalls_(laws_, walls)
{
    cloud_.box = settings.box;
}

// ---------------------------------------------------------------------------------- history

std::vector<ContactRecord> SoftIntegrator::exportContacts() const
{
    if (!valid_) return kept_;
    std::vector<ContactRecord> records;
    for (const LastingPair& p : contacts_.lasting())
    {
        ContactRecord r{cloud_.id(p.first), cloud_.id(p.second), false, {p.x, p.y, p.z}};
        if (r.first > r.second)
        {
            std::swap(r.first, r.second);
            r.tangential = -r.tangential;
        }
        records.push_back(r);
    }
    for (const LastingWall& w : atWalls_.lasting())
    {
        records.push_back({cloud_.id(w.particle), w.feature, true, w.stretch});
    }
    std::sort(records.begin(), records.end(), before);
    return records;
}

void SoftIntegrator::importContacts(const std::vector<ContactRecord>& records)
{
    kept_ = records;
    std::sort(kept_.begin(), kept_.end(), before);
    valid_ = false;
}

/// Puts the history away under ids, before the cloud changes.
void SoftIntegrator::keep()
{
    kept_ = exportContacts();
    valid_ = false;
}

/// Gives the history put away to the contact tables.
void SoftIntegrator::install()
{
    std::vector<LastingPair> pairs;
    std::vector<LastingWall> walls;
    const std::vector<std::uint32_t> byId =
        kept_.empty() ? std::vector<std::uint32_t>{} : cloud_.byId();
    for (const ContactRecord& r : kept_)
    {
        const std::uint32_t i = cloud_.find(byId, r.first);
        if (i == Cloud::none) continue;
        if (r.wall)
        {
            walls.push_back({i, r.second, r.tangential});
            continue;
        }
        const std::uint32_t j = cloud_.find(byId, r.second);
        if (j == Cloud::none) continue;
        const Vector3 s = i < j ? r.tangential : -r.tangential;
        pairs.push_back({std::min(i, j), std::max(i, j), float(s.x), float(s.y), float(s.z)});
    }
    std::sort(pairs.begin(), pairs.end(), [](const LastingPair& a, const LastingPair& b)
    {
        return a.first != b.first ? a.first < b.first : a.second < b.second;
    });
    std::sort(walls.begin(), walls.end(), [](const LastingWall& a, const LastingWall& b)
    {
        return a.particle != b.particle ? a.particle < b.particle : a.feature < b.feature;
    });
    kept_.clear();
    contacts_.reset(cloud_.size(), pairs);
    atWalls_.reset(contacts_.chunks(), walls);
}

// ------------------------------------------------------------------------------------ lists

/// Skin of the neighbour list: the least cost per sub-step of rebuilds (about 200 ns per particle)
/// and of the candidates looked through at every refresh.
double SoftIntegrator::listSkin() const
{
    if (settings_.skin > 0) return settings_.skin;
    const double radius = cloud_.mean;
    if (settings_.search == NeighbourSearch::bruteForce
        || settings_.search == NeighbourSearch::cells)
    {
        return 0.05*cloud_.smallest;
    }
    const double speed = std::max(fastestInFrame_, std::sqrt(0.2*cloud_.strongestPush*radius));
    const double way = 2*speed*step_;
    double best = 0, least = 1e300;
    for (double skin = 0.1*radius; skin <= 2*radius; skin *= 1.25)
    {
        const double reach = 1 + 0.5*skin/radius, candidates = 1.2*reach*reach*reach;
        const double nearPairs = std::sqrt(way/(0.06*radius));     // refreshes per sub-step
        const double cost = 200*way/skin + 3*candidates*std::min(1.0, nearPairs);
        if (cost < least) least = cost, best = skin;
    }
    return std::max(best, 8*way);
}

/// Margin of the near pairs: the least cost per sub-step of refreshes (about 20 ns per particle)
/// and of near pairs that do not touch.
double SoftIntegrator::nearMargin() const
{
    const double way = 2*std::max(fastestInFrame_, 1e-9)*step_;
    const double margin = std::sqrt(20*way*cloud_.mean/50);
    return std::clamp(margin, 3*way + 1e-6*cloud_.smallest, 0.5*skin_ + 3*way);
}

void SoftIntegrator::rebuild()
{
    if (valid_) keep();
    skin_ = listSkin();
    cloud_.sort(2*cloud_.mean + skin_);
    const Row* rows = cloud_.rows.data();
    const Spheres spheres{cloud_.size(), &rows->x, &rows->y, &rows->z, &rows->radius, skin_,
                          sizeof(Row)/sizeof(double)};
    findPairs(spheres, cloud_.box, settings_.search, settings_.cellLayers, settings_.threads,
              list_);
    install();
    valid_ = true;
    sinceRebuild_ = 0;
    ++rebuilds_;
    refresh();
}

void SoftIntegrator::refresh()
{
    margin_ = nearMargin();
    contacts_.refresh(cloud_, list_, margin_, settings_.threads);
    if (!walls_.empty())
    {
        wallMargin_ = std::max(0.25*cloud_.mean, 8*fastest_*step_);
        forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
        {
            atWalls_.refresh(c, cloud_, ContactTable::chunkBegin(c), contacts_.chunkEnd(c),
                             wallMargin_);
        });
        sinceWalls_ = 0;
    }
    sinceRefresh_ = 0;
    ++refreshes_;
}

/// Refreshes or rebuilds unless nothing unseen can touch after the way gone so far.
void SoftIntegrator::ensureLists()
{
    const bool everyStep = settings_.search == NeighbourSearch::bruteForce
                           || settings_.search == NeighbourSearch::cells;
    if (!valid_ || (everyStep && sinceRebuild_ > 0)) return rebuild();
    const bool wallsHold = walls_.empty() || sinceWalls_ < wallMargin_;
    if (2*sinceRefresh_ < margin_ && wallsHold) return;
    if (2*sinceRebuild_ + nearMargin() > skin_) return rebuild();
    refresh();
}

// ----------------------------------------------------------------------------------- motion

void SoftIntegrator::load(const Particles& particles, double step)
{
    step_ = step;
    if (valid_ && !cloud_.holds(particles)) keep();
    const double shifted = cloud_.load(particles, step);
    mean_ = cloud_.frame;
    double fastest2 = 0, inFrame2 = 0;
    for (std::size_t i = 0; i < cloud_.size(); ++i)
    {
        const Base& b = cloud_.bases[i];
        const Vector3 v{b.vx, b.vy, b.vz};
        fastest2 = std::max(fastest2, squaredNorm(v));
        inFrame2 = std::max(inFrame2, squaredNorm(v - cloud_.frame));
    }
    fastest_ = std::sqrt(fastest2), fastestInFrame_ = std::sqrt(inFrame2);
    if (valid_)
    {
        sinceRebuild_ += shifted;
        sinceRefresh_ += shifted;
        sinceWalls_ += shifted;
    }
}

/// Forces on all particles; leaves those from other chunks and from walls to receive().
void SoftIntegrator::evaluate(StepWeights weights)
{
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
    {
        contacts_.evaluate(c, cloud_, weights);
        if (laws_.rolls()) contacts_.addRolling(c, cloud_, weights);
    });
}

void SoftIntegrator::receive(std::size_t chunk, StepWeights weights)
{
    contacts_.receive(chunk, cloud_);
    atWalls_.evaluate(chunk, cloud_, weights);
}

/// base + sign*(h phi2 a): between base and velocity.
void SoftIntegrator::kick(std::size_t chunk, double sign)
{
    for (std::size_t i = ContactTable::chunkBegin(chunk); i < contacts_.chunkEnd(chunk); ++i)
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
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
    {
        receive(c, weights);
        kick(c, -1);
    });
}

/// One step of all particles, after what is left of the forces at its start.
void SoftIntegrator::move(StepWeights weights, bool received)
{
    works_.resize(contacts_.chunks());
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
    {
        if (!received) receive(c, weights);
        MoveWork& w = works_[c];
        w.begin = ContactTable::chunkBegin(c), w.end = contacts_.chunkEnd(c);
        w.rows = cloud_.rows.data(), w.bases = cloud_.bases.data();
        w.loads = cloud_.loads.data();
        w.forcing = cloud_.forcing.empty() ? nullptr : cloud_.forcing.data();
        w.step = step_;
        for (int a = 0; a < 3; ++a) w.push[a] = cloud_.push[a], w.frame[a] = mean_[a];
        kernels().move(w);
    });
    double fastest2 = 0, inFrame2 = 0;
    Vector3 sum;
    for (const MoveWork& w : works_)
    {
        fastest2 = std::max(fastest2, w.fastest);
        inFrame2 = std::max(inFrame2, w.fastestInFrame);
        sum += {w.sum[0], w.sum[1], w.sum[2]};
    }
    if (!std::isfinite(squaredNorm(sum)))
    {
        throw std::runtime_error("particle motion diverged: a velocity is not finite (sub-step "
                                 + std::to_string(step_) + " s)");
    }
    fastest_ = std::sqrt(fastest2), fastestInFrame_ = std::sqrt(inFrame2);
    cloud_.frame = mean_;                  // the rows' from now on
    mean_ = (1/double(cloud_.size()))*sum;
    sinceRebuild_ += fastestInFrame_*step_;
    sinceRefresh_ += fastestInFrame_*step_;
    sinceWalls_ += fastest_*step_;
}

/// Base velocities become the velocities.
void SoftIntegrator::finish()
{
    const StepWeights weights{0.5*step_, 0};
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
    {
        receive(c, weights);
        kick(c, 1);
    });
}

void SoftIntegrator::run(Particles& particles, double duration, std::size_t subSteps,
                         StepReport& report)
{
    load(particles, duration/double(subSteps));
    if (cloud_.size() == 0) return;
    const std::size_t rebuilds = rebuilds_;
    ensureLists();
    start();
    for (std::size_t s = 1; s <= subSteps; ++s)
    {
        move({0.5*step_, 0.5*step_}, s == 1);
        ensureLists();
        evaluate({0.5*step_, s == subSteps ? 0 : 0.5*step_});
    }
    finish();
    cloud_.store(particles, duration);
    report.subSteps += subSteps;
    report.step = step_;
    report.candidates = list_.size();
    report.touching = contacts_.touching();
    report.wallTouching = atWalls_.touching();
    report.softParticles += cloud_.size();
    report.listBuilds += rebuilds_ - rebuilds;
    report.largestOverlap = std::max({report.largestOverlap, contacts_.takeLargestOverlap(),
                                      atWalls_.takeLargestOverlap()});
    report.bytes = bytes();
}

void SoftIntegrator::contactForces(const Particles& particles, double step, VectorArray& force,
                                   VectorArray& torque)
{
    force.assign(particles.size(), {});
    torque.assign(particles.size(), {});
    load(particles, step);
    if (cloud_.size() == 0) return;
    ensureLists();
    const StepWeights weights{0.5*step, 0.5*step};
    evaluate(weights);
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c) { receive(c, weights); });
    for (std::size_t i = 0; i < cloud_.size(); ++i)
    {
        const Load& l = cloud_.loads[i];
        const double r = cloud_.rows[i].radius;
        force.set(cloud_.caller(i), {l.fx, l.fy, l.fz});
        torque.set(cloud_.caller(i), {r*l.mx, r*l.my, r*l.mz});
    }
}

std::size_t SoftIntegrator::bytes() const
{
    return cloud_.bytes() + 4*(list_.begin.capacity() + list_.second.capacity())
           + contacts_.bytes() + atWalls_.bytes() + kept_.capacity()*sizeof(ContactRecord)
           + works_.capacity()*sizeof(MoveWork);
}

} // namespace elutria::dem

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
    cloud_.forget();
    drift_ = {};
}

/// Puts the history away under ids, before the cloud changes.
void SoftIntegrator::keep()
{
    kept_ = exportContacts();
    valid_ = false;
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
        const std::uint32_t i = cloud_.find(byId, r.first);
        if (i == Cloud::none) continue;
        if (r.wall)
        {
            walls.push_back({i, r.second, r.tangential});
            continue;
        }
        const std::uint32_t j = cloud_.find(byId, r.second);
        if (j == Cloud::none) continue;
        const Vector3& s = r.tangential;
        pairs.push_back({i, j, float(s.x), float(s.y), float(s.z)});
    }
    kept_.clear();
    install(pairs, walls);
}

void SoftIntegrator::install(std::vector<LastingPair>& pairs, std::vector<LastingWall>& walls)
{
    for (LastingPair& p : pairs)
    {
        if (p.first > p.second) p = {p.second, p.first, -p.x, -p.y, -p.z};
    }
    std::sort(walls.begin(), walls.end(), [](const LastingWall& a, const LastingWall& b)
    {
        return a.particle != b.particle ? a.particle < b.particle : a.feature < b.feature;
    });
    contacts_.reset(cloud_.size(), pairs);
    atWalls_.reset(contacts_.chunks(), walls);
}

// ------------------------------------------------------------------------------------ lists

/// Skin of the neighbour list: the least cost per sub-step of rebuilds (about 300 ns per particle)
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
    const double speed = drift_.chunks() > 0 ? drift_.speed() : cloud_.speedRange();
    const double way = 2*std::max(speed, std::sqrt(0.2*cloud_.strongestPush*radius))*step_;
    double best = 0, least = 1e300;
    for (int k = 0; k < 14; ++k)
    {
        const double skin = 0.1*std::pow(1.25, k)*radius;
        const double reach = 1 + 0.5*skin/radius, candidates = 1.2*reach*reach*reach;
        const double refreshes = std::min(1.0, std::sqrt(way/(0.06*radius)));
        const double cost = 300*way/skin + 3*candidates*refreshes;
        if (cost < least) least = cost, best = skin;
    }
    return std::max(best, 8*way);
}

/// Margin of the near pairs: the least cost per sub-step of refreshes (about 20 ns per particle)
/// and of near pairs that do not touch.
double SoftIntegrator::nearMargin(std::size_t chunk) const
{
    const double way = 2*std::max(drift_.speed(chunk), 1e-9)*step_;
    const double margin = std::sqrt(way*cloud_.mean);
    return std::clamp(margin, 3*way + 1e-6*cloud_.smallest, 0.5*skin_ + 3*way);
}

void SoftIntegrator::rebuild()
{
    std::vector<LastingPair> pairs;
    std::vector<LastingWall> walls;
    if (valid_) pairs = contacts_.lasting(), walls = atWalls_.lasting();
    skin_ = listSkin();
    checkBox();
    const std::vector<std::uint32_t> now = cloud_.sort(2*cloud_.mean + skin_);
    const Row* rows = cloud_.rows.data();
    const Spheres spheres{cloud_.size(), &rows->x, &rows->y, &rows->z, &rows->radius, skin_,
                          sizeof(Row)/sizeof(double)};
    findPairs(spheres, cloud_.box, settings_.search, settings_.cellLayers, settings_.threads,
              list_);
    if (valid_)
    {
        for (LastingPair& p : pairs) p.first = now[p.first], p.second = now[p.second];
        for (LastingWall& w : walls) w.particle = now[w.particle];
        install(pairs, walls);
    }
    else
    {
        install();
    }
    valid_ = true;
    ++rebuilds_;
    drift_.reset(list_, cloud_.size(), ContactTable::chunkSize);
    measureSpeeds();
    margin_.resize(contacts_.chunks()), wallMargin_.resize(contacts_.chunks());
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
    {
        refresh(c);
        refreshWalls(c);
    });
    contacts_.connect();
}

/// The shortest image must be the only one in reach.
void SoftIntegrator::checkBox() const
{
    const double reach = 2*cloud_.largest + skin_;
    for (int a = 0; a < 3; ++a)
    {
        const double length = settings_.box.high[a] - settings_.box.low[a];
        if (settings_.box.periodic[a] && length < 2*reach)
        {
            throw std::invalid_argument("periodic box is " + std::to_string(length) + " m wide in "
                + "xyz"[a] + "; allowed: at least " + std::to_string(2*reach)
                + " m, twice the reach of its largest particle");
        }
    }
}

/// Speeds and frames of the chunks as the particles are now.
void SoftIntegrator::measureSpeeds()
{
    for (std::size_t c = 0; c < contacts_.chunks(); ++c)
    {
        const std::size_t begin = ContactTable::chunkBegin(c), end = contacts_.chunkEnd(c);
        Vector3 mean;
        double fastest2 = 0, inFrame2 = 0;
        for (std::size_t i = begin; i < end; ++i) mean += cloud_.velocity(i);
        mean *= 1/double(end - begin);
        for (std::size_t i = begin; i < end; ++i)
        {
            fastest2 = std::max(fastest2, squaredNorm(cloud_.velocity(i)));
            inFrame2 = std::max(inFrame2, squaredNorm(cloud_.velocity(i) - mean));
        }
        drift_.setFrame(c, mean);
        drift_.setSpeeds(c, std::sqrt(inFrame2), std::sqrt(fastest2));
    }
}

void SoftIntegrator::refresh(std::size_t chunk)
{
    margin_[chunk] = nearMargin(chunk);
    contacts_.refresh(chunk, cloud_, list_, margin_[chunk]);
    drift_.mark(chunk);
}

void SoftIntegrator::refreshWalls(std::size_t chunk)
{
    const double margin = std::max(0.25*cloud_.mean, 8*drift_.wallSpeed(chunk)*step_);
    wallMargin_[chunk] = atWalls_.refresh(chunk, cloud_, ContactTable::chunkBegin(chunk),
                                          contacts_.chunkEnd(chunk), margin);
    drift_.markWalls(chunk);
}

/// Refreshes or rebuilds what may miss a touch after the way gone so far.
void SoftIntegrator::ensureLists()
{
    const bool everyStep = settings_.search == NeighbourSearch::bruteForce
                           || settings_.search == NeighbourSearch::cells;
    if (!valid_ || everyStep) return rebuild();
    stale_.assign(contacts_.chunks(), 0);
    bool any = false;
    for (std::size_t c = 0; c < contacts_.chunks(); ++c)
    {
        if (!(drift_.sinceMark(c) < margin_[c]))
        {
            if (drift_.sinceReset(c) + nearMargin(c) > skin_) return rebuild();
            stale_[c] = 1;
            any = true;
        }
        if (!(drift_.sinceWalls(c) < wallMargin_[c])) refreshWalls(c);
    }
    if (!any) return;
    forEach(settings_.threads, contacts_.chunks(), [&](std::size_t c)
    {
        if (stale_[c]) refresh(c);
    });
    contacts_.connect();
}

// ----------------------------------------------------------------------------------- motion

void SoftIntegrator::load(const Particles& particles, double step)
{
    step_ = step;
    if (valid_ && !cloud_.holds(particles)) keep();
    const double shifted = cloud_.load(particles, step);
    mean_ = cloud_.frame;
    if (!valid_) return;
    drift_.add(shifted);
    measureSpeeds();
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
        for (int a = 0; a < 3; ++a)
        {
            w.push[a] = cloud_.push[a], w.frame[a] = mean_[a], w.ownFrame[a] = drift_.frame(c)[a];
        }
        kernels().move(w);
    });
    Vector3 sum;
    for (std::size_t c = 0; c < works_.size(); ++c)
    {
        drift_.add(c, works_[c]);
        sum += {works_[c].sum[0], works_[c].sum[1], works_[c].sum[2]};
    }
    if (!std::isfinite(squaredNorm(sum)))
    {
        throw std::runtime_error("particle motion diverged: a velocity is not finite (sub-step "
                                 + std::to_string(step_) + " s)");
    }
    cloud_.frame = mean_;                  // the rows' from now on
    mean_ = (1/double(cloud_.size()))*sum;
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
    if (report.largestOverlap > settings_.largestOverlap)
    {
        report.warnings.push_back("overlap of " + std::to_string(100*report.largestOverlap)
            + " % of the radius is above " + std::to_string(100*settings_.largestOverlap)
            + " %: the contacts are too soft for these speeds, or particles started in each other");
    }
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
           + works_.capacity()*sizeof(MoveWork)
           + drift_.bytes();
}

} // namespace elutria::dem

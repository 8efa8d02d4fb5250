// The parts of the soft integrator in which ranks talk to each other.

#include "core/forEach.hpp"
#include "parallel/Agreement.hpp"
#include "soft/SoftIntegrator.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

/// Own state and that of all; returns the largest shift of an own particle. Lists stay only where all
/// ranks have the particles they had.
double SoftIntegrator::loadTogether(const Particles& particles, double step)
{
    std::vector<double> others{valid_ && cloud_.holds(particles) ? 0.0 : 1.0};
    exchange_.sum(others);
    if (valid_ && others[0] > 0) keep();
    double shifted = 0;
    CloudTotals all;
    for (const Bytes& bytes : shareMade(exchange_, [&]
    {
        shifted = cloud_.load(particles, step);
        Outgoing out;
        out << cloud_.totals();
        return out.take();
    })) all.add(Incoming(bytes).get<CloudTotals>());
    cloud_.settle(all);
    everyone_ = all.particles;
    sum_ = cloud_.totals().velocities;
    return shifted;
}

std::uint64_t SoftIntegrator::idOf(std::uint32_t i) const
{
    return i < cloud_.size() ? cloud_.id(i) : halo_.id(i - cloud_.size());
}

/// Index of a particle or ghost in the cloud, or SoftCloud::none.
std::uint32_t SoftIntegrator::placeOf(const std::vector<std::uint32_t>& byId, std::uint64_t id) const
{
    const std::uint32_t own = cloud_.find(byId, id);
    if (own != SoftCloud::none) return own;
    const std::uint32_t ghost = halo_.find(id);
    return ghost == SoftCloud::none ? ghost : std::uint32_t(cloud_.size()) + ghost;
}

/// Pairs in the list with an own particle.
std::size_t SoftIntegrator::candidates() const
{
    return list_.begin.size() > cloud_.size() ? list_.begin[cloud_.size()] : 0;
}

/// Pairs that touch and have no rank else to count them.
std::size_t SoftIntegrator::touchingHere() const
{
    if (halo_.size() == 0) return contacts_.touching();
    const std::vector<LastingPair> lasting = contacts_.lasting();
    return std::size_t(std::count_if(lasting.begin(), lasting.end(), [&](const LastingPair& p)
    {
        return p.second < cloud_.size() || idOf(p.first) < idOf(p.second);
    }));
}

/// Contacts by the places that their particles have `now`; `ghosts`: ids by their old places.
void SoftIntegrator::rename(std::vector<LastingPair>& pairs, const Untouched<std::uint32_t>& now,
                            const std::vector<std::uint64_t>& ghosts) const
{
    const auto own = std::uint32_t(cloud_.size());
    forElements(settings_.threads, pairs.size(), [&](std::size_t k)
    {
        LastingPair& p = pairs[k];
        p.first = now[p.first];
        const std::uint32_t ghost =
            p.second < own ? 0 : halo_.find(ghosts[p.second - own]);
        p.second = p.second < own ? now[p.second] : ghost == SoftCloud::none ? ghost : own + ghost;
    });
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [](const LastingPair& p)
                               { return p.second == SoftCloud::none; }), pairs.end());
}

/// Hands records to the ranks that have their first particles.
void SoftIntegrator::handRecords()
{
    const std::vector<std::uint32_t> byId = cloud_.byId();
    std::vector<ContactRecord> own, left;
    for (const ContactRecord& record : kept_)
        (cloud_.find(byId, record.first) == SoftCloud::none ? left : own).push_back(record);
    for (const std::vector<ContactRecord>& ofRank : shareEach(exchange_, left))
        for (const ContactRecord& record : ofRank)
            if (cloud_.find(byId, record.first) != SoftCloud::none) own.push_back(record);
    std::sort(own.begin(), own.end(), pairsFirst);
    kept_ = std::move(own);
}

/// Buffers of the own particles, and the ghosts that follow from them.
void SoftIntegrator::makeHalo()
{
    if (!valid_) handRecords();
    std::vector<LastingPair> none;
    std::vector<LastingWall> noWalls;
    halo_.forget();
    install(none, noWalls);
    measureMotion();
    const Chunks own = contacts_.chunks();
    grantBuffers(0, own.count());
    const double least = 0.2*cloud_.mean, most = std::max(least, widestBuffer());
    const double interval = listInterval();
    allowance_.resize(own.count());
    for (std::size_t c = 0; c < own.count(); ++c)
        allowance_[c] = std::clamp(1.5*interval*norm(motion_[c].frame - mean_), least, most);
    halo_.make(cloud_, own, [&](std::size_t i)
    {
        return cloud_.rows[i].radius + listBuffer_.of(i) + allowance_[own.of(i)];
    }, kept_);
    const std::vector<ContactRecord> records = halo_.takeRecords();
    kept_.insert(kept_.end(), records.begin(), records.end());
    // what is in nobody's reach may go farther: even if the other does, too, they do not meet
    for (std::size_t c = 0; c < own.count(); ++c)
        if (!halo_.isNear(c, 8*most, cloud_.box)) allowance_[c] = std::max(allowance_[c], 3*most);
    wayOfAll_ = wayOfAllNear_ = {};
}

/// What is left of the buffers in the list, and of the allowances, once near pairs are chosen.
void SoftIntegrator::measureHalo(bool listIsNew)
{
    leftForNear_.resize(contacts_.chunks().count());
    for (std::size_t c = 0; c < leftForNear_.size(); ++c)
        leftForNear_[c] = allowance_[c] + (listIsNew ? 0 : listBuffer_.spare(c, wayOfAll_));
    wayOfAllNear_ = {};
}

/// Whether the list leaves room for the near pairs just chosen.
bool SoftIntegrator::haloHasRoom() const
{
    return std::all_of(leftForNear_.begin(), leftForNear_.end(), [](double l) { return l >= 0; });
}

/// True if no particle can have met one that is not its rank's ghost.
bool SoftIntegrator::haloSuffices() const
{
    if (exchange_.alone()) return true;
    for (std::size_t c = 0; c < leftForNear_.size(); ++c)
        if (!(leftForNear_[c] + nearBuffer_.spare(c, wayOfAllNear_) >= 0)) return false;
    return true;
}

/// Ghosts go where their ranks have moved them in `elapsed` s.
void SoftIntegrator::followGhosts(double elapsed)
{
    if (!valid_) return;
    wayOfAll_ += elapsed*mean_, wayOfAllNear_ += elapsed*mean_;
    halo_.fetch(cloud_);
    const Chunks& chunks = contacts_.chunks();
    for (std::size_t c = chunks.count(); c < chunks.all(); ++c)
    {
        ChunkMotion& m = motion_[c];
        const Vector3 shift = elapsed*m.frame;
        double farthest2 = 0;
        Vector3 velocities;
        for (std::size_t i = chunks.begin(c); i < chunks.end(c); ++i)
        {
            const Vector3 before = cloud_.position(i);
            cloud_.setGhost(i - cloud_.size(), halo_.incoming(i - cloud_.size()));
            const Vector3 way = cloud_.box.shortest(cloud_.position(i) - before);
            farthest2 = std::max(farthest2, squaredNorm(way - shift));
            velocities += cloud_.velocity(i);
        }
        const double way = std::sqrt(farthest2);
        nearBuffer_.use(c, way, shift);
        if (elapsed > 0) m.speed = way/elapsed;
        m.frame = (1/double(chunks.end(c) - chunks.begin(c)))*velocities;
    }
}

/// What all move by, and whether one of them wants a new list.
bool SoftIntegrator::agreeOnList(bool wanted)
{
    std::vector<double> values{wanted ? 1.0 : 0.0, sum_.x, sum_.y, sum_.z};
    exchange_.sum(values);
    takeMean({values[1], values[2], values[3]});
    return values[0] > 0;
}

} // namespace elutria::dem

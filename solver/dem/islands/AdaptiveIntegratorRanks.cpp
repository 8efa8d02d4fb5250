#include "islands/AdaptiveIntegrator.hpp"

#include "parallel/Agreement.hpp"

#include <algorithm>
#include <numeric>

// The parts of the adaptive integrator in which ranks talk to each other.

namespace elutria::dem
{

/// The particles' states, and the contacts of which an own particle is the first: where it came from
/// another rank since the last step, that one had them.
void AdaptiveIntegrator::load(const Particles& particles, bool weighted)
{
    const auto owns = [&](std::uint64_t id)
    {
        const std::vector<ParticleState>& own = states_.all();
        const auto at = std::lower_bound(own.begin(), own.end(), id,
            [](const ParticleState& s, std::uint64_t i) { return s.id < i; });
        return at != own.end() && at->id == id;
    };
    std::vector<ContactRecord> kept;
    const std::vector<Bytes> sent = shareMade(exchange_, [&]
    {
        states_.load(particles, weighted);
        if (exchange_.alone()) return Bytes{};
        std::vector<ContactRecord> left;
        for (const ContactRecord& record : contacts_.records())
            (owns(record.first) ? kept : left).push_back(record);
        Outgoing out;
        out << left;
        return out.take();
    });
    if (exchange_.alone()) return;
    for (const Bytes& bytes : sent)
        for (const ContactRecord& record : Incoming(bytes).get<std::vector<ContactRecord>>())
            if (owns(record.first)) kept.push_back(record);
    contacts_ = SortedContacts(std::move(kept));
}


bool AdaptiveIntegrator::flyFreely(const Piece& piece)
{
    if (exchange_.alone()) return dem::flyFreely(piece, settings_, flights_);
    fly(piece, settings_, 0, flights_);
    flights_.frame = all_.velocity;
    if (settings_.box.any())
    {
        // Whether paths fit the box is decided by it: as one rank finds it
        Vector3 sum;
        for (const Vector3& ofRank : shareEach(exchange_, sumOfWays(piece, flights_))) sum += ofRank;
        flights_.frame = (1/(piece.duration*double(all_.particles)))*sum;
    }
    const bool fits = bound(piece, settings_, 0, flights_);
    return ghosts_.announce(flights_.bounds, fits ? 0 : 1) == 0;
}


/// Candidates of own particles, those with ghosts apart; and the overlaps of all.
void AdaptiveIntegrator::findAmongRanks(const Piece& piece, StepReport& report)
{
    std::vector<ParticleState>& all = states_.all();
    const std::size_t own = all.size();
    std::vector<ParticleState> ghosts;
    std::vector<ContactRecord> contacts;
    ghosts_.fetch(piece, flights_.bounds, ghosts, contacts);
    report.ghosts += ghosts.size();
    SortedContacts withGhosts;
    const bool more = !contacts.empty();
    if (more)
    {
        contacts.insert(contacts.end(), contacts_.records().begin(), contacts_.records().end());
        withGhosts = SortedContacts(std::move(contacts));
    }
    all.insert(all.end(), ghosts.begin(), ghosts.end());
    const Piece wider{all, more ? withGhosts : contacts_, piece.duration, piece.seed, piece.work,
                      ghosts.size()};
    fly(wider, settings_, own, flights_);
    bound(wider, settings_, own, flights_);
    search_.find(wider, flights_, candidates_);
    overlaps_ = overlapsOfAll(exchange_, all, own, candidates_.overlaps);

    acrossRanks_.clear();
    const auto isGhost = [&](std::uint32_t i) { return i >= own; };
    const auto isAcross = [&](const Pair& pair)
    {
        const bool across = isGhost(pair.first) || isGhost(pair.second);
        if (across) acrossRanks_.push_back({all[pair.first].id, all[pair.second].id});
        return across;
    };
    std::vector<Pair>& pairs = candidates_.pairs;
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), isAcross), pairs.end());
    std::vector<std::uint32_t>& touching = candidates_.touching;
    touching.erase(std::remove_if(touching.begin(), touching.end(), isGhost), touching.end());
    all.resize(own);
    flights_.resize(own);
}


void AdaptiveIntegrator::separateOverlaps()
{
    std::vector<ParticleState>& own = states_.all();
    if (exchange_.alone()) return separate(own, candidates_.overlaps, walls_, settings_.box);
    separate(overlaps_.particles, overlaps_.overlaps, walls_, settings_.box);
    for (const ParticleState& moved : overlaps_.particles)
    {
        const auto at = std::lower_bound(own.begin(), own.end(), moved.id,
            [](const ParticleState& s, std::uint64_t i) { return s.id < i; });
        if (at != own.end() && at->id == moved.id) at->flight.position = moved.flight.position;
    }
}


/// All islands, and which of them are due; returns the size of the largest without lasting contacts.
std::size_t AdaptiveIntegrator::formIslands()
{
    partition(states_.size(), candidates_, partition_);
    std::size_t largest = partition_.largestWithoutContacts();
    toStep_.resize(partition_.islands.size());
    std::iota(toStep_.begin(), toStep_.end(), 0u);
    if (exchange_.alone()) return largest;

    shared_.clear();
    const auto joined = shared_.join(acrossRanks_, largest, states_.all(), partition_);
    if (!joined.pairs) return joined.largest;
    dropShared();
    largest = shared_.largestWithoutContacts();
    std::size_t own = 0;
    for (const std::uint32_t k : toStep_)
        if (!partition_.islands[k].touching)
            own = std::max(own, partition_.islands[k].particles.size());
    for (const std::size_t ofRank : shareEach(exchange_, own)) largest = std::max(largest, ofRank);
    return largest;
}


/// Islands that are shared, or merged into others, are not stepped as own ones.
void AdaptiveIntegrator::dropShared()
{
    toStep_.erase(std::remove_if(toStep_.begin(), toStep_.end(), [&](std::uint32_t k)
    {
        return partition_.islands[k].particles.empty() || shared_.nameOf(k) != SharedIslands::none;
    }), toStep_.end());
}


bool AdaptiveIntegrator::mergeWhatMeetsAmongRanks(const Piece& piece, StepReport& report)
{
    std::vector<std::uint32_t> stepped = toStep_;
    const std::vector<std::uint32_t> due = shared_.due();
    stepped.insert(stepped.end(), due.begin(), due.end());
    const std::vector<Pair> hits = pathCheck_.find(piece, partition_, results_, stepped,
                                                   flights_.frame, flights_.bounds);
    if (ghosts_.announce(flights_.bounds, pathCheck_.changed().size()) == 0) return false;

    const auto nameOf = [&](std::uint32_t i)
    {
        return partition_.isFree(i) ? SharedIslands::none : shared_.nameOf(partition_.islandOf[i]);
    };
    Path free;
    const auto path = [&](std::uint32_t i) -> const Path&
    {
        return pathOf(i, piece, partition_, results_, free);
    };
    std::vector<IdPair> across = pathCheck_.meetGhosts(piece, partition_, results_, shared_,
        ghosts_.fetchPaths(piece, pathCheck_.changed(), flights_.bounds, path, nameOf),
        flights_.frame, flights_.bounds);
    std::vector<Pair> own;
    for (const Pair& hit : hits)
        if (nameOf(hit.first) == SharedIslands::none && nameOf(hit.second) == SharedIslands::none)
            own.push_back(hit);
        else across.push_back({piece.start[hit.first].id, piece.start[hit.second].id});
    toStep_ = partition_.merge(own, report.mergedIslands);
    const auto joined =
        shared_.join(across, own.size(), states_.all(), partition_, &report.mergedIslands);
    results_.resize(partition_.islands.size());
    dropShared();
    return joined.pairs || joined.largest > 0;
}

} // namespace elutria::dem

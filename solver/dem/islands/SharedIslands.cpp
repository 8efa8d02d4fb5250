#include "islands/SharedIslands.hpp"

#include "core/DisjointSets.hpp"
#include "parallel/Message.hpp"

#include <algorithm>
#include <numeric>

namespace elutria::dem
{

namespace
{

/// Place of a number in an ascending list that holds it.
std::uint32_t placeOf(std::uint64_t number, const std::vector<std::uint64_t>& ascending)
{
    return std::uint32_t(std::lower_bound(ascending.begin(), ascending.end(), number)
                         - ascending.begin());
}

/// Place of a particle by ascending id, or as many as there are.
std::size_t placeOf(std::uint64_t id, const std::vector<ParticleState>& own)
{
    const auto at = std::lower_bound(own.begin(), own.end(), id,
        [](const ParticleState& s, std::uint64_t i) { return s.id < i; });
    return at != own.end() && at->id == id ? std::size_t(at - own.begin()) : own.size();
}

} // namespace


std::size_t SharedIslands::SharedIsland::size() const
{
    return std::accumulate(members.begin(), members.end(), std::size_t(0));
}


std::uint64_t SharedIslands::nameOf(std::size_t ownIsland) const
{
    return ownIsland < sharedOf_.size() && sharedOf_[ownIsland] != nowhere
        ? islands_[sharedOf_[ownIsland]].name : none;
}


std::size_t SharedIslands::largestWithoutContacts() const
{
    std::size_t largest = 0;
    for (const SharedIsland& island : islands_)
        if (!island.touching) largest = std::max(largest, island.size());
    return largest;
}


std::vector<std::uint32_t> SharedIslands::due() const
{
    std::vector<std::uint32_t> own;
    for (const SharedIsland& island : islands_)
        if (island.due && island.ownIsland != nowhere) own.push_back(island.ownIsland);
    return own;
}


bool SharedIslands::hasDue() const
{
    return std::any_of(islands_.begin(), islands_.end(),
                       [](const SharedIsland& island) { return island.due; });
}


SharedIslands::Joined SharedIslands::join(const std::vector<IdPair>& pairs, std::size_t number,
                                          const std::vector<ParticleState>& own,
                                          IslandPartition& partition, std::size_t* mergedAway)
{
    for (SharedIsland& island : islands_) island.due = false;
    Outgoing out;
    out << number << pairs;
    Joined joined{false, 0};
    std::vector<IdPair> all;
    for (const Bytes& bytes : exchange_.share(out.take()))
    {
        Incoming in(bytes);
        joined.largest = std::max(joined.largest, in.get<std::size_t>());
        const auto theirs = in.get<std::vector<IdPair>>();
        all.insert(all.end(), theirs.begin(), theirs.end());
    }
    joined.pairs = !all.empty();
    if (!joined.pairs) return joined;
    const std::size_t merged =
        combine(all, dem::joined(shareEach(exchange_, ownEnds(all, own, partition))), partition);
    if (mergedAway && exchange_.rank() == 0) *mergedAway += merged;
    return joined;
}


/// Free particles get islands of their own.
std::vector<SharedIslands::End> SharedIslands::ownEnds(const std::vector<IdPair>& pairs,
                                                       const std::vector<ParticleState>& own,
                                                       IslandPartition& partition) const
{
    std::vector<End> ends;
    for (const IdPair& pair : pairs)
        for (const std::uint64_t id : {pair.first, pair.second})
        {
            const auto i = std::uint32_t(placeOf(id, own));
            if (i == own.size()) continue;
            if (partition.isFree(i))
            {
                partition.islands.emplace_back();
                partition.add(i, std::uint32_t(partition.islands.size() - 1));
            }
            const std::uint32_t k = partition.islandOf[i];
            const Island& island = partition.islands[k];
            const std::uint64_t shared = nameOf(k);
            ends.push_back({id, shared != none ? shared : own[island.particles[0]].id,
                            std::uint32_t(island.particles.size()), k, island.touching,
                            exchange_.rank()});
        }
    return ends;
}


/// The islands that are connected by the pairs become one each. Returns how many others they were.
std::size_t SharedIslands::combine(const std::vector<IdPair>& pairs, const std::vector<End>& ends,
                                   IslandPartition& partition)
{
    std::vector<std::uint64_t> ids;
    for (const IdPair& pair : pairs) ids.insert(ids.end(), {pair.first, pair.second});
    for (const End& end : ends) ids.push_back(end.island);
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    DisjointSets sets(ids.size());
    for (const IdPair& pair : pairs) sets.join(placeOf(pair.first, ids), placeOf(pair.second, ids));
    for (const End& end : ends) sets.join(placeOf(end.particle, ids), placeOf(end.island, ids));

    const std::vector<SharedIsland> parts = takeParts(ids, ends);
    const std::size_t kept = islands_.size();
    std::vector<std::uint32_t> wholeOf(ids.size(), nowhere);     // of each set, in islands_
    std::vector<Pair> ownPairs;
    for (const SharedIsland& part : parts)
        unite(part, wholeOf[sets.root(placeOf(part.name, ids))], partition, ownPairs);
    results_.resize(islands_.size());
    mergeOwn(ownPairs, partition);
    return parts.size() - (islands_.size() - kept);
}


/// The islands that have one of the ids, each once, by name: those that were shared, which are taken
/// from the others, and those that were of one rank.
std::vector<SharedIslands::SharedIsland> SharedIslands::takeParts(
    const std::vector<std::uint64_t>& ids, const std::vector<End>& ends)
{
    std::vector<SharedIsland> parts, others;
    std::vector<IslandResult> results;
    std::vector<std::uint64_t> shared;
    for (const SharedIsland& island : islands_) shared.push_back(island.name);
    std::sort(shared.begin(), shared.end());
    for (std::size_t k = 0; k < islands_.size(); ++k)
        if (std::binary_search(ids.begin(), ids.end(), islands_[k].name)) parts.push_back(islands_[k]);
        else
        {
            others.push_back(islands_[k]);
            results.push_back(std::move(results_[k]));
        }
    islands_ = std::move(others), results_ = std::move(results);
    for (const End& end : ends)
    {
        if (std::binary_search(shared.begin(), shared.end(), end.island)) continue;
        SharedIsland part{end.island, std::vector<std::uint32_t>(exchange_.ranks(), 0),
                          end.touching, true, end.rank,
                          end.rank == exchange_.rank() ? end.ownIsland : nowhere};
        part.members[end.rank] = end.members;
        parts.push_back(std::move(part));
    }
    std::sort(parts.begin(), parts.end(),
              [](const SharedIsland& a, const SharedIsland& b) { return a.name < b.name; });
    parts.erase(std::unique(parts.begin(), parts.end(),
                            [](const SharedIsland& a, const SharedIsland& b)
                            { return a.name == b.name; }), parts.end());
    return parts;
}


/// Adds the part to the island at `whole`, which it makes where there is none. Own islands that become
/// one are told by a particle of each.
void SharedIslands::unite(const SharedIsland& part, std::uint32_t& whole,
                          const IslandPartition& partition, std::vector<Pair>& ownPairs)
{
    if (whole == nowhere)
    {
        whole = std::uint32_t(islands_.size());
        islands_.push_back(part);
        islands_.back().due = true;
        return;
    }
    SharedIsland& island = islands_[whole];
    island.touching = island.touching || part.touching;
    for (std::size_t r = 0; r < island.members.size(); ++r) island.members[r] += part.members[r];
    if (part.ownIsland == nowhere) return;
    if (island.ownIsland == nowhere) island.ownIsland = part.ownIsland;
    else ownPairs.push_back({partition.islands[island.ownIsland].particles[0],
                             partition.islands[part.ownIsland].particles[0]});
}


/// Merges own islands, finds each shared one's again, and says who steps it.
void SharedIslands::mergeOwn(const std::vector<Pair>& ownPairs, IslandPartition& partition)
{
    std::vector<std::uint32_t> first(islands_.size(), nowhere);   // an own particle of each
    for (std::size_t k = 0; k < islands_.size(); ++k)
        if (islands_[k].ownIsland != nowhere)
            first[k] = partition.islands[islands_[k].ownIsland].particles[0];
    std::size_t noCount = 0;
    partition.merge(ownPairs, noCount);
    sharedOf_.assign(partition.islands.size(), nowhere);
    for (std::size_t k = 0; k < islands_.size(); ++k)
    {
        SharedIsland& island = islands_[k];
        island.stepper = int(std::max_element(island.members.begin(), island.members.end())
                             - island.members.begin());
        if (first[k] == nowhere) continue;
        island.ownIsland = partition.islandOf[first[k]];
        sharedOf_[island.ownIsland] = std::uint32_t(k);
    }
}


void SharedIslands::gather(const Piece& piece, const IslandPartition& partition)
{
    if (!hasDue()) return;
    std::vector<Outgoing> toEach(exchange_.ranks());
    for (std::uint32_t k = 0; k < islands_.size(); ++k)
    {
        if (!islands_[k].due || islands_[k].ownIsland == nowhere) continue;
        std::vector<ParticleState> states;
        std::vector<ContactRecord> contacts;
        for (const std::uint32_t i : partition.islands[islands_[k].ownIsland].particles)
        {
            states.push_back(piece.start[i]);
            piece.history.copy(piece.start[i].id, contacts);
        }
        toEach[islands_[k].stepper] << k << states << contacts;
    }
    struct Member { std::uint32_t island; int rank; ParticleState state; };
    std::vector<Member> members;
    history_.clear();
    const std::vector<Bytes> all = exchange_.swap(taken(toEach));
    for (std::size_t r = 0; r < all.size(); ++r)
        for (Incoming in(all[r]); !in.atEnd();)
        {
            const auto island = in.get<std::uint32_t>();
            for (const ParticleState& s : in.get<std::vector<ParticleState>>())
                members.push_back({island, int(r), s});
            const auto contacts = in.get<std::vector<ContactRecord>>();
            history_.insert(history_.end(), contacts.begin(), contacts.end());
        }
    std::sort(members.begin(), members.end(), [](const Member& a, const Member& b)
              { return a.state.id < b.state.id; });
    start_.clear(), rankOf_.clear();
    members_.assign(islands_.size(), {});
    for (const Member& m : members)
    {
        members_[m.island].particles.push_back(std::uint32_t(start_.size()));
        members_[m.island].touching = islands_[m.island].touching;
        start_.push_back(m.state), rankOf_.push_back(m.rank);
    }
    duration_ = piece.duration, seed_ = piece.seed, work_ = piece.work;
}


void SharedIslands::run()
{
    if (!hasDue()) return;
    std::vector<std::uint32_t> which;
    for (std::uint32_t k = 0; k < islands_.size(); ++k)
        if (islands_[k].due && islands_[k].stepper == exchange_.rank()) which.push_back(k);
    const SortedContacts history(history_);
    steppers_.run({start_, history, duration_, seed_, work_}, members_, which, results_);
}


void SharedIslands::sendHome(std::vector<IslandResult>& results)
{
    if (!hasDue()) return;
    std::vector<Outgoing> toEach(exchange_.ranks());
    for (std::uint32_t k = 0; k < islands_.size(); ++k)
        if (islands_[k].due && islands_[k].stepper == exchange_.rank())
            for (std::size_t r = 0; r < toEach.size(); ++r)
                if (islands_[k].members[r] > 0) pack(k, int(r), toEach[r]);
    for (const Bytes& bytes : exchange_.swap(taken(toEach)))
        for (Incoming in(bytes); !in.atEnd();)
        {
            const SharedIsland& island = islands_[in.get<std::uint32_t>()];
            IslandResult& result = results[island.ownIsland];
            result = {};
            in >> result.contacts >> result.hits;
            const std::size_t members = island.members[exchange_.rank()];
            result.end.resize(members), result.paths.resize(members);
            for (std::size_t p = 0; p < members; ++p) in >> result.end[p] >> result.paths[p];
        }
}


/// Of an island that was stepped here: what has happened to the rank's members.
void SharedIslands::pack(std::uint32_t k, int rank, Outgoing& out) const
{
    const auto isIts = [&](std::uint64_t id) { return rankOf_[placeOf(id, start_)] == rank; };
    const IslandResult& result = results_[k];
    std::vector<ContactRecord> contacts;
    for (const ContactRecord& record : result.contacts)
        if (isIts(record.first)) contacts.push_back(record);
    std::vector<WallHit> hits;
    for (const WallHit& hit : result.hits)
        if (isIts(hit.id)) hits.push_back(hit);
    out << k << contacts << hits;
    const std::vector<std::uint32_t>& members = members_[k].particles;
    for (std::size_t p = 0; p < members.size(); ++p)
        if (rankOf_[members[p]] == rank) out << result.end[p] << result.paths[p];
}

} // namespace elutria::dem

#include "soft/Halo.hpp"

#include "parallel/Message.hpp"

#include <algorithm>
#include <cstring>

namespace elutria::dem
{

namespace
{

/// Appends the pairs of which the particle is the first.
void copyPairs(const std::vector<ContactRecord>& history, std::uint64_t particle,
               std::vector<ContactRecord>& to)
{
    auto at = std::lower_bound(history.begin(), history.end(), particle,
                               [](const ContactRecord& r, std::uint64_t id)
                               { return !r.wall && r.first < id; });
    for (; at != history.end() && !at->wall && at->first == particle; ++at) to.push_back(*at);
}

} // namespace


void Halo::forget()
{
    hulls_.clear(), extents_.clear(), sent_.clear(), partners_.clear();
    ghosts_.clear(), byId_.clear(), records_.clear(), incoming_.clear();
}


/// Tells all where the own particles are.
void Halo::announce(const std::vector<Bound>& bounds, const Chunks& chunks)
{
    hulls_ = shareEach(exchange_, Hull(bounds));
    extents_.resize(chunks.count());
    for (std::size_t c = 0; c < extents_.size(); ++c)
    {
        Vector3 low{1e300, 1e300, 1e300}, high = -low;
        for (std::size_t i = chunks.begin(c); i < chunks.end(c); ++i)
            for (int a = 0; a < 3; ++a)
            {
                low[a] = std::min(low[a], bounds[i].centre[a] - bounds[i].reach);
                high[a] = std::max(high[a], bounds[i].centre[a] + bounds[i].reach);
            }
        extents_[c] = {0.5*(low + high), 0.5*(high - low)};
    }
}


/// Which own particles each other rank gets.
void Halo::choose(const std::vector<Bound>& bounds, const Chunks& chunks, const PeriodicBox& space)
{
    sent_.assign(exchange_.ranks(), {});
    for (std::size_t r = 0; r < sent_.size(); ++r)
    {
        if (int(r) == exchange_.rank()) continue;
        for (std::size_t c = 0; c < chunks.count(); ++c)
        {
            if (!hulls_[r].touches(extents_[c], space)) continue;
            for (std::size_t i = chunks.begin(c); i < chunks.end(c); ++i)
                if (hulls_[r].touches(bounds[i], space)) sent_[r].push_back(std::uint32_t(i));
        }
    }
}


void Halo::make(SoftCloud& cloud, const Chunks& chunks, const std::vector<Bound>& bounds,
                const std::vector<ContactRecord>& history)
{
    announce(bounds, chunks);
    choose(bounds, chunks, cloud.box);
    std::vector<Outgoing> toEach(exchange_.ranks());
    for (std::size_t r = 0; r < toEach.size(); ++r)
    {
        if (sent_[r].empty()) continue;
        std::vector<Sent> sent;
        std::vector<ContactRecord> known;
        for (const std::uint32_t i : sent_[r])
        {
            sent.push_back({cloud.rows[i], {cloud.id(i), cloud.material(i), std::uint8_t(
                            !cloud.weighted.empty() && cloud.weighted[i])}});
            copyPairs(history, cloud.id(i), known);
        }
        toEach[r] << sent << known;
    }
    receive(cloud, exchange_.swap(taken(toEach)));
}


void Halo::receive(SoftCloud& cloud, const std::vector<Bytes>& messages)
{
    ghosts_.clear(), records_.clear(), partners_.clear();
    std::vector<Row> rows;
    for (std::size_t r = 0; r < messages.size(); ++r)
    {
        const std::size_t before = ghosts_.size();
        if (!messages[r].empty())
        {
            Incoming in(messages[r]);
            for (const Sent& sent : in.get<std::vector<Sent>>())
                rows.push_back(sent.row), ghosts_.push_back(sent.ghost);
            const auto known = in.get<std::vector<ContactRecord>>();
            records_.insert(records_.end(), known.begin(), known.end());
        }
        const std::size_t received = ghosts_.size() - before;
        if (received > 0 || !sent_[r].empty())
            partners_.push_back({int(r), Bytes(sent_[r].size()*sizeof(Row)),
                                 Bytes(received*sizeof(Row))});
    }
    incoming_.resize(size());
    byId_.clear();
    for (std::size_t g = 0; g < size(); ++g) byId_.emplace_back(ghosts_[g].id, std::uint32_t(g));
    std::sort(byId_.begin(), byId_.end());
    fill(cloud);
    for (std::size_t g = 0; g < size(); ++g) cloud.setGhost(g, rows[g]);
}


void Halo::fill(SoftCloud& cloud) const
{
    cloud.resizeGhosts(size());
    for (std::size_t g = 0; g < size(); ++g)
    {
        if (!cloud.materials.empty()) cloud.materials[cloud.size() + g] = ghosts_[g].material;
        if (!cloud.weighted.empty()) cloud.weighted[cloud.size() + g] = ghosts_[g].weighted;
    }
}


void Halo::fetch(const SoftCloud& cloud)
{
    for (Exchange::Partner& partner : partners_)
    {
        char* to = partner.sent.data();
        for (const std::uint32_t i : sent_[partner.rank])
        {
            std::memcpy(to, &cloud.rows[i], sizeof(Row));
            to += sizeof(Row);
        }
    }
    exchange_.swapWith(partners_);
    auto* to = reinterpret_cast<char*>(incoming_.data());
    for (const Exchange::Partner& partner : partners_)
    {
        if (partner.received.empty()) continue;
        std::memcpy(to, partner.received.data(), partner.received.size());
        to += partner.received.size();
    }
}


std::uint32_t Halo::find(std::uint64_t id) const
{
    const auto at = std::lower_bound(byId_.begin(), byId_.end(), std::make_pair(id, 0u));
    return at != byId_.end() && at->first == id ? at->second : SoftCloud::none;
}


bool Halo::isNear(std::size_t chunk, double distance, const PeriodicBox& space) const
{
    Hull::Box wide = extents_[chunk];
    wide.half += Vector3{distance, distance, distance};
    for (std::size_t r = 0; r < hulls_.size(); ++r)
        if (int(r) != exchange_.rank() && hulls_[r].touches(wide, space)) return true;
    return false;
}


std::size_t Halo::bytes() const
{
    std::size_t sum = size()*(sizeof(Ghost) + sizeof(byId_[0]) + sizeof(Row));
    for (const std::vector<std::uint32_t>& list : sent_) sum += 4*list.capacity();
    for (const Exchange::Partner& partner : partners_)
        sum += partner.sent.capacity() + partner.received.capacity();
    return sum;
}

} // namespace elutria::dem

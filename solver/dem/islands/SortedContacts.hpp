#pragma once

#include "core/ContactRecord.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// Contact records by ascending first, second, pairs before walls: those of a particle are found
/// without a look at the others.
class SortedContacts
{
public:
    SortedContacts() = default;
    explicit SortedContacts(std::vector<ContactRecord> records) : records_(std::move(records))
    {
        std::sort(records_.begin(), records_.end(), before);
    }

    const std::vector<ContactRecord>& records() const { return records_; }

    /// True for a contact of these two particles, given in any order.
    bool holdsPair(std::uint64_t a, std::uint64_t b) const
    {
        const ContactRecord pair{std::min(a, b), std::max(a, b), false, {}};
        return std::binary_search(records_.begin(), records_.end(), pair, before);
    }
    /// True for a contact of this particle with any wall.
    bool holdsWall(std::uint64_t particle) const
    {
        auto at = begin(particle);
        while (at != records_.end() && at->first == particle && !at->wall) ++at;
        return at != records_.end() && at->first == particle;
    }
    /// Appends the contacts of which this particle is the first.
    void copy(std::uint64_t particle, std::vector<ContactRecord>& to) const
    {
        for (auto at = begin(particle); at != records_.end() && at->first == particle; ++at)
            to.push_back(*at);
    }
    /// Contacts counted once for each particle they hold.
    std::size_t ends() const
    {
        std::size_t ends = 0;
        for (const ContactRecord& record : records_) ends += record.wall ? 1 : 2;
        return ends;
    }

private:
    static bool before(const ContactRecord& a, const ContactRecord& b)
    {
        if (a.first != b.first) return a.first < b.first;
        return a.second != b.second ? a.second < b.second : a.wall < b.wall;
    }
    std::vector<ContactRecord>::const_iterator begin(std::uint64_t particle) const
    {
        return std::lower_bound(records_.begin(), records_.end(),
                                ContactRecord{particle, 0, false, {}}, before);
    }

    std::vector<ContactRecord> records_;
};

} // namespace elutria::dem

#include "neighbours/PairSearch.hpp"

#include "core/Grouping.hpp"
#include "core/Untouched.hpp"
#include "neighbours/CellGrid.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

std::vector<Pair> PairList::pairs() const
{
    std::vector<Pair> all;
    all.reserve(second.size());
    for (std::uint32_t i = 0; i + 1 < begin.size(); ++i)
    {
        for (std::uint32_t k = begin[i]; k < begin[i + 1]; ++k) all.push_back({i, second[k]});
    }
    return all;
}

namespace
{

/// Pairs as they are found; grows without a test for each.
class Found
{
public:
    void push_back(const Pair& pair) { *room(1) = pair, ++count_; }

    /// Where up to `most` pairs may be put; then take() those that were.
    Pair* room(std::size_t most)
    {
        if (count_ + most > pairs_.size()) pairs_.resize(2*count_ + most + 64);
        return pairs_.data() + count_;
    }
    void take(std::size_t count) { count_ += count; }
    /// Forgets the pairs; about so many will come.
    void expect(std::size_t count)
    {
        count_ = 0;
        pairs_.reserve(count);
    }

    const Pair* begin() const { return pairs_.data(); }
    const Pair* end() const { return pairs_.data() + count_; }

private:
    Untouched<Pair> pairs_;
    std::size_t count_ = 0;
};

bool neighbours(const Spheres& s, const PeriodicBox& box, std::size_t i, std::size_t j)
{
    const double reach = s.reach(i) + s.reach(j);
    return squaredNorm(box.shortest(s.position(i) - s.position(j))) < reach*reach;
}

void bruteForce(const Spheres& s, const PeriodicBox& box, Found& found)
{
    for (std::uint32_t i = 0; i < s.size; ++i)
    {
        for (std::uint32_t j = i + 1; j < s.size; ++j)
        {
            if (neighbours(s, box, i, j)) found.push_back({i, j});
        }
    }
}

struct Entry
{
    double x, y, z, reach;
    std::uint32_t index;
};

/// Box around the centres, and the reaches.
struct Extent
{
    Vector3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};      // m
    double smallest = 1e300, largest = 0;                                // m

    void add(const Extent& e)
    {
        for (int a = 0; a < 3; ++a)
            low[a] = std::min(low[a], e.low[a]), high[a] = std::max(high[a], e.high[a]);
        smallest = std::min(smallest, e.smallest), largest = std::max(largest, e.largest);
    }
};

Extent extentOf(const Spheres& s, unsigned threads)
{
    Extent all;
    for (const Extent& part : forBlocks(threads, s.size, [&](std::size_t first, std::size_t last)
    {
        Extent here;
        for (std::size_t i = first; i < last; ++i)
            here.add({s.position(i), s.position(i), s.reach(i), s.reach(i)});
        return here;
    })) all.add(part);
    return all;
}

} // namespace

/// Grids, from that of the largest spheres on, with what lies in them.
struct SearchGrids
{
    std::vector<Grid> levels;
    std::vector<std::uint32_t> levelBegin;     // in entries
    Untouched<Entry> entries;                  // by level, then cell, there in any order
    Untouched<std::uint32_t> begin;            // of each cell, in entries
    Untouched<std::uint32_t> cell;             // of each sphere
    std::vector<Found> found;                  // by each thread

    void make(const Spheres& s, const PeriodicBox& box, bool hierarchical, int layers);

private:
    void sort(const Spheres& s, const PeriodicBox& box);
};

/// Grids of doubling cell width, or a single one.
void SearchGrids::make(const Spheres& s, const PeriodicBox& box, bool hierarchical, int layers)
{
    const auto threads = unsigned(found.size());
    const Extent extent = extentOf(s, threads);
    const auto levelOf = [&](double reach)
    {
        return hierarchical ? std::min(20, std::ilogb(extent.largest/reach + 1e-9)) : 0;
    };
    levels.assign(levelOf(extent.smallest) + 1, {});
    cell.resize(s.size);
    const auto parts = forBlocks(threads, s.size, [&](std::size_t first, std::size_t last)
    {
        std::vector<Grid> part(levels.size());
        for (std::size_t i = first; i < last; ++i)
        {
            Grid& level = part[cell[i] = levelOf(s.reach(i))];
            level.largestReach = std::max(level.largestReach, s.reach(i));
            ++level.spheres;
        }
        return part;
    });
    std::size_t cells = 0;
    levelBegin.assign(1, 0);
    for (std::size_t l = 0; l < levels.size(); ++l)
    {
        Grid& level = levels[l];
        for (const std::vector<Grid>& part : parts)
        {
            level.largestReach = std::max(level.largestReach, part[l].largestReach);
            level.spheres += part[l].spheres;
        }
        level.firstCell = cells;
        if (level.spheres > 0) level.shape(box, extent.low, extent.high, 2*level.largestReach/layers);
        if (level.spheres > 0) cells += level.size();
        levelBegin.push_back(levelBegin.back() + std::uint32_t(level.spheres));
    }
    begin.resize(cells + 2);
    forElements(threads, begin.size(), [&](std::size_t c) { begin[c] = 0; });
    sort(s, box);
}

void SearchGrids::sort(const Spheres& s, const PeriodicBox& box)
{
    // shifted by two: once the entries are placed, begin[c] is where those of c begin
    const unsigned threads = threadsFor(s.size, unsigned(found.size()));
    forElements(threads, s.size, [&](std::size_t i)
    {
        cell[i] = std::uint32_t(levels[cell[i]].cellOf(box.wrapped(s.position(i))));
        addOne(begin[cell[i] + 2], threads > 1);
    });
    sumUp(threads, begin);
    entries.resize(s.size);
    forElements(threads, s.size, [&](std::size_t i)
    {
        const Vector3 x = box.wrapped(s.position(i));
        entries[addOne(begin[cell[i] + 1], threads > 1)] =
            {x.x, x.y, x.z, s.reach(i), std::uint32_t(i)};
    });
}

namespace
{

/// Pairs of entry `e` with entries [from, to).
inline void compare(const Entry& e, const Entry* from, const Entry* to, const PeriodicBox& box,
                    bool wraps, Found& found)
{
    Pair* const room = found.room(std::size_t(to - from));
    std::size_t count = 0;
    for (const Entry* f = from; f != to; ++f)
    {
        Vector3 d{e.x - f->x, e.y - f->y, e.z - f->z};
        if (wraps) d = box.shortest(d);
        const double reach = e.reach + f->reach;
        room[count] = {std::min(e.index, f->index), std::max(e.index, f->index)};
        count += squaredNorm(d) < reach*reach;      // no branch: it would be guessed wrongly
    }
    found.take(count);
}

/// Pairs of the level's entries [from, to) with each other and with all smaller spheres. The large
/// look for the small: they are fewer, and the small ones' cells hold few that are out of reach.
void searchLevel(const SearchGrids& grids, std::size_t level, std::size_t from, std::size_t to,
                 const PeriodicBox& box, Found& found)
{
    const bool wraps = box.any();
    const Entry* const entries = grids.entries.data();
    const std::uint32_t* const begin = grids.begin.data();
    const Grid& own = grids.levels[level];
    for (auto k = std::uint32_t(from); k < to; ++k)
    {
        const Entry& e = entries[k];
        const Vector3 x{e.x, e.y, e.z};
        const auto visit = [&](std::uint32_t first, std::uint32_t last)
        {
            if (first < last) compare(e, entries + first, entries + last, box, wraps, found);
        };
        const auto after = [&](std::uint32_t first, std::uint32_t last)
        {
            visit(std::max(first, k + 1), last);
        };
        if (own.halves) own.behind(k, x, e.reach + own.largestReach, begin, visit);
        else own.around(x, e.reach + own.largestReach, begin, after);
        for (std::size_t l = level + 1; l < grids.levels.size(); ++l)
        {
            const Grid& smaller = grids.levels[l];
            if (smaller.spheres > 0) smaller.around(x, e.reach + smaller.largestReach, begin, visit);
        }
    }
}

void gridSearch(const Spheres& s, const PeriodicBox& box, bool hierarchical, int layers,
                SearchGrids& grids)
{
    grids.make(s, box, hierarchical, layers);
    const std::size_t threads = grids.found.size();
    forEach(unsigned(threads), threads, [&](std::size_t t)
    {
        for (std::size_t l = 0; l < grids.levels.size(); ++l)
        {
            const std::size_t first = grids.levelBegin[l], n = grids.levels[l].spheres;
            searchLevel(grids, l, first + n*t/threads, first + n*(t + 1)/threads, box,
                        grids.found[t]);
        }
    });
}

/// Pairs of sphere i with all others; of two that are asked the first finds the pair.
void searchAround(const SearchGrids& grids, const std::vector<char>& isAsked, const Spheres& s,
                  std::uint32_t i, const PeriodicBox& box, Found& found)
{
    const Vector3 x = box.wrapped(s.position(i));
    const Entry own{x.x, x.y, x.z, s.reach(i), i};
    for (const Grid& level : grids.levels)
    {
        if (level.spheres == 0) continue;
        level.around(x, own.reach + level.largestReach, grids.begin.data(),
                     [&](std::uint32_t first, std::uint32_t last)
        {
            for (const Entry* f = &grids.entries[first]; first < last; ++first, ++f)
            {
                if (f->index == i || (isAsked[f->index] && f->index < i)) continue;
                const Vector3 d = box.shortest({own.x - f->x, own.y - f->y, own.z - f->z});
                const double reach = own.reach + f->reach;
                if (squaredNorm(d) < reach*reach)
                    found.push_back({std::min(i, f->index), std::max(i, f->index)});
            }
        });
    }
}

/// Pairs in any order to lists by first, ascending.
void sortPairs(const std::vector<Found>& found, std::size_t n, PairList& list)
{
    // shifted by two: once the pairs are placed, begin[i] is where those of i begin
    const auto threads = unsigned(found.size());
    list.begin.resize(n + 2);
    forElements(threads, n + 2, [&](std::size_t i) { list.begin[i] = 0; });
    std::size_t size = 0;
    for (const Found& part : found) size += std::size_t(part.end() - part.begin());
    forEach(threads, found.size(), [&](std::size_t t)
    {
        for (const Pair& pair : found[t]) addOne(list.begin[pair.first + 2], threads > 1);
    });
    sumUp(threads, list.begin);
    list.second.resize(size);
    forEach(threads, found.size(), [&](std::size_t t)
    {
        for (const Pair& pair : found[t])
            list.second[addOne(list.begin[pair.first + 1], threads > 1)] = pair.second;
    });
    list.begin.resize(n + 1);
    forElements(threads, n, [&](std::size_t i)
    {
        std::sort(list.second.begin() + list.begin[i], list.second.begin() + list.begin[i + 1]);
    });
}

} // namespace

PairSearch::PairSearch() : grids_(std::make_unique<SearchGrids>()) {}

PairSearch::~PairSearch() = default;

void PairSearch::start(unsigned threads, const PairList& list)
{
    std::vector<Found>& found = grids_->found;
    found.resize(std::max(1u, threads));
    for (Found& part : found) part.expect(list.size()/found.size());
}

void PairSearch::find(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
                      int cellLayers, unsigned threads, PairList& list)
{
    start(threads, list);
    std::vector<Found>& found = grids_->found;
    if (method == NeighbourSearch::bruteForce)
    {
        bruteForce(spheres, box, found[0]);
    }
    else if (spheres.size > 1)
    {
        const bool hierarchical =
            method == NeighbourSearch::hierarchical || method == NeighbourSearch::automatic;
        gridSearch(spheres, box, hierarchical,
                   method == NeighbourSearch::cells ? cellLayers : 1, *grids_);
    }
    sortPairs(found, spheres.size, list);
}

void PairSearch::findWith(const std::vector<std::uint32_t>& asked, const Spheres& spheres,
                          const PeriodicBox& box, unsigned threads, PairList& list)
{
    start(threads, list);
    std::vector<Found>& found = grids_->found;
    isAsked_.assign(spheres.size, 0);
    for (const std::uint32_t i : asked) isAsked_[i] = 1;
    if (spheres.size > 1)
    {
        grids_->make(spheres, box, true, 1);
        forEach(unsigned(found.size()), found.size(), [&](std::size_t t)
        {
            const std::size_t n = asked.size(), parts = found.size();
            for (std::size_t k = n*t/parts; k < n*(t + 1)/parts; ++k)
                searchAround(*grids_, isAsked_, spheres, asked[k], box, found[t]);
        });
    }
    sortPairs(found, spheres.size, list);
}

std::vector<Pair> findPairs(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
                            int cellLayers)
{
    PairList list;
    PairSearch().find(spheres, box, method, cellLayers, 1, list);
    return list.pairs();
}

} // namespace elutria::dem

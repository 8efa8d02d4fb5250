#include "search.hpp"

#include "threads.hpp"

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

    const Pair* begin() const { return pairs_.data(); }
    const Pair* end() const { return pairs_.data() + count_; }

private:
    std::vector<Pair> pairs_;
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

/// A grid of cells over some of the spheres, which it keeps sorted by cell, x fastest.
class Grid
{
public:
    struct Entry
    {
        double x, y, z, reach;
        std::uint32_t index, cell;
    };

    std::vector<Entry> entries;
    double largestReach = 0;

    void add(const Spheres& s, const PeriodicBox& box, std::uint32_t i)
    {
        const Vector3 x = box.wrapped(s.position(i));
        entries.push_back({x.x, x.y, x.z, s.reach(i), i, 0});
        largestReach = std::max(largestReach, s.reach(i));
    }

    /// Cells at least `width` wide, wider where the grid would outgrow its particles.
    void build(const PeriodicBox& box, double width)
    {
        Vector3 low{1e300, 1e300, 1e300}, high = -low;
        for (const Entry& e : entries)
        {
            low = {std::min(low.x, e.x), std::min(low.y, e.y), std::min(low.z, e.z)};
            high = {std::max(high.x, e.x), std::max(high.y, e.y), std::max(high.z, e.z)};
        }
        for (int a = 0; a < 3; ++a)
        {
            periodic_[a] = box.periodic[a];
            if (periodic_[a]) low[a] = box.low[a], high[a] = box.high[a];
        }
        low_ = low;
        length_ = high - low;
        for (;; width *= 1.26)
        {
            double count = 1;
            for (int a = 0; a < 3; ++a) count *= std::max(1.0, std::floor(length_[a]/width));
            if (count <= 2.0*double(entries.size()) + 64) break;
        }
        for (int a = 0; a < 3; ++a)
        {
            cells_[a] = std::max(1, int(length_[a]/width));
            inverse_[a] = length_[a] > 0 ? cells_[a]/length_[a] : 0;
        }
        sortByCell();
    }

    /// Calls visit(begin, end) for runs of entries, among them all within `reach` of x.
    template<class Visit>
    void around(const Vector3& x, double reach, const Visit& visit) const
    {
        int from[3], to[3];
        for (int a = 0; a < 3; ++a)
        {
            // limited before they become integers: particles may lie in a plane but for rounding
            const double first = std::floor((x[a] - reach - low_[a])*inverse_[a]);
            const double last = std::floor((x[a] + reach - low_[a])*inverse_[a]);
            from[a] = int(std::max(first, -1.0*cells_[a]));
            to[a] = int(std::min(last, 2.0*cells_[a]));
            if (!periodic_[a]) from[a] = std::max(from[a], 0), to[a] = std::min(to[a], cells_[a] - 1);
            else if (to[a] - from[a] >= cells_[a]) from[a] = 0, to[a] = cells_[a] - 1;
        }
        for (int cz = from[2]; cz <= to[2]; ++cz)
        {
            for (int cy = from[1]; cy <= to[1]; ++cy)
            {
                const std::size_t row =
                    (std::size_t(wrapped(2, cz))*cells_[1] + wrapped(1, cy))*cells_[0];
                for (int cx = from[0]; cx <= to[0];)
                {
                    const int start = wrapped(0, cx);
                    const int run = std::min(to[0] - cx, cells_[0] - 1 - start);
                    visit(begin_[row + start], begin_[row + start + run + 1]);
                    cx += run + 1;
                }
            }
        }
    }

private:
    int wrapped(int a, int c) const
    {
        return c < 0 ? c + cells_[a] : c >= cells_[a] ? c - cells_[a] : c;
    }

    std::uint32_t cellOf(const Entry& e) const
    {
        const double x[3] = {e.x, e.y, e.z};
        std::size_t cell = 0;
        for (int a = 2; a >= 0; --a)
        {
            const int c = std::clamp(int((x[a] - low_[a])*inverse_[a]), 0, cells_[a] - 1);
            cell = cell*cells_[a] + c;
        }
        return std::uint32_t(cell);
    }

    void sortByCell()
    {
        begin_.assign(std::size_t(cells_[0])*cells_[1]*cells_[2] + 1, 0);
        for (Entry& e : entries)
        {
            e.cell = cellOf(e);
            ++begin_[e.cell + 1];
        }
        for (std::size_t c = 0; c + 1 < begin_.size(); ++c) begin_[c + 1] += begin_[c];
        std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
        std::vector<Entry> sorted(entries.size());
        for (const Entry& e : entries) sorted[next[e.cell]++] = e;
        entries.swap(sorted);
    }

    bool periodic_[3];
    Vector3 low_, length_;
    int cells_[3];
    double inverse_[3];
    std::vector<std::uint32_t> begin_;
};

/// Pairs of entry `e` with entries [begin, end) of a grid.
inline void compare(const Grid::Entry& e, const Grid::Entry* begin, const Grid::Entry* end,
                    const PeriodicBox& box, bool wraps, Found& found)
{
    Pair* const room = found.room(std::size_t(end - begin));
    std::size_t count = 0;
    for (const Grid::Entry* f = begin; f != end; ++f)
    {
        Vector3 d{e.x - f->x, e.y - f->y, e.z - f->z};
        if (wraps) d = box.shortest(d);
        const double reach = e.reach + f->reach;
        room[count] = {std::min(e.index, f->index), std::max(e.index, f->index)};
        count += squaredNorm(d) < reach*reach;      // no branch: it would be guessed wrongly
    }
    found.take(count);
}

/// Pairs of entries [from, to) of one grid with the grid's own entries (each once) or with all
/// entries of a grid of larger spheres.
void searchRange(const Grid& own, const Grid& other, std::size_t from, std::size_t to,
                 const PeriodicBox& box, Found& found)
{
    const bool same = &own == &other, wraps = box.any();
    const Grid::Entry* entries = other.entries.data();
    for (std::size_t k = from; k < to; ++k)
    {
        const Grid::Entry& e = own.entries[k];
        const std::uint32_t after = same ? std::uint32_t(k) + 1 : 0;
        other.around({e.x, e.y, e.z}, e.reach + other.largestReach,
            [&](std::uint32_t begin, std::uint32_t end)
            {
                begin = std::max(begin, after);
                if (begin < end) compare(e, entries + begin, entries + end, box, wraps, found);
            });
    }
}

/// Grids of doubling cell width, or a single one.
std::vector<Grid> makeGrids(const Spheres& s, const PeriodicBox& box, bool hierarchical,
                            int layers)
{
    double smallest = 1e300, largest = 0;
    for (std::size_t i = 0; i < s.size; ++i)
    {
        smallest = std::min(smallest, s.reach(i));
        largest = std::max(largest, s.reach(i));
    }
    const auto levelOf = [&](double reach)
    {
        return hierarchical ? std::min(20, int(std::floor(std::log2(largest/reach) + 1e-9))) : 0;
    };
    std::vector<Grid> levels(levelOf(smallest) + 1);
    for (std::uint32_t i = 0; i < s.size; ++i) levels[levelOf(s.reach(i))].add(s, box, i);
    levels.erase(std::remove_if(levels.begin(), levels.end(),
                                [](const Grid& g) { return g.entries.empty(); }), levels.end());
    for (Grid& grid : levels) grid.build(box, 2*grid.largestReach/layers);
    return levels;
}

void gridSearch(const Spheres& s, const PeriodicBox& box, bool hierarchical, int layers,
                unsigned threads, std::vector<Found>& found)
{
    const std::vector<Grid> levels = makeGrids(s, box, hierarchical, layers);
    found.resize(threads);
    forEach(threads, threads, [&](std::size_t t)
    {
        for (std::size_t l = 0; l < levels.size(); ++l)
        {
            const std::size_t n = levels[l].entries.size();
            for (std::size_t larger = 0; larger <= l; ++larger)
            {
                searchRange(levels[l], levels[larger], n*t/threads, n*(t + 1)/threads, box,
                            found[t]);
            }
        }
    });
}

/// Pairs in any order to lists by first, ascending.
void sortPairs(const std::vector<Found>& found, std::size_t n, PairList& list)
{
    list.begin.assign(n + 1, 0);
    for (const Found& part : found)
    {
        for (const Pair& pair : part) ++list.begin[pair.first + 1];
    }
    for (std::size_t i = 0; i < n; ++i) list.begin[i + 1] += list.begin[i];
    std::vector<std::uint32_t> next(list.begin.begin(), list.begin.end() - 1);
    list.second.resize(list.begin[n]);
    for (const Found& part : found)
    {
        for (const Pair& pair : part) list.second[next[pair.first]++] = pair.second;
    }
    for (std::size_t i = 0; i < n; ++i)
    {
        std::sort(list.second.begin() + list.begin[i], list.second.begin() + list.begin[i + 1]);
    }
}

} // namespace

void findPairs(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
               int cellLayers, unsigned threads, PairList& list)
{
    std::vector<Found> found(1);
    if (method == NeighbourSearch::bruteForce)
    {
        bruteForce(spheres, box, found[0]);
    }
    else if (spheres.size > 1)
    {
        const bool hierarchical =
            method == NeighbourSearch::hierarchical || method == NeighbourSearch::automatic;
        gridSearch(spheres, box, hierarchical,
                   method == NeighbourSearch::cells ? cellLayers : 1, threads, found);
    }
    sortPairs(found, spheres.size, list);
}

void findPairs(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
               int cellLayers, std::vector<Pair>& pairs)
{
    PairList list;
    findPairs(spheres, box, method, cellLayers, 1, list);
    pairs = list.pairs();
}

} // namespace elutria::dem

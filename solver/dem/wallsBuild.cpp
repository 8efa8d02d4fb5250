#include "DisjointSets.hpp"
#include "walls.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <unordered_map>

namespace elutria::dem
{

namespace
{

constexpr double weldTolerance = 1e-9;         // of the walls' extent
constexpr double cellsPerTriangle = 512, fewestCells = 1 << 13, mostCells = 1 << 18;
constexpr std::uint32_t leafSize = 4;

/// Gives points closer than a tolerance the same number; periodic images are the same point.
class Welder
{
public:
    Welder(const PeriodicBox& box, double tolerance) : box_(box), tolerance_(tolerance) {}

    std::uint32_t number(Vector3 p)
    {
        p = box_.wrapped(p);
        for (int axis = 0; axis < 3; ++axis)
            if (box_.periodic[axis] && box_.high[axis] - p[axis] <= tolerance_)
                p[axis] = box_.low[axis];

        std::uint32_t result = static_cast<std::uint32_t>(points_.size());
        forCellsAround(p, [&](std::uint64_t cell)
        {
            const auto [begin, end] = cells_.equal_range(cell);
            for (auto it = begin; it != end; ++it)
                if (norm(box_.shortest(points_[it->second] - p)) <= tolerance_)
                    result = std::min(result, it->second);
        });
        if (result == points_.size())
        {
            points_.push_back(p);
            cells_.emplace(hash(p), result);
        }
        return result;
    }

private:
    std::uint64_t hash(const Vector3& p) const
    {
        std::uint64_t value = 0;
        for (int axis = 0; axis < 3; ++axis)
        {
            const auto cell = static_cast<std::int64_t>(std::floor(p[axis]/(8*tolerance_)));
            value = (value ^ static_cast<std::uint64_t>(cell))*0x9e3779b97f4a7c15ull;
            value ^= value >> 29;
        }
        return value;
    }

    template<class Visit>
    void forCellsAround(const Vector3& p, Visit visit) const
    {
        std::uint64_t visited[8];
        int count = 0;
        for (int corner = 0; corner < 8; ++corner)
        {
            Vector3 q = p;
            for (int axis = 0; axis < 3; ++axis)
                q[axis] += (corner >> axis & 1) ? tolerance_ : -tolerance_;
            const std::uint64_t cell = hash(q);
            if (std::find(visited, visited + count, cell) != visited + count) continue;
            visited[count++] = cell;
            visit(cell);
        }
    }

    const PeriodicBox& box_;
    double tolerance_;
    std::vector<Vector3> points_;
    std::unordered_multimap<std::uint64_t, std::uint32_t> cells_;
};


/// Lower envelope of the parabolas f(j) + (i-j)^2 h^2 (Felzenszwalb & Huttenlocher 2012), along one
/// line of a grid; a periodic line is laid out three times.
void distanceTransform(std::vector<double>& line, double spacing, bool periodic)
{
    const std::size_t length = line.size();
    std::vector<double> f = line;
    if (periodic)
    {
        f.insert(f.end(), line.begin(), line.end());
        f.insert(f.end(), line.begin(), line.end());
    }
    std::vector<std::size_t> apex;
    std::vector<double> from;
    for (std::size_t j = 0; j < f.size(); ++j)
    {
        if (f[j] >= 1e300) continue;
        double start = -1e300;
        while (!apex.empty())
        {
            const double a = static_cast<double>(apex.back()), b = static_cast<double>(j);
            start = 0.5*((f[j] - f[apex.back()])/(spacing*spacing)/(b - a) + a + b);
            if (start > from.back()) break;
            apex.pop_back(), from.pop_back();
            start = -1e300;
        }
        apex.push_back(j), from.push_back(start);
    }
    if (apex.empty()) return;
    const std::size_t offset = periodic ? length : 0;
    std::size_t k = 0;
    for (std::size_t i = 0; i < length; ++i)
    {
        const double position = static_cast<double>(i + offset);
        while (k + 1 < apex.size() && from[k + 1] < position) ++k;
        const double away = (position - static_cast<double>(apex[k]))*spacing;
        line[i] = f[apex[k]] + away*away;
    }
}

bool finite(const Vector3& p)
{
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

} // namespace


Walls::Walls(WallGeometry geometry, PeriodicBox box)
    : geometry_(std::move(geometry)), box_(box)
{
    check();
    buildTriangles();
    if (order_.empty()) { triangles_.clear(); return; }
    buildTopology();
    nodes_.reserve(order_.size());
    buildTree(0, static_cast<std::uint32_t>(order_.size()));
    buildGrid();
}


void Walls::check() const
{
    const std::size_t points = geometry_.points.size();
    if (geometry_.material.size() != geometry_.triangles.size())
        throw std::invalid_argument("walls: " + std::to_string(geometry_.triangles.size())
            + " triangles but " + std::to_string(geometry_.material.size()) + " materials");
    for (std::size_t i = 0; i < points; ++i)
        if (!finite(geometry_.points[i]))
            throw std::invalid_argument("walls: point " + std::to_string(i) + " is not finite");
    for (std::size_t i = 0; i < geometry_.triangles.size(); ++i)
        for (const std::uint32_t point : geometry_.triangles[i])
            if (point >= points)
                throw std::invalid_argument("walls: triangle " + std::to_string(i)
                    + " names point " + std::to_string(point) + ", there are "
                    + std::to_string(points));
    for (int axis = 0; axis < 3; ++axis)
        if (box_.periodic[axis] && !(box_.high[axis] > box_.low[axis]))
            throw std::invalid_argument("walls: the periodic box is empty along axis "
                + std::to_string(axis));
}


/// A triangle without area touches nothing: it keeps its number and is never looked up.
void Walls::buildTriangles()
{
    triangles_.resize(geometry_.triangles.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i)
    {
        Triangle& t = triangles_[i];
        const auto& corners = geometry_.triangles[i];
        t.corner = geometry_.points[corners[0]];
        t.side1 = geometry_.points[corners[1]] - t.corner;
        t.side2 = geometry_.points[corners[2]] - t.corner;
        t.material = geometry_.material[i];
        t.normal = cross(t.side1, t.side2);
        const double area = norm(t.normal);
        t.sound = area > 1e-12*(squaredNorm(t.side1) + squaredNorm(t.side2));
        if (!t.sound) continue;
        t.normal *= 1/area;
        order_.push_back(i);
    }
}


void Walls::buildTopology()
{
    Vector3 low = triangles_[order_[0]].corner, high = low;
    for (const Vector3& p : geometry_.points)
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    const double tolerance = weldTolerance*norm(high - low);

    struct Adjacent { std::uint32_t triangle; Vector3 inward; };
    struct Outgoing { std::uint32_t edge; Vector3 direction; };
    std::vector<std::vector<Adjacent>> adjacent;
    std::vector<std::vector<Outgoing>> outgoing;
    std::vector<std::uint32_t> someTriangle;            // at each vertex

    // An edge is known by its middle and its ends: its ends alone may be each other's images.
    Welder vertexNumbers(box_, tolerance), middleNumbers(box_, tolerance);
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> edgeNumbers;
    for (const std::uint32_t i : order_)
    {
        Triangle& t = triangles_[i];
        const Vector3 corner[3] = {t.corner, t.corner + t.side1, t.corner + t.side2};
        for (int k = 0; k < 3; ++k) t.vertex[k] = vertexNumbers.number(corner[k]);
        for (int k = 0; k < 3; ++k)
        {
            const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
            const Vector3 from = corner[k], to = corner[(k + 1) % 3];
            const std::uint32_t middle = middleNumbers.number(0.5*(from + to));
            const auto [it, isNew] = edgeNumbers.try_emplace(
                {std::min(v, w), std::max(v, w), middle},
                static_cast<std::uint32_t>(adjacent.size()));
            t.edge[k] = it->second;
            const Vector3 along = (1/norm(to - from))*(to - from);
            if (std::max(v, w) >= outgoing.size())
            {
                outgoing.resize(std::max(v, w) + 1);
                someTriangle.resize(outgoing.size(), i);
            }
            if (isNew)
            {
                adjacent.emplace_back();
                outgoing[v].push_back({it->second, along});
                outgoing[w].push_back({it->second, -along});
            }
            adjacent[it->second].push_back({i, cross(t.normal, along)});
        }
    }

    const auto bend = [](const Vector3& a, const Vector3& b)      // of two directions, 0 if opposite
    {
        return std::atan2(norm(cross(a, b)), -dot(a, b));
    };
    DisjointSets surfaces(triangles_.size()), planes(triangles_.size()), runs(adjacent.size());
    for (const auto& sides : adjacent)
        for (std::size_t a = 0; a < sides.size(); ++a)
            for (std::size_t b = a + 1; b < sides.size(); ++b)
            {
                const double angle = bend(sides[a].inward, sides[b].inward);
                if (angle < smoothAngle) surfaces.join(sides[a].triangle, sides[b].triangle);
                if (angle < 1e-6) planes.join(sides[a].triangle, sides[b].triangle);
            }
    for (const std::uint32_t i : order_)
    {
        triangles_[i].surface = surfaces.root(i);
        triangles_[i].plane = planes.root(i);
    }

    const auto smooth = [&](std::uint32_t edge)
    {
        const auto& sides = adjacent[edge];
        return sides.size() > 1 && std::all_of(sides.begin(), sides.end(), [&](const Adjacent& s)
        {
            return triangles_[s.triangle].surface == triangles_[sides[0].triangle].surface;
        });
    };
    std::vector<std::vector<Outgoing>> sharp(outgoing.size());
    for (std::size_t v = 0; v < outgoing.size(); ++v)
    {
        std::copy_if(outgoing[v].begin(), outgoing[v].end(), std::back_inserter(sharp[v]),
                     [&](const Outgoing& o) { return !smooth(o.edge); });
        if (sharp[v].size() == 2
            && bend(sharp[v][0].direction, sharp[v][1].direction) < smoothAngle)
            runs.join(sharp[v][0].edge, sharp[v][1].edge);
    }

    const std::uint64_t runKind = std::uint64_t(2) << 32, cornerKind = std::uint64_t(3) << 32;
    for (std::uint32_t e = 0; e < adjacent.size(); ++e)
    {
        const auto begin = static_cast<std::uint32_t>(inward_.size());
        for (const Adjacent& side : adjacent[e]) inward_.push_back(side.inward);
        const std::uint64_t key = smooth(e)
            ? surfaceKey(triangles_[adjacent[e][0].triangle].surface) : runKind + runs.root(e);
        edges_.push_back({begin, static_cast<std::uint32_t>(inward_.size()), key});
    }
    for (std::uint32_t v = 0; v < outgoing.size(); ++v)
    {
        const auto begin = static_cast<std::uint32_t>(outgoing_.size());
        for (const Outgoing& o : outgoing[v]) outgoing_.push_back(o.direction);
        const bool onRun = sharp[v].size() == 2
            && runs.root(sharp[v][0].edge) == runs.root(sharp[v][1].edge);
        const std::uint64_t key =
            sharp[v].empty() ? surfaceKey(triangles_[someTriangle[v]].surface)
            : onRun ? runKind + runs.root(sharp[v][0].edge) : cornerKind + v;
        vertices_.push_back({begin, static_cast<std::uint32_t>(outgoing_.size()), key});
    }
}


/// Boxes are halved at the median along their longest side; the first child follows its parent.
std::uint32_t Walls::buildTree(std::uint32_t begin, std::uint32_t end)
{
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}, begin, end, true});
    for (std::uint32_t i = begin; i < end; ++i)
    {
        const Triangle& t = triangles_[order_[i]];
        for (const Vector3& p : {t.corner, t.corner + t.side1, t.corner + t.side2})
            for (int axis = 0; axis < 3; ++axis)
            {
                nodes_[index].low[axis] = std::min(nodes_[index].low[axis], p[axis]);
                nodes_[index].high[axis] = std::max(nodes_[index].high[axis], p[axis]);
            }
    }
    if (end - begin <= leafSize) return index;

    const Vector3 extent = nodes_[index].high - nodes_[index].low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
        : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin)/2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b)
    {
        const auto centre = [&](const Triangle& t)
        {
            return 3*t.corner[axis] + t.side1[axis] + t.side2[axis];
        };
        const double ca = centre(triangles_[a]), cb = centre(triangles_[b]);
        return ca != cb ? ca < cb : a < b;
    });
    buildTree(begin, middle);
    const std::uint32_t right = buildTree(middle, end);
    nodes_[index].begin = right;
    nodes_[index].leaf = false;
    return index;
}


/// The distance of a cell's centre from the walls, less half the cell's diagonal, bounds the distance
/// of any point of the cell from below.
void Walls::buildGrid()
{
    gridLow_ = nodes_[0].low, gridHigh_ = nodes_[0].high;
    const double margin = 1e-3*norm(gridHigh_ - gridLow_);
    double volume = 1;
    for (int axis = 0; axis < 3; ++axis)
    {
        gridLow_[axis] = box_.periodic[axis] ? box_.low[axis] : gridLow_[axis] - margin;
        gridHigh_[axis] = box_.periodic[axis] ? box_.high[axis] : gridHigh_[axis] + margin;
        volume *= gridHigh_[axis] - gridLow_[axis];
    }
    const double wanted =
        std::clamp(cellsPerTriangle*double(order_.size()), fewestCells, mostCells);
    const double size = std::cbrt(volume/wanted);
    std::size_t cells = 1;
    Vector3 spacing;
    for (int axis = 0; axis < 3; ++axis)
    {
        const double length = gridHigh_[axis] - gridLow_[axis];
        gridCells_[axis] = static_cast<std::uint32_t>(std::clamp(length/size, 1.0, 1024.0));
        cells *= gridCells_[axis];
        gridInverse_[axis] = gridCells_[axis]/length;
        spacing[axis] = length/gridCells_[axis];
    }
    std::vector<double> distances = squaredDistances();
    const double diagonal = norm(spacing)*(1 + 1e-9);
    for (std::size_t i = 0; i < cells; ++i)
    {
        const std::size_t x = i % gridCells_[0], y = i/gridCells_[0] % gridCells_[1],
                          z = i/gridCells_[0]/gridCells_[1];
        const Vector3 centre = gridLow_ + Vector3{(double(x) + 0.5)*spacing.x,
                                                  (double(y) + 0.5)*spacing.y,
                                                  (double(z) + 0.5)*spacing.z};
        const double guess = std::sqrt(distances[i]);
        distances[i] = guess < 6*diagonal ? distanceNear(centre, guess + 0.5*diagonal)
                                          : guess - 0.5*diagonal;
    }
    boundUnit_ = std::max(*std::max_element(distances.begin(), distances.end()), diagonal)/255;
    bound_.resize(cells);
    for (std::size_t i = 0; i < cells; ++i)
        bound_[i] = static_cast<std::uint8_t>(
            std::max(0.0, distances[i] - 0.5*diagonal)/boundUnit_);
}


/// Distance to the walls, known to be at most `guess`.
double Walls::distanceNear(const Vector3& position, double guess) const
{
    thread_local std::vector<Image> around;
    around.clear();
    const Vector3 reach{guess, guess, guess};
    collectBox(position - reach, position + reach, around);
    double nearest = guess;
    for (const Image& image : around)
        nearest = std::min(nearest, norm(position - nearestPoint(image, position)));
    return nearest;
}


/// Squared distances from each cell's centre to that of the nearest cell that a triangle crosses; the
/// wall itself is within half a diagonal of the latter.
std::vector<double> Walls::squaredDistances() const
{
    const auto& n = gridCells_;
    const Vector3 spacing{1/gridInverse_.x, 1/gridInverse_.y, 1/gridInverse_.z};
    const double halfDiagonal = 0.5*norm(spacing)*(1 + 1e-9);
    const std::size_t stride[3] = {1, n[0], std::size_t(n[0])*n[1]};
    std::vector<double> squared(stride[2]*n[2], 1e300);

    for (const std::uint32_t i : order_)
    {
        const Triangle& t = triangles_[i];
        long first[3], last[3];
        for (int axis = 0; axis < 3; ++axis)
        {
            const double a = t.corner[axis], b = a + t.side1[axis], c = a + t.side2[axis];
            const double low = (std::min({a, b, c}) - gridLow_[axis])*gridInverse_[axis];
            const double high = (std::max({a, b, c}) - gridLow_[axis])*gridInverse_[axis];
            first[axis] = static_cast<long>(std::floor(low - 1e-6));
            last[axis] = static_cast<long>(std::floor(high + 1e-6));
        }
        for (long z = first[2]; z <= last[2]; ++z)
            for (long y = first[1]; y <= last[1]; ++y)
                for (long x = first[0]; x <= last[0]; ++x)
                {
                    const Vector3 centre{gridLow_.x + (x + 0.5)*spacing.x,
                                         gridLow_.y + (y + 0.5)*spacing.y,
                                         gridLow_.z + (z + 0.5)*spacing.z};
                    if (std::abs(dot(t.normal, centre - t.corner)) > halfDiagonal) continue;
                    if (norm(centre - foot(t, centre).point) > halfDiagonal) continue;
                    const long cell[3] = {x, y, z};
                    std::size_t index = 0;
                    for (int axis = 0; axis < 3; ++axis)
                    {
                        const long count = n[axis];
                        index += stride[axis]*(box_.periodic[axis]
                            ? ((cell[axis] % count) + count) % count
                            : std::clamp(cell[axis], 0l, count - 1));
                    }
                    squared[index] = 0;
                }
    }
    for (int axis = 0; axis < 3; ++axis)
    {
        std::vector<double> line(n[axis]);
        for (std::size_t i = 0; i < squared.size(); ++i)
        {
            if (i/stride[axis] % n[axis] != 0) continue;
            for (std::size_t k = 0; k < line.size(); ++k) line[k] = squared[i + k*stride[axis]];
            distanceTransform(line, spacing[axis], box_.periodic[axis]);
            for (std::size_t k = 0; k < line.size(); ++k) squared[i + k*stride[axis]] = line[k];
        }
    }
    return squared;
}

} // namespace elutria::dem

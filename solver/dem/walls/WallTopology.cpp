#include "core/DisjointSets.hpp"
#include "walls/Walls.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <unordered_map>

// Which triangles meet at which edges and corners, and what belongs together.

namespace elutria::dem
{

namespace
{

constexpr double weldTolerance = 1e-9;         // of the walls' extent
constexpr double flat = 1e-6;                  // rad, bend within one plane

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


bool finite(const Vector3& p)
{
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Angle by which two directions differ from opposite ones, rad: the bend across an edge, of the
/// directions into the triangles beside it, or of a line, of the directions away from a corner.
double bend(const Vector3& a, const Vector3& b)
{
    return std::atan2(norm(cross(a, b)), -dot(a, b));
}

} // namespace


/// Edges and corners while they are being put together.
struct Walls::Topology
{
    struct Adjacent { std::uint32_t triangle; Vector3 inward; };
    struct Outgoing { std::uint32_t edge; Vector3 direction; };
    std::vector<std::vector<Adjacent>> adjacent;       // of each edge
    std::vector<std::vector<Outgoing>> outgoing;       // of each corner
    std::vector<std::vector<Outgoing>> sharp;          // of these: along sharp edges
    std::vector<std::uint32_t> someTriangle;           // at each corner
    DisjointSets runs;                                 // of sharp edges in line

    bool inLine(std::size_t vertex) const
    {
        return sharp[vertex].size() == 2
            && bend(sharp[vertex][0].direction, sharp[vertex][1].direction) < smoothAngle;
    }
};


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
    if (move() && geometry_.motion.size() != geometry_.triangles.size())
        throw std::invalid_argument("walls: " + std::to_string(geometry_.triangles.size())
            + " triangles but " + std::to_string(geometry_.motion.size()) + " motions");
    for (const std::uint32_t motion : geometry_.motion)
        if (motion >= geometry_.motions.size())
            throw std::invalid_argument("walls: a triangle names motion " + std::to_string(motion)
                + ", there are " + std::to_string(geometry_.motions.size()));
    checkMotions();
    for (int axis = 0; axis < 3; ++axis)
        if (box_.periodic[axis] && !(box_.high[axis] > box_.low[axis]))
            throw std::invalid_argument("walls: the periodic box is empty along axis "
                + std::to_string(axis));
}


void Walls::checkMotions() const
{
    for (const WallMotion& m : geometry_.motions)
        if (!finite(m.velocity) || !finite(m.rotation) || !finite(m.origin))
            throw std::invalid_argument("walls: a motion is not finite");
}


void Walls::setMotions(std::vector<WallMotion> motions)
{
    if (motions.size() != geometry_.motions.size())
        throw std::invalid_argument("walls: " + std::to_string(motions.size())
            + " new motions; allowed: as many as before, "
            + std::to_string(geometry_.motions.size()));
    geometry_.motions = std::move(motions);
    checkMotions();
}


double Walls::largestSpeed() const
{
    double most = 0;
    for (std::size_t i = 0; i < geometry_.motion.size(); ++i)
        for (const std::uint32_t point : geometry_.triangles[i])
            most = std::max(most, norm(geometry_.motions[geometry_.motion[i]]
                                           .at(geometry_.points[point])));
    return most;
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
    Topology topology;
    joinCorners(topology);
    joinSurfaces(topology);
    joinRuns(topology);
    nameFeatures(topology);
}


/// Numbers corners and edges. An edge is known by its middle and its ends: in a small periodic box
/// its ends alone may be each other's images.
void Walls::joinCorners(Topology& topology)
{
    Vector3 low = triangles_[order_[0]].corner, high = low;
    for (const Vector3& p : geometry_.points)
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    const double tolerance = weldTolerance*norm(high - low);
    Welder vertexNumbers(box_, tolerance), middleNumbers(box_, tolerance);
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> edgeNumbers;
    for (const std::uint32_t i : order_)
    {
        Triangle& t = triangles_[i];
        const Vector3 corner[3] = {t.corner, t.corner + t.side1, t.corner + t.side2};
        for (int k = 0; k < 3; ++k)
        {
            t.vertex[k] = vertexNumbers.number(corner[k]);
            if (t.vertex[k] < topology.outgoing.size()) continue;
            topology.outgoing.emplace_back();
            topology.someTriangle.push_back(i);
        }
        for (int k = 0; k < 3; ++k)
        {
            const std::uint32_t v = t.vertex[k], w = t.vertex[(k + 1) % 3];
            const Vector3 from = corner[k], to = corner[(k + 1) % 3];
            const Vector3 along = (1/norm(to - from))*(to - from);
            const std::uint32_t middle = middleNumbers.number(0.5*(from + to));
            const auto [at, isNew] = edgeNumbers.try_emplace(
                {std::min(v, w), std::max(v, w), middle},
                static_cast<std::uint32_t>(topology.adjacent.size()));
            t.edge[k] = at->second;
            if (isNew)
            {
                topology.adjacent.emplace_back();
                topology.outgoing[v].push_back({at->second, along});
                topology.outgoing[w].push_back({at->second, -along});
            }
            topology.adjacent[at->second].push_back({i, cross(t.normal, along)});
        }
    }
}


void Walls::joinSurfaces(const Topology& topology)
{
    DisjointSets surfaces(triangles_.size()), planes(triangles_.size());
    for (const auto& sides : topology.adjacent)
        for (std::size_t a = 0; a < sides.size(); ++a)
            for (std::size_t b = a + 1; b < sides.size(); ++b)
            {
                const double angle = bend(sides[a].inward, sides[b].inward);
                if (angle < smoothAngle) surfaces.join(sides[a].triangle, sides[b].triangle);
                if (angle < flat) planes.join(sides[a].triangle, sides[b].triangle);
            }
    for (const std::uint32_t i : order_)
    {
        triangles_[i].surface = surfaces.root(i);
        triangles_[i].plane = planes.root(i);
    }
    for (const std::uint32_t i : order_)
        for (int k = 0; k < 3; ++k)
        {
            const auto& sides = topology.adjacent[triangles_[i].edge[k]];
            triangles_[i].rim[k] = sides.size() != 2
                || triangles_[sides[0].triangle].plane != triangles_[sides[1].triangle].plane;
        }
}


/// An edge is sharp unless all its triangles, two or more, are of one surface.
void Walls::joinRuns(Topology& topology) const
{
    const auto isSharp = [&](std::uint32_t edge)
    {
        const auto& sides = topology.adjacent[edge];
        return sides.size() < 2 || std::any_of(sides.begin(), sides.end(), [&](const auto& side)
        {
            return triangles_[side.triangle].surface != triangles_[sides[0].triangle].surface;
        });
    };
    topology.sharp.resize(topology.outgoing.size());
    for (std::size_t v = 0; v < topology.outgoing.size(); ++v)
        for (const auto& out : topology.outgoing[v])
            if (isSharp(out.edge)) topology.sharp[v].push_back(out);
    topology.runs.reset(topology.adjacent.size());
    for (std::size_t v = 0; v < topology.sharp.size(); ++v)
        if (topology.inLine(v))
            topology.runs.join(topology.sharp[v][0].edge, topology.sharp[v][1].edge);
}


void Walls::nameFeatures(Topology& topology)
{
    const std::uint64_t runKind = std::uint64_t(2) << 32, cornerKind = std::uint64_t(3) << 32;
    std::vector<bool> isSharp(topology.adjacent.size(), false);
    for (const auto& edges : topology.sharp)
        for (const auto& out : edges) isSharp[out.edge] = true;
    for (std::uint32_t e = 0; e < topology.adjacent.size(); ++e)
    {
        const auto begin = static_cast<std::uint32_t>(inward_.size());
        for (const auto& side : topology.adjacent[e]) inward_.push_back(side.inward);
        const std::uint64_t key = isSharp[e] ? runKind + topology.runs.root(e)
            : surfaceKey(triangles_[topology.adjacent[e][0].triangle].surface);
        edges_.push_back({begin, static_cast<std::uint32_t>(inward_.size()), key});
    }
    for (std::uint32_t v = 0; v < topology.outgoing.size(); ++v)
    {
        const auto begin = static_cast<std::uint32_t>(outgoing_.size());
        for (const auto& out : topology.outgoing[v]) outgoing_.push_back(out.direction);
        const auto& sharp = topology.sharp[v];
        const std::uint64_t key =
            sharp.empty() ? surfaceKey(triangles_[topology.someTriangle[v]].surface)
            : topology.inLine(v) ? runKind + topology.runs.root(sharp[0].edge) : cornerKind + v;
        vertices_.push_back({begin, static_cast<std::uint32_t>(outgoing_.size()), key});
    }
}

} // namespace elutria::dem

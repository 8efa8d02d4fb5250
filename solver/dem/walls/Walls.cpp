#include "walls/Walls.hpp"

#include <algorithm>

namespace elutria::dem
{

namespace
{

/// An edge or corner counts when no direction into the wall brings it nearer than this cosine.
constexpr double sideways = 1e-9;

} // namespace


/// Nearest point of a triangle by the Voronoi regions of its corners, edges and face
/// (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
Walls::Foot Walls::foot(const Triangle& t, const Vector3& position) const
{
    const Vector3 toA = position - t.corner;
    const double d1 = dot(t.side1, toA), d2 = dot(t.side2, toA);
    if (d1 <= 0 && d2 <= 0) return {t.corner, Region::vertex, 0};

    const Vector3 toB = toA - t.side1;
    const double d3 = dot(t.side1, toB), d4 = dot(t.side2, toB);
    if (d3 >= 0 && d4 <= d3) return {t.corner + t.side1, Region::vertex, 1};

    const double weightC = d1*d4 - d3*d2;
    if (weightC <= 0 && d1 >= 0 && d3 <= 0)
        return {t.corner + (d1/(d1 - d3))*t.side1, Region::edge, 0};

    const Vector3 toC = toA - t.side2;
    const double d5 = dot(t.side1, toC), d6 = dot(t.side2, toC);
    if (d6 >= 0 && d5 <= d6) return {t.corner + t.side2, Region::vertex, 2};

    const double weightB = d5*d2 - d1*d6;
    if (weightB <= 0 && d2 >= 0 && d6 <= 0)
        return {t.corner + (d2/(d2 - d6))*t.side2, Region::edge, 2};

    const double weightA = d3*d6 - d5*d4;
    if (weightA <= 0 && d4 >= d3 && d5 >= d6)
    {
        const double along = (d4 - d3)/((d4 - d3) + (d5 - d6));
        return {t.corner + t.side1 + along*(t.side2 - t.side1), Region::edge, 1};
    }
    return {position - dot(t.normal, toA)*t.normal, Region::face, 0};
}


Vector3 Walls::nearestPoint(const Image& image, const Vector3& position) const
{
    return foot(triangles_[image.triangle], position - image.shift).point + image.shift;
}


bool Walls::locallyNearest(const Triangle& t, const Foot& foot, const Vector3& away) const
{
    if (foot.region == Region::face) return true;
    const bool onEdge = foot.region == Region::edge;
    const Feature& feature =
        onEdge ? edges_[t.edge[foot.index]] : vertices_[t.vertex[foot.index]];
    const std::vector<Vector3>& directions = onEdge ? inward_ : outgoing_;
    const double limit = sideways*norm(away);
    return std::all_of(directions.begin() + feature.begin, directions.begin() + feature.end,
                       [&](const Vector3& d) { return dot(d, away) <= limit; });
}


std::uint64_t Walls::key(const Triangle& t, const Foot& foot) const
{
    switch (foot.region)
    {
        case Region::edge: return edges_[t.edge[foot.index]].key;
        case Region::vertex: return vertices_[t.vertex[foot.index]].key;
        default: return surfaceKey(t.surface);
    }
}


void Walls::collectImage(const Vector3& low, const Vector3& high, const Vector3& shift,
                         std::vector<Image>& found) const
{
    const Vector3 from = low - shift, to = high - shift;
    const Vector3 middle = 0.5*(from + to), half = 0.5*(to - from);
    std::uint32_t stack[64];
    int height = 0;
    stack[height++] = 0;
    while (height > 0)
    {
        const std::uint32_t index = stack[--height];
        const Node& node = nodes_[index];
        if (node.low.x > to.x || node.high.x < from.x || node.low.y > to.y
            || node.high.y < from.y || node.low.z > to.z || node.high.z < from.z) continue;
        if (!node.leaf)
        {
            stack[height++] = node.begin;
            stack[height++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i)
        {
            const Triangle& t = triangles_[order_[i]];
            const double width = std::abs(t.normal.x)*half.x + std::abs(t.normal.y)*half.y
                                 + std::abs(t.normal.z)*half.z;
            if (std::abs(dot(t.normal, middle - t.corner)) <= width*(1 + 1e-12))
                found.push_back({order_[i], shift});
        }
    }
}


void Walls::collect(const Vector3& centre, double reach, std::vector<Image>& found) const
{
    found.clear();
    if (distanceBound(centre) > reach) return;
    const Vector3 around{reach, reach, reach};
    collectBox(centre - around, centre + around, found);
}


void Walls::collect(const Vector3& from, const Vector3& to, double reach,
                    std::vector<Image>& found) const
{
    found.clear();
    if (!near(from, to, reach)) return;
    Vector3 low, high;
    for (int axis = 0; axis < 3; ++axis)
    {
        low[axis] = std::min(from[axis], to[axis]) - reach;
        high[axis] = std::max(from[axis], to[axis]) + reach;
    }
    collectBox(low, high, found);
}


/// From point to point along the way, each as far ahead as the distance bound allows.
bool Walls::near(const Vector3& from, const Vector3& to, double reach) const
{
    if (triangles_.empty()) return false;
    const double length = norm(to - from);
    for (double way = 0;;)
    {
        const double room = distanceBound(from + (length > 0 ? way/length : 0)*(to - from)) - reach;
        if (room <= 0) return true;
        if (way + room >= length) return false;
        way += std::max(room, 1e-3*length);
    }
}


void Walls::collectBox(const Vector3& low, const Vector3& high, std::vector<Image>& found) const
{
    if (triangles_.empty()) return;
    forImages(low, high, [&](const Vector3& shift) { collectImage(low, high, shift, found); });
}


void Walls::addContact(const Triangle& t, const Image& image, const Foot& nearest,
                       const Vector3& position, double radius, double limit,
                       std::vector<WallContact>& found) const
{
    const Vector3 away = position - nearest.point;
    const double distance = norm(away);
    if (distance > limit || !locallyNearest(t, nearest, away)) return;
    const Vector3 normal = distance > 0 ? (1/distance)*away : t.normal;
    const Vector3 point = nearest.point + image.shift;
    found.push_back({normal, point, distance - radius, t.material, image.triangle,
                     key(t, nearest), surfaceVelocity(image, point, normal)});
}


void Walls::contacts(const Vector3& centre, double radius, double reach,
                     const std::vector<Image>& among, std::vector<WallContact>& found) const
{
    found.clear();
    const double limit = radius + reach;
    for (const Image& image : among)
    {
        const Triangle& t = triangles_[image.triangle];
        const Vector3 p = centre - image.shift;
        if (std::abs(dot(t.normal, p - t.corner)) > limit) continue;
        addContact(t, image, foot(t, p), p, radius, limit, found);
    }
    if (found.size() > 1) mergeParallel(found);
}


void Walls::contacts(const Vector3& centre, double radius, double reach,
                     std::vector<WallContact>& found) const
{
    thread_local std::vector<Image> among;
    collect(centre, radius + reach, among);
    contacts(centre, radius, reach, among, found);
}


Vector3 Walls::movedOut(const Vector3& centre, double radius) const
{
    constexpr double clearance = 1e-9;           // of the overlap
    thread_local std::vector<WallContact> found;
    contacts(centre, radius, 0, found);
    Vector3 place = centre;
    for (const WallContact& c : found)
        if (c.gap < 0) place -= c.gap*(1 + clearance)*c.normal;
    return place;
}


bool Walls::isFlat(const Vector3& centre, double margin, const std::vector<Image>& among) const
{
    if (among.empty()) return false;
    const Triangle& first = triangles_[among[0].triangle];
    for (const Image& image : among)
    {
        const Triangle& t = triangles_[image.triangle];
        const Vector3 apart = image.shift - among[0].shift;
        if (t.plane != first.plane || squaredNorm(apart) > 0) return false;

        const Vector3 toA = centre - image.shift - t.corner;
        const Vector3 corner[3] = {{}, t.side1, t.side2};
        const Vector3 below = toA - dot(t.normal, toA)*t.normal;
        for (int k = 0; k < 3; ++k)
        {
            if (!t.rim[k]) continue;
            const Vector3 side = corner[(k + 1) % 3] - corner[k], to = below - corner[k];
            const double along = std::clamp(dot(to, side)/squaredNorm(side), 0.0, 1.0);
            if (squaredNorm(to - along*side) <= margin*margin*(1 + 1e-6)) return false;
        }
    }
    return true;
}


void Walls::contactsOnFlat(const Vector3& centre, double radius, double reach,
                           const std::vector<Image>& among, std::uint32_t& below,
                           std::vector<WallContact>& found) const
{
    found.clear();
    const double limit = radius + reach;
    const auto count = static_cast<std::uint32_t>(among.size());
    for (std::uint32_t k = 0; k < count; ++k)
    {
        const std::uint32_t place = below + k < count ? below + k : below + k - count;
        const Image& image = among[place];
        const Triangle& t = triangles_[image.triangle];
        const Vector3 p = centre - image.shift;
        if (std::abs(dot(t.normal, p - t.corner)) > limit) return;
        const Foot nearest = foot(t, p);
        if (nearest.region != Region::face) continue;
        below = place;
        addContact(t, image, nearest, p, radius, limit, found);
        return;
    }
    contacts(centre, radius, reach, among, found);      // above an edge
}


/// Keeps the deepest of the contacts that point the same way; a surface touched twice keeps its
/// key for the deeper contact, the other is known by its plane.
void Walls::mergeParallel(std::vector<WallContact>& found) const
{
    static const double parallel = std::cos(smoothAngle);
    std::sort(found.begin(), found.end(), [](const WallContact& a, const WallContact& b)
    {
        return a.gap != b.gap ? a.gap < b.gap : a.triangle < b.triangle;
    });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
    {
        bool same = false, keyTaken = false;
        for (std::size_t j = 0; j < kept; ++j)
        {
            same = same || dot(found[i].normal, found[j].normal) > parallel;
            keyTaken = keyTaken || found[i].feature == found[j].feature;
        }
        if (same) continue;
        if (keyTaken) found[i].feature = planeKey(found[i].triangle);
        found[kept++] = found[i];
    }
    found.resize(kept);
}


double Walls::distanceFromGrid(const Vector3& position) const
{
    Vector3 low = gridLow_, high = gridHigh_;
    for (int axis = 0; axis < 3; ++axis)
    {
        if (!box_.periodic[axis]) continue;
        low[axis] = std::min(low[axis], position[axis]);
        high[axis] = std::max(high[axis], position[axis]);
    }
    return std::sqrt(squaredDistanceToBox(position, low, high));
}

} // namespace elutria::dem

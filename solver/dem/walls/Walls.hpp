#pragma once

#include "core/PeriodicBox.hpp"
#include "core/WallHit.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace elutria::dem
{

/// Rigid motion of a wall along its own surface: a belt, a rotor, a deck that shakes in its plane.
/// The geometry stays where it is; what the motion has across the surface does not count.
struct WallMotion
{
    Vector3 velocity;                                        // m/s
    Vector3 rotation;                                        // rad/s, angular velocity
    Vector3 origin;                                          // m, a point of the axis

    Vector3 at(const Vector3& point) const { return velocity + cross(rotation, point - origin); }
};

/// What the caller knows of the walls: triangles as index triples into shared points.
/// Both sides of a triangle are wall; a baffle is given once.
struct WallGeometry
{
    std::vector<Vector3> points;                             // m
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> material;                     // per triangle: contact material
    std::vector<WallMotion> motions = {};
    std::vector<std::uint32_t> motion = {};                  // per triangle: index into motions;
                                                             // empty: all at rest
};

/// A sphere near or in a wall.
struct WallContact
{
    Vector3 normal;            // unit, from the wall to the sphere's centre
    Vector3 point;             // m, the wall's point nearest to the centre
    double gap;                // m, distance minus radius: negative when overlapping
    std::uint32_t material;
    std::uint32_t triangle;
    std::uint64_t feature;     // stable key of what is touched, for the contact history
    Vector3 velocity;          // m/s, of the wall's surface at the point, along the surface
};

/// Triangulated walls, and which of their features a sphere touches.
///
/// A contact is a local minimum of the distance from the sphere's centre to the wall:
///  1. inside a triangle: the foot of the perpendicular; coplanar neighbours share one;
///  2. on an edge: only if the distance grows into every triangle that shares the edge, so a flat
///     or concave edge never counts and a convex or free edge counts once;
///  3. at a corner: only if the distance grows along every edge that meets there.
/// Contacts whose normals differ by less than `smoothAngle` are one contact, the deepest: a curved
/// wall made of facets, a slightly warped face or triangles that do not share points act as one.
/// A sphere in a concave corner keeps one contact per wall.
///
/// Feature keys belong to smooth surfaces (triangles joined across edges that bend by less than
/// `smoothAngle`), to straight runs of sharp edges and to corners, so that a sphere that slides
/// from triangle to triangle keeps its key. They depend on the geometry's order alone.
class Walls
{
public:
    static constexpr double smoothAngle = 10*3.14159265358979323846/180;   // rad

    Walls() = default;

    /// Throws std::invalid_argument for a point or motion that is not finite, an index out of range,
    /// a material or motion count differing from the triangle count, or an empty periodic box.
    explicit Walls(WallGeometry geometry, PeriodicBox box = {});

    bool empty() const { return triangles_.empty(); }
    std::size_t size() const { return triangles_.size(); }
    const WallGeometry& geometry() const { return geometry_; }
    const PeriodicBox& box() const { return box_; }
    std::uint32_t material(std::uint32_t triangle) const { return triangles_[triangle].material; }

    bool move() const { return !geometry_.motion.empty(); }
    /// New motions of the same walls (an oscillating deck); as many as the geometry had.
    void setMotions(std::vector<WallMotion> motions);
    /// Largest speed of any wall's surface, m/s.
    double largestSpeed() const;

    /// What hits mean, by contact material; empty: all are silent.
    void setAnswers(std::vector<WallAnswer> ofMaterial) { answers_ = std::move(ofMaterial); }
    /// Does any take what hits it?
    bool take() const
    {
        return std::find(answers_.begin(), answers_.end(), WallAnswer::takes) != answers_.end();
    }
    WallAnswer answer(std::uint32_t triangle) const
    {
        const std::uint32_t m = material(triangle);
        return m < answers_.size() ? answers_[m] : WallAnswer::silent;
    }

    /// Lower bound of the distance from a position to any wall, m: one table look-up.
    /// 0 when near; infinite without walls.
    double distanceBound(const Vector3& position) const
    {
        if (triangles_.empty()) return infinite;
        const Vector3 p = box_.any() ? box_.wrapped(position) : position;
        std::size_t cell = 0;
        for (int axis = 2; axis >= 0; --axis)
        {
            const double s = (p[axis] - gridLow_[axis])*gridInverse_[axis];
            if (!(s >= 0 && s < gridCells_[axis])) return distanceFromGrid(p);
            cell = cell*gridCells_[axis] + static_cast<std::size_t>(s);
        }
        return boundUnit_*bound_[cell];
    }

    /// A triangle, seen from one periodic image: the wall stands at its points + shift.
    struct Image
    {
        std::uint32_t triangle;
        Vector3 shift;
    };

    /// Velocity along its surface of the wall at a point, m/s.
    Vector3 surfaceVelocity(const Image& image, const Vector3& point, const Vector3& normal) const
    {
        if (!move()) return {};
        const Vector3 v = geometry_.motions[geometry_.motion[image.triangle]].at(point - image.shift);
        return v - dot(v, normal)*normal;
    }

    /// False only if no wall comes within `reach` of the straight way from `from` to `to`.
    bool near(const Vector3& from, const Vector3& to, double reach) const;

    /// Triangles with a point within `reach` of `centre` (a superset); replaces `found`.
    void collect(const Vector3& centre, double reach, std::vector<Image>& found) const;

    /// Triangles that come within `reach` of the straight way from `from` to `to` (a superset).
    void collect(const Vector3& from, const Vector3& to, double reach,
                 std::vector<Image>& found) const;

    /// Contacts of the sphere with gap <= reach, among triangles collected for a region that
    /// covers it; replaces `found`, in order of increasing gap.
    void contacts(const Vector3& centre, double radius, double reach,
                  const std::vector<Image>& among, std::vector<WallContact>& found) const;

    /// The same among all triangles.
    void contacts(const Vector3& centre, double radius, double reach,
                  std::vector<WallContact>& found) const;

    /// Where the sphere's centre is, moved out of every wall that the sphere overlaps.
    Vector3 movedOut(const Vector3& centre, double radius) const;

    /// True if these triangles, collected around `centre`, are one plane whose rim is out of the
    /// way of a sphere that stays within `margin` of there: the sphere touches at most the
    /// triangle below its centre.
    bool isFlat(const Vector3& centre, double margin, const std::vector<Image>& among) const;

    /// contacts() among triangles that are flat there; `below` is the place in them to look at
    /// first, and where the sphere was found.
    void contactsOnFlat(const Vector3& centre, double radius, double reach,
                        const std::vector<Image>& among, std::uint32_t& below,
                        std::vector<WallContact>& found) const;

    /// Point of a triangle (image) nearest to a position.
    Vector3 nearestPoint(const Image& image, const Vector3& position) const;

private:
    static constexpr double infinite = 1e300;
    static constexpr std::uint32_t none = 0xffffffffu;

    struct Triangle
    {
        Vector3 corner, side1, side2, normal;       // corner, the two sides from it, unit normal
        std::array<std::uint32_t, 3> edge;          // edge k joins corners k and k+1
        std::array<std::uint32_t, 3> vertex;
        std::uint32_t surface, plane, material;
        std::array<bool, 3> rim;                    // edge does not go on in the same plane
        bool sound;                                 // has an area
    };
    /// Ranges into inward_ (unit, in each triangle, off the edge) and outgoing_ (unit, along each
    /// edge away from the vertex).
    struct Feature
    {
        std::uint32_t begin, end;
        std::uint64_t key;
    };
    struct Node                                     // of the tree of bounding boxes
    {
        Vector3 low, high;
        std::uint32_t begin, end;                   // leaf: range in order_; else begin = right child
        bool leaf;
    };
    enum class Region { face, edge, vertex };
    struct Foot
    {
        Vector3 point;
        Region region;
        int index;
    };

    Foot foot(const Triangle&, const Vector3& position) const;
    bool locallyNearest(const Triangle&, const Foot&, const Vector3& away) const;
    std::uint64_t key(const Triangle&, const Foot&) const;
    /// The contact at the foot of `position` (seen from the image), if it is one within `limit`.
    void addContact(const Triangle&, const Image&, const Foot&, const Vector3& position,
                    double radius, double limit, std::vector<WallContact>& found) const;
    void mergeParallel(std::vector<WallContact>& found) const;
    std::uint64_t surfaceKey(std::uint32_t surface) const { return surface; }
    std::uint64_t planeKey(std::uint32_t triangle) const
    {
        return (std::uint64_t(1) << 32) + triangles_[triangle].plane;
    }
    double distanceFromGrid(const Vector3& position) const;
    static double squaredDistanceToBox(const Vector3& p, const Vector3& low, const Vector3& high)
    {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
        {
            const double outside = std::max({low[axis] - p[axis], p[axis] - high[axis], 0.0});
            sum += outside*outside;
        }
        return sum;
    }

    /// Calls visit(shift) for every periodic image of the walls that can reach into a box.
    template<class Visit>
    void forImages(const Vector3& low, const Vector3& high, const Visit& visit) const
    {
        if (!box_.any()) return visit(Vector3{});
        const Vector3 middle = 0.5*(low + high), inside = box_.wrapped(middle);
        const Vector3 home = middle - inside, length = box_.high - box_.low;
        int first[3] = {0, 0, 0}, last[3] = {0, 0, 0};
        for (int axis = 0; axis < 3; ++axis)
        {
            if (!box_.periodic[axis]) continue;
            const double half = 0.5*(high[axis] - low[axis]);
            if (inside[axis] - half <= box_.low[axis]) first[axis] = -1;
            if (inside[axis] + half >= box_.high[axis]) last[axis] = 1;
        }
        for (int i = first[0]; i <= last[0]; ++i)
            for (int j = first[1]; j <= last[1]; ++j)
                for (int k = first[2]; k <= last[2]; ++k)
                    visit(home + Vector3{i*length.x, j*length.y, k*length.z});
    }

    void collectBox(const Vector3& low, const Vector3& high, std::vector<Image>& found) const;
    void collectImage(const Vector3& low, const Vector3& high, const Vector3& shift,
                      std::vector<Image>& found) const;

    void check() const;
    void checkMotions() const;
    void buildTriangles();
    struct Topology;
    void buildTopology();
    void joinCorners(Topology& topology);
    void joinSurfaces(const Topology& topology);
    void joinRuns(Topology& topology) const;
    void nameFeatures(Topology& topology);
    std::uint32_t buildTree(std::uint32_t begin, std::uint32_t end);
    void buildGrid();
    std::vector<double> squaredDistances() const;
    double distanceNear(const Vector3& position, double guess) const;

    WallGeometry geometry_;
    PeriodicBox box_;
    std::vector<WallAnswer> answers_;
    std::vector<Triangle> triangles_;
    std::vector<Feature> edges_, vertices_;
    std::vector<Vector3> inward_, outgoing_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
    Vector3 gridLow_, gridHigh_, gridInverse_;
    std::array<std::uint32_t, 3> gridCells_{0, 0, 0};
    double boundUnit_ = 0;
    std::vector<std::uint8_t> bound_;
};

} // namespace elutria::dem

#include "walls/Walls.hpp"

#include <algorithm>

// Where the walls are: a tree of bounding boxes over the triangles, and a table of distances.

namespace elutria::dem
{

namespace
{

constexpr double cellsPerTriangle = 128, fewestCells = 1 << 13, mostCells = 1 << 17;
constexpr std::uint32_t leafSize = 4;

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

} // namespace


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
        distances[i] = guess < 2*diagonal ? distanceNear(centre, guess + 0.5*diagonal)
                                          : guess - 0.5*diagonal;
    }
    boundUnit_ = std::max(*std::max_element(distances.begin(), distances.end()), diagonal)/255;
    bound_.resize(cells);
    for (std::size_t i = 0; i < cells; ++i)
        bound_[i] = static_cast<std::uint8_t>(
            std::max(0.0, distances[i] - 0.5*diagonal)/boundUnit_);
}


/// Distance to the walls, known to be at most `guess`: boxes farther than the nearest so far are left
/// out.
double Walls::distanceNear(const Vector3& position, double guess) const
{
    double nearest = guess*guess;
    forImages(position - Vector3{guess, guess, guess}, position + Vector3{guess, guess, guess},
              [&](const Vector3& shift)
    {
        const Vector3 p = position - shift;
        std::uint32_t stack[64];
        int height = 0;
        stack[height++] = 0;
        while (height > 0)
        {
            const std::uint32_t index = stack[--height];
            const Node& node = nodes_[index];
            if (squaredDistanceToBox(p, node.low, node.high) >= nearest) continue;
            if (!node.leaf)
            {
                const std::uint32_t left = index + 1, right = node.begin;
                const bool leftFirst =
                    squaredDistanceToBox(p, nodes_[left].low, nodes_[left].high)
                    < squaredDistanceToBox(p, nodes_[right].low, nodes_[right].high);
                stack[height++] = leftFirst ? right : left;
                stack[height++] = leftFirst ? left : right;
                continue;
            }
            for (std::uint32_t i = node.begin; i < node.end; ++i)
            {
                const Triangle& t = triangles_[order_[i]];
                nearest = std::min(nearest, squaredNorm(p - foot(t, p).point));
            }
        }
    });
    return std::sqrt(nearest);
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

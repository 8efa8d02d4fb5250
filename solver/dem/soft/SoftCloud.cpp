#include "soft/SoftCloud.hpp"

#include "core/Grouping.hpp"
#include "impacts/Flight.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace elutria::dem
{

void CloudTotals::add(const CloudTotals& others)
{
    particles += others.particles;
    smallest = std::min(smallest, others.smallest), largest = std::max(largest, others.largest);
    radii += others.radii;
    strongestPush = std::max(strongestPush, others.strongestPush);
    velocities += others.velocities;
    materials = materials || others.materials, weighted = weighted || others.weighted;
}

/// Other particles than before, by ascending id.
void SoftCloud::take(const Particles& p)
{
    const std::size_t n = p.size();
    ids_ = p.id;
    byId_.resize(n);
    std::iota(byId_.begin(), byId_.end(), 0u);
    std::sort(byId_.begin(), byId_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return p.id[a] < p.id[b]; });
    for (std::size_t k = 1; k < n; ++k)
    {
        if (p.id[byId_[k]] != p.id[byId_[k - 1]]) continue;
        forget();
        throw std::invalid_argument("particle id " + std::to_string(p.id[byId_[k]])
                                    + " is given twice; ids must be unique");
    }
    order_.assign(byId_.begin(), byId_.end());
    rows.resize(n), bases.resize(n), loads.resize(n);
}

double SoftCloud::load(const Particles& p, double step)
{
    const std::size_t n = p.size();
    const bool same = holds(p);
    if (!same) take(p);
    const bool oneMaterial = std::all_of(p.material.begin(), p.material.end(),
                                         [](std::uint32_t m) { return m == 0; });
    materials.resize(oneMaterial ? 0 : n);
    const bool real = std::all_of(p.statisticalWeight.begin(), p.statisticalWeight.end(),
                                  [](double weight) { return weight == 1; });
    weighted.resize(real ? 0 : n);
    const double shifted = loadStates(p, same);
    loadForcing(p, step);
    totals_.strongestPush = strongestPush;
    totals_.materials = !oneMaterial, totals_.weighted = !real;
    return shifted;
}

void SoftCloud::settle(const CloudTotals& totals)
{
    const double each = totals.particles > 0 ? 1/double(totals.particles) : 0;
    smallest = totals.smallest, largest = totals.largest, mean = each*totals.radii;
    frame = each*totals.velocities;
    strongestPush = totals.strongestPush;
    forElements(threads, size(), [&](std::size_t i)
    {
        rows[i].vx = float(bases[i].vx - frame.x);
        rows[i].vy = float(bases[i].vy - frame.y);
        rows[i].vz = float(bases[i].vz - frame.z);
    });
    if (totals.materials && materials.empty()) materials.assign(rows.size(), 0);
    if (totals.weighted && weighted.empty()) weighted.assign(rows.size(), 0);
}

void SoftCloud::resizeGhosts(std::size_t ghosts)
{
    const std::size_t all = size() + ghosts;
    rows.resize(all), bases.resize(all);
    if (!materials.empty()) materials.resize(all);
    if (!weighted.empty()) weighted.resize(all);
}

/// Everything but the rows' velocities; returns the largest shift of a surface.
double SoftCloud::loadStates(const Particles& p, bool same)
{
    struct Part : CloudTotals
    {
        double shifted = 0;
    };
    const auto parts = forBlocks(threads, p.size(), [&](std::size_t begin, std::size_t end)
    {
        Part part;
        for (std::size_t i = begin; i < end; ++i)
        {
            const std::uint32_t k = order_[i];
            const double radius = p.radius[k];
            const Vector3 x = box.wrapped(p.position[k]), v = p.velocity[k], s = radius*p.spin[k];
            if (same)
            {
                part.shifted = std::max(part.shifted, norm(box.shortest(x - position(i)))
                                                      + std::abs(radius - rows[i].radius));
            }
            rows[i] = {x.x, x.y, x.z, radius, 0, 0, 0, float(1/p.mass[k]),
                       float(s.x), float(s.y), float(s.z), float(1/radius)};
            bases[i] = {v.x, v.y, v.z, 1/p.mass[k], s.x, s.y, s.z, radius};
            if (!materials.empty()) materials[i] = std::uint8_t(p.material[k]);
            if (!weighted.empty()) weighted[i] = p.statisticalWeight[k] != 1;
            part.smallest = std::min(part.smallest, radius);
            part.largest = std::max(part.largest, radius);
            part.radii += radius;
            part.velocities += v;
        }
        part.particles = end - begin;
        return part;
    });
    totals_ = {};
    double shifted = 0;
    for (const Part& part : parts)
    {
        totals_.add(part);
        shifted = std::max(shifted, part.shifted);
    }
    return shifted;
}

void SoftCloud::loadForcing(const Particles& p, double step)
{
    const std::size_t n = p.size();
    bool uniform = p.dragRate.empty();
    push = p.acceleration.empty() || n == 0 ? Vector3{} : p.acceleration[0];
    strongestPush = norm(push);
    for (std::size_t i = 0; uniform && i < p.acceleration.size(); ++i)
    {
        uniform = p.acceleration.x[i] == push.x && p.acceleration.y[i] == push.y
                  && p.acceleration.z[i] == push.z;
    }
    forcing.resize(uniform ? 0 : n);
    if (uniform) return;
    const auto strongest = forBlocks(threads, n, [&](std::size_t begin, std::size_t end)
    {
        double most = 0;
        for (std::size_t i = begin; i < end; ++i)
        {
            const std::uint32_t k = order_[i];
            Vector3 a = p.acceleration.empty() ? Vector3{} : p.acceleration[k];
            const double rate = p.dragRate.empty() ? 0 : p.dragRate[k];
            if (!p.gasVelocity.empty()) a += rate*p.gasVelocity[k];
            const FlightFactors f(rate*step);
            forcing[i] = {a.x, a.y, a.z, f.decay, step*f.phi1, step*f.phi2};
            most = std::max(most, norm(a - rate*p.velocity[k]));
        }
        return most;
    });
    for (double most : strongest) strongestPush = std::max(strongestPush, most);
}

void SoftCloud::store(Particles& p, double duration) const
{
    const bool drag = !p.dragRate.empty();
    if (drag) p.dragImpulse.resize(size());
    forElements(threads, size(), [&](std::size_t i)
    {
        const std::uint32_t k = order_[i];
        const Base& b = bases[i];
        if (drag)
        {
            // the gas gives m k (u - v); its integral needs the way gone only
            const Vector3 gas = p.gasVelocity.empty() ? Vector3{} : p.gasVelocity[k];
            const Vector3 way = position(i) - box.wrapped(p.position[k]);
            p.dragImpulse.set(k, p.mass[k]*p.dragRate[k]*(duration*gas - way));
        }
        p.position.set(k, box.wrapped(position(i)));
        p.velocity.set(k, {b.vx, b.vy, b.vz});
        p.spin.set(k, (1/b.radius)*Vector3{b.sx, b.sy, b.sz});
    });
}

namespace
{

/// Spreads the lowest 10 bits of `a` to every third bit.
std::uint64_t spread(std::uint64_t a)
{
    a = (a | a << 16) & 0x030000ff;
    a = (a | a << 8) & 0x0300f00f;
    a = (a | a << 4) & 0x030c30c3;
    a = (a | a << 2) & 0x09249249;
    return a;
}

/// Ascending by the upper half, by bytes from the least significant on; equal ones keep their order.
void sortByUpperHalf(unsigned threads, Untouched<std::uint64_t>& keys)
{
    Untouched<std::uint64_t> sorted(keys.size());
    for (int shift = 32; shift < 64; shift += 8)
    {
        const auto byte = [&](std::size_t k) { return std::size_t(keys[k] >> shift & 255); };
        Grouping grouping(threads, keys.size(), 256);
        grouping.read(byte);
        grouping.write(byte, [&](std::size_t k, std::size_t place) { sorted[place] = keys[k]; });
        keys.swap(sorted);
    }
}

} // namespace

Untouched<std::uint32_t> SoftCloud::sort(double width)
{
    const std::size_t n = size();
    struct Extent
    {
        Vector3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
        void add(const Vector3& x, const Vector3& y)
        {
            for (int a = 0; a < 3; ++a)
                low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], y[a]);
        }
    };
    const auto extents = forBlocks(threads, n, [&](std::size_t begin, std::size_t end)
    {
        Extent extent;
        for (std::size_t i = begin; i < end; ++i)
        {
            const Vector3 x = box.wrapped(position(i));
            extent.add(x, x);
        }
        return extent;
    });
    Extent all;
    for (const Extent& extent : extents) all.add(extent.low, extent.high);
    for (int a = 0; a < 3; ++a) width = std::max(width, (all.high[a] - all.low[a])/1023);

    Untouched<std::uint32_t> target(n);             // first: the own index of each caller's index
    forElements(threads, n, [&](std::size_t i) { target[order_[i]] = std::uint32_t(i); });
    Untouched<std::uint64_t> keys(n);               // by id
    forElements(threads, n, [&](std::size_t k)
    {
        const std::uint32_t i = target[byId_[k]];
        const Vector3 x = box.wrapped(position(i));
        std::uint64_t key = 0;
        for (int a = 0; a < 3; ++a)
        {
            const double cell = std::min(1023.0, (x[a] - all.low[a])/width);
            key |= spread(std::uint64_t(cell)) << a;
        }
        keys[k] = key << 32 | i;
    });
    sortByUpperHalf(threads, keys);
    Untouched<std::uint32_t> from(n);
    forElements(threads, n, [&](std::size_t k)
    {
        from[k] = std::uint32_t(keys[k]);
        target[from[k]] = std::uint32_t(k);
    });
    reorder(rows, from), reorder(bases, from), reorder(order_, from);
    reorder(materials, from), reorder(weighted, from), reorder(forcing, from);
    return target;
}

template<class Values>
void SoftCloud::reorder(Values& values, const Untouched<std::uint32_t>& from) const
{
    if (values.empty()) return;
    Values sorted(values.size());
    forElements(threads, values.size(), [&](std::size_t k) { sorted[k] = values[from[k]]; });
    values.swap(sorted);
}

std::vector<std::uint32_t> SoftCloud::byId() const
{
    std::vector<std::uint32_t> own(size()), sorted(size());
    for (std::size_t i = 0; i < size(); ++i) own[order_[i]] = std::uint32_t(i);
    for (std::size_t k = 0; k < size(); ++k) sorted[k] = own[byId_[k]];
    return sorted;
}

std::uint32_t SoftCloud::find(const std::vector<std::uint32_t>& byId, std::uint64_t wanted) const
{
    const auto at = std::lower_bound(byId.begin(), byId.end(), wanted,
        [&](std::uint32_t i, std::uint64_t value) { return id(i) < value; });
    return at != byId.end() && id(*at) == wanted ? *at : none;
}

std::size_t SoftCloud::bytes() const
{
    return rows.capacity()*sizeof(Row) + bases.capacity()*sizeof(Base)
           + loads.capacity()*sizeof(Load) + forcing.capacity()*sizeof(Forcing)
           + materials.capacity() + 4*(order_.capacity() + byId_.capacity())
           + 8*ids_.capacity();
}

} // namespace elutria::dem

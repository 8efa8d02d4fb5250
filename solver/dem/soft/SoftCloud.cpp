#include "soft/SoftCloud.hpp"

#include "impacts/Flight.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace elutria::dem
{

double SoftCloud::load(const Particles& p, double step)
{
    const std::size_t n = p.size();
    const bool same = holds(p);
    if (!same)
    {
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
        order_ = byId_;
        rows.assign(n, {}), bases.assign(n, {}), loads.assign(n, {});
    }
    const bool oneMaterial = std::all_of(p.material.begin(), p.material.end(),
                                         [](std::uint32_t m) { return m == 0; });
    materials.resize(oneMaterial ? 0 : n);
    const bool real = std::all_of(p.statisticalWeight.begin(), p.statisticalWeight.end(),
                                  [](double weight) { return weight == 1; });
    weighted.resize(real ? 0 : n);
    smallest = 1e300, largest = 0, mean = 0;
    Vector3 velocities;
    double shifted = 0;
    for (std::size_t i = 0; i < n; ++i)
    {
        const std::uint32_t k = order_[i];
        const double radius = p.radius[k];
        const Vector3 x = box.wrapped(p.position[k]), v = p.velocity[k], s = radius*p.spin[k];
        if (same)
        {
            shifted = std::max(shifted, norm(box.shortest(x - position(i)))
                                        + std::abs(radius - rows[i].radius));
        }
        rows[i] = {x.x, x.y, x.z, radius, 0, 0, 0, float(1/p.mass[k]),
                   float(s.x), float(s.y), float(s.z), float(1/radius)};
        bases[i] = {v.x, v.y, v.z, 1/p.mass[k], s.x, s.y, s.z, radius};
        loads[i] = {};
        if (!oneMaterial) materials[i] = std::uint8_t(p.material[k]);
        if (!real) weighted[i] = p.statisticalWeight[k] != 1;
        smallest = std::min(smallest, radius);
        largest = std::max(largest, radius);
        mean += radius/double(n);
        velocities += v;
    }
    frame = n > 0 ? (1/double(n))*velocities : Vector3{};
    for (std::size_t i = 0; i < n; ++i)
    {
        rows[i].vx = float(bases[i].vx - frame.x);
        rows[i].vy = float(bases[i].vy - frame.y);
        rows[i].vz = float(bases[i].vz - frame.z);
    }
    loadForcing(p, step);
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
    forcing.clear();
    if (uniform) return;
    forcing.resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        const std::uint32_t k = order_[i];
        Vector3 a = p.acceleration.empty() ? Vector3{} : p.acceleration[k];
        const double rate = p.dragRate.empty() ? 0 : p.dragRate[k];
        if (!p.gasVelocity.empty()) a += rate*p.gasVelocity[k];
        const FlightFactors f(rate*step);
        forcing[i] = {a.x, a.y, a.z, f.decay, step*f.phi1, step*f.phi2};
        strongestPush = std::max(strongestPush, norm(a - rate*p.velocity[k]));
    }
}

void SoftCloud::store(Particles& p, double duration) const
{
    const bool drag = !p.dragRate.empty();
    if (drag) p.dragImpulse.resize(size());
    for (std::size_t i = 0; i < size(); ++i)
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
    }
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

/// Ascending, by bytes from the least significant on.
void radixSort(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& scratch)
{
    scratch.resize(keys.size());
    for (int shift = 0; shift < 64; shift += 8)
    {
        std::size_t begin[257] = {};
        for (std::uint64_t key : keys) ++begin[(key >> shift & 255) + 1];
        if (std::find(begin + 1, begin + 257, keys.size()) != begin + 257) continue;
        for (int b = 0; b < 256; ++b) begin[b + 1] += begin[b];
        for (std::uint64_t key : keys) scratch[begin[key >> shift & 255]++] = key;
        keys.swap(scratch);
    }
}

} // namespace

std::vector<std::uint32_t> SoftCloud::sort(double width)
{
    const std::size_t n = size();
    Vector3 low{1e300, 1e300, 1e300}, high = -low;
    for (const Row& row : rows)
    {
        const Vector3 x = box.wrapped({row.x, row.y, row.z});
        for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
    }
    for (int a = 0; a < 3; ++a) width = std::max(width, (high[a] - low[a])/1023);
    std::vector<std::uint32_t> rank(n);
    for (std::size_t k = 0; k < n; ++k) rank[byId_[k]] = std::uint32_t(k);

    std::vector<std::uint64_t> keys(n), scratch;
    std::vector<std::uint32_t> ownOf(n);            // rank by id -> own index
    for (std::size_t i = 0; i < n; ++i)
    {
        const Vector3 x = box.wrapped(position(i));
        std::uint64_t key = 0;
        for (int a = 0; a < 3; ++a)
        {
            const double cell = std::min(1023.0, (x[a] - low[a])/width);
            key |= spread(std::uint64_t(cell)) << a;
        }
        keys[i] = key << 32 | rank[order_[i]];
        ownOf[rank[order_[i]]] = std::uint32_t(i);
    }
    radixSort(keys, scratch);
    std::vector<std::uint32_t> target(n);
    for (std::size_t k = 0; k < n; ++k) target[ownOf[keys[k] & 0xffffffffu]] = std::uint32_t(k);

    moveTo(target);
    return target;
}

/// Moves each particle to its target, in place, cycle by cycle; loads are all zero here.
void SoftCloud::moveTo(std::vector<std::uint32_t> target)
{
    for (std::uint32_t i = 0; i < size(); ++i)
    {
        while (target[i] != i)
        {
            const std::uint32_t k = target[i];
            std::swap(rows[i], rows[k]);
            std::swap(bases[i], bases[k]);
            std::swap(order_[i], order_[k]);
            if (!materials.empty()) std::swap(materials[i], materials[k]);
            if (!weighted.empty()) std::swap(weighted[i], weighted[k]);
            if (!forcing.empty()) std::swap(forcing[i], forcing[k]);
            std::swap(target[i], target[k]);
        }
    }
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

double SoftCloud::speedRange() const
{
    if (bases.empty()) return 0;
    Vector3 low = velocity(0), high = low;
    for (std::size_t i = 1; i < size(); ++i)
    {
        const Vector3 v = velocity(i);
        for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], v[a]), high[a] = std::max(high[a], v[a]);
    }
    return 0.5*norm(high - low);
}

std::size_t SoftCloud::bytes() const
{
    return rows.capacity()*sizeof(Row) + bases.capacity()*sizeof(Base)
           + loads.capacity()*sizeof(Load) + forcing.capacity()*sizeof(Forcing)
           + materials.capacity() + 4*(order_.capacity() + byId_.capacity())
           + 8*ids_.capacity();
}

} // namespace elutria::dem

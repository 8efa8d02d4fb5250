#include "soft/PairContacts.hpp"

#include "core/Grouping.hpp"
#include "core/Untouched.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

/// resize() that takes no more memory than asked for.
template<class T>
void widen(std::vector<T>& values, std::size_t size)
{
    values.reserve(size);
    values.resize(size);
}

} // namespace

void PairContacts::Arrays::makeRoom(std::size_t more)
{
    if (count + more <= first.size()) return;
    const std::size_t size = count + more + count/8;
    widen(first, size), widen(second, size), widen(x, size), widen(y, size), widen(z, size);
    widen(touching, size);
}

std::size_t PairContacts::Arrays::bytes() const
{
    return 4*(first.capacity() + second.capacity() + x.capacity() + y.capacity() + z.capacity())
           + touching.capacity();
}

PairContacts::PairContacts(const LawTable& laws, unsigned threads)
  : laws_(laws), kernel_(ContactLaws::find(laws.law().name)), threads_(threads)
{
    for (std::uint32_t a = 0; a < laws.size(); ++a)
    {
        for (std::uint32_t b = 0; b < laws.size(); ++b)
        {
            const laws::Coefficients& c = laws(a, b);
            coefficients_.push_back({float(c.stiffness), float(c.elastic), float(c.damping),
                                     float(c.shear), float(c.shearDamping), float(c.friction),
                                     float(c.cohesion), float(c.rolling), float(c.exponent)});
        }
    }
}

void PairContacts::reset(const Chunks& chunks, const std::vector<LastingPair>& lasting)
{
    runs_ = chunks;
    chunks_.resize(chunks.count());
    const auto chunkOf = [&](std::size_t k) { return runs_.of(lasting[k].first); };
    Grouping grouping(threads_, lasting.size(), chunks.count());
    grouping.read(chunkOf);
    Untouched<LastingPair> grouped(lasting.size());
    grouping.write(chunkOf, [&](std::size_t k, std::size_t place) { grouped[place] = lasting[k]; });
    forEach(threads_, chunks.count(), [&](std::size_t c)
    {
        const auto begin = grouped.begin() + std::ptrdiff_t(grouping.place(c));
        const auto end = grouped.begin() + std::ptrdiff_t(grouping.place(c + 1));
        const auto inside = std::partition(begin, end, [&](const LastingPair& p)
        {
            return p.second < runs_.end(c);
        });
        for (auto from : {begin, inside})
        {
            std::sort(from, from == begin ? inside : end,
                      [](const LastingPair& a, const LastingPair& b)
            {
                return a.first != b.first ? a.first < b.first : a.second < b.second;
            });
        }
        chunks_[c].loaded = false;
        Arrays& arrays = chunks_[c].current;
        arrays.count = 0;
        arrays.inside = std::size_t(inside - begin);
        arrays.makeRoom(std::size_t(end - begin));
        for (auto p = begin; p != end; ++p) arrays.push(p->first, p->second, p->x, p->y, p->z, 1);
    });
}

/// Walks through the old contacts in step with the neighbour list.
class PairContacts::OldContacts
{
public:
    OldContacts(const Arrays& arrays, std::size_t at, std::size_t stop)
      : arrays_(arrays), at_(at), stop_(stop)
    {}

    /// Puts (i, j) behind `next`, as it was if it was there, or else if it `mayJoin`; called in
    /// ascending order.
    void carryTo(Arrays& next, std::uint32_t i, std::uint32_t j, bool mayJoin)
    {
        while (at_ < stop_ && (arrays_.first[at_] < i
                               || (arrays_.first[at_] == i && arrays_.second[at_] < j))) ++at_;
        const bool had = at_ < stop_ && arrays_.first[at_] == i && arrays_.second[at_] == j;
        if (had) next.push(i, j, arrays_.x[at_], arrays_.y[at_], arrays_.z[at_],
                           arrays_.touching[at_]);
        else if (mayJoin) next.push(i, j, 0, 0, 0, 0);
    }

private:
    const Arrays& arrays_;
    std::size_t at_, stop_;
};

void PairContacts::refresh(std::size_t c, const SoftCloud& cloud, const PairList& list,
                           const VerletBuffer& buffer)
{
    Chunk& chunk = chunks_[c];
    const Arrays& old = chunk.current;
    // the buffers of the last chunk go round: each thread holds one set more than there are chunks
    static thread_local Arrays next;
    static thread_local std::vector<Pair> later;
    const auto begin = std::uint32_t(runs_.begin(c)), end = std::uint32_t(runs_.end(c));
    const Row* rows = cloud.rows.data();
    const std::uint8_t* weighted = cloud.weighted.empty() ? nullptr : cloud.weighted.data();
    const PeriodicBox& box = cloud.box;
    const bool wraps = box.any();
    const auto choose = [&](OldContacts& before, std::uint32_t i, std::uint32_t j)
    {
        const Row &a = rows[i], &b = rows[j];
        Vector3 apart{a.x - b.x, a.y - b.y, a.z - b.z};
        if (wraps) apart = box.shortest(apart);
        const double sum = a.radius + b.radius, reach = sum + buffer.of(i) + buffer.of(j);
        const double distance2 = squaredNorm(apart);
        if (distance2 >= reach*reach) return;
        // weighted spheres that overlap without a contact pass through each other
        const bool passing = weighted && distance2 < sum*sum && (weighted[i] | weighted[j]);
        before.carryTo(next, i, j, !passing);
    };
    const std::uint32_t last = list.begin[end] - 1;
    next.count = 0;
    later.clear();
    OldContacts inside(old, 0, old.inside), across(old, old.inside, old.count);
    for (std::uint32_t i = begin; i < end; ++i)
    {
        next.makeRoom(list.begin[i + 1] - list.begin[i]);
        for (std::uint32_t k = list.begin[i]; k < list.begin[i + 1]; ++k)
        {
            const std::uint32_t j = list.second[k];
            __builtin_prefetch(rows + list.second[std::min(k + 16, last)]);
            if (j < end) choose(inside, i, j);
            else later.push_back({i, j});
        }
    }
    next.inside = next.count;
    next.makeRoom(later.size());
    for (const Pair& pair : later) choose(across, pair.first, pair.second);
    next.makeRoom(contactBlock);
    std::fill_n(next.touching.begin() + std::ptrdiff_t(next.count), contactBlock, 0);
    std::swap(chunk.current, next);
    widen(chunk.across, chunk.current.count - chunk.current.inside);
}

void PairContacts::connect()
{
    // parts of the chunks, in order: what each has for a chunk is placed behind what those before have
    const std::size_t chunks = chunks_.size(), parts = std::min<std::size_t>(threads_, chunks);
    std::vector<std::uint32_t> places(parts*chunks);
    const auto forAcross = [&](std::size_t part, const auto& visit)
    {
        for (std::size_t c = chunks*part/parts; c < chunks*(part + 1)/parts; ++c)
        {
            const Arrays& a = chunks_[c].current;
            for (std::size_t k = a.inside; k < a.count; ++k)
            {
                if (a.second[k] >= runs_.particles()) continue;      // a ghost: its rank adds it
                const std::size_t to = runs_.of(a.second[k]);
                visit(chunks_[to], places[part*chunks + to],
                      Incoming{std::uint32_t(c), std::uint32_t(k - a.inside), a.second[k]});
            }
        }
    };
    forEach(threads_, parts, [&](std::size_t part)
    {
        forAcross(part, [](Chunk&, std::uint32_t& count, const Incoming&) { ++count; });
    });
    forEach(threads_, chunks, [&](std::size_t c)
    {
        std::uint32_t before = 0;
        for (std::size_t part = 0; part < parts; ++part)
        {
            std::uint32_t& place = places[part*chunks + c];
            const std::uint32_t here = place;
            place = before, before += here;
        }
        chunks_[c].incoming.reserve(before);
        chunks_[c].incoming.resize(before);
    });
    forEach(threads_, parts, [&](std::size_t part)
    {
        forAcross(part, [](Chunk& to, std::uint32_t& place, const Incoming& incoming)
        {
            to.incoming[place++] = incoming;
        });
    });
}

struct PairContacts::Job
{
    Chunk& chunk;
    const SoftCloud& cloud;
    const LawTable& laws;
    StepWeights weights;
};

Contribution PairContacts::transition(void* self, std::size_t k)
{
    const Job& job = *static_cast<Job*>(self);
    Arrays& arrays = job.chunk.current;
    const std::uint32_t i = arrays.first[k], j = arrays.second[k];
    const Row &a = job.cloud.rows[i], &b = job.cloud.rows[j];
    const Vector3 apart = job.cloud.box.shortest({a.x - b.x, a.y - b.y, a.z - b.z});
    const double distance = norm(apart), sum = a.radius + b.radius, share = distance/sum;
    const Vector3 past{double(a.vx) - b.vx, double(a.vy) - b.vy, double(a.vz) - b.vz};
    const Vector3 surface{double(a.sx) + b.sx, double(a.sy) + b.sy, double(a.sz) + b.sz};
    Encounter e;
    e.normal = (1/distance)*apart;
    e.overlap = sum - distance;
    e.slip = past - share*cross(surface, e.normal);
    e.radius = a.radius*b.radius/sum;
    e.mass = 1/(double(a.inverseMass) + b.inverseMass);
    e.normalRate = (1/distance)*(past - dot(past, e.normal)*e.normal);
    ContactHistory history{{arrays.x[k], arrays.y[k], arrays.z[k]}, arrays.touching[k] != 0};
    const laws::Coefficients& c = job.laws(job.cloud.material(i), job.cloud.material(j));
    const ContactForce f = job.laws.law().force(c, e, history, job.weights);
    arrays.x[k] = float(history.displacement.x);
    arrays.y[k] = float(history.displacement.y);
    arrays.z[k] = float(history.displacement.z);
    arrays.touching[k] = history.touching;
    const Vector3 force = f.normal*e.normal + f.tangential;
    const Vector3 moment = -share*cross(e.normal, f.tangential);
    return {float(force.x), float(force.y), float(force.z), 0,
            float(moment.x), float(moment.y), float(moment.z), 0};
}

/// What the kernels do, contact by contact in double precision.
void PairContacts::evaluateSingly(PairWork& w)
{
    w.largestOverlap = 0;
    const Job& job = *static_cast<Job*>(w.self);
    for (std::size_t k = 0; k < w.contacts.count; ++k)
    {
        const std::uint32_t i = w.contacts.first[k], j = w.contacts.second[k];
        const Row &a = w.rows[i], &b = w.rows[j];
        const double sum = a.radius + b.radius;
        const double overlap = sum - norm(job.cloud.box.shortest({a.x - b.x, a.y - b.y, a.z - b.z}));
        if (overlap <= 0 && !w.contacts.touching[k])
        {
            if (k >= w.inside) w.across[k - w.inside] = {};
            continue;
        }
        w.largestOverlap = std::max(w.largestOverlap,
                                    float(0.5*overlap*sum/(a.radius*b.radius)));
        dem::startSums(w.loads, w.begin, w.end, w.loaded);
        w.acrossActs = w.acrossActs || k >= w.inside;
        const Contribution c = transition(w.self, k);
        Load& first = w.loads[i];
        first.fx += c.fx, first.fy += c.fy, first.fz += c.fz;
        first.mx += c.mx, first.my += c.my, first.mz += c.mz;
        if (k >= w.inside)
        {
            w.across[k - w.inside] = c;
            continue;
        }
        Load& second = w.loads[j];
        second.fx -= c.fx, second.fy -= c.fy, second.fz -= c.fz;
        second.mx += c.mx, second.my += c.my, second.mz += c.mz;
    }
}

void PairContacts::evaluate(std::size_t index, SoftCloud& cloud, StepWeights weights)
{
    Chunk& chunk = chunks_[index];
    Arrays& a = chunk.current;
    Job job{chunk, cloud, laws_, weights};
    PairWork work;
    work.rows = cloud.rows.data();
    work.contacts = {a.count, a.first.data(), a.second.data(), a.x.data(), a.y.data(),
                     a.z.data(), a.touching.data()};
    work.inside = a.inside;
    work.begin = runs_.begin(index), work.end = runs_.end(index);
    work.loads = cloud.loads.data();
    work.loaded = chunk.loaded;
    work.across = chunk.across.data();
    work.acrossActs = false;
    for (int axis = 0; axis < 3; ++axis)
    {
        const bool wraps = cloud.box.periodic[axis];
        work.length[axis] = wraps ? cloud.box.high[axis] - cloud.box.low[axis] : 0;
        work.inverseLength[axis] = wraps ? 1/work.length[axis] : 0;
    }
    work.before = weights.before;
    work.after = weights.after;
    work.coefficients = coefficients_.data();
    work.material = cloud.materials.empty() ? nullptr : cloud.materials.data();
    work.materials = laws_.size();
    work.self = &job;
    work.transition = transition;
    if (kernel_ < ContactLaws::size) kernels().pairs[kernel_](work);
    else evaluateSingly(work);
    chunk.largestOverlap = std::max(chunk.largestOverlap, work.largestOverlap);
    chunk.loaded = work.loaded;
    chunk.acrossActs = work.acrossActs;
}

void PairContacts::addRolling(std::size_t index, SoftCloud& cloud, StepWeights weights)
{
    Chunk& chunk = chunks_[index];
    const Arrays& arrays = chunk.current;
    for (std::size_t k = 0; k < arrays.count; ++k)
    {
        if (!arrays.touching[k]) continue;
        const std::uint32_t i = arrays.first[k], j = arrays.second[k];
        const Row &a = cloud.rows[i], &b = cloud.rows[j];
        const double overlap = a.radius + b.radius
            - norm(cloud.box.shortest({a.x - b.x, a.y - b.y, a.z - b.z}));
        const laws::Coefficients& c = laws_(cloud.material(i), cloud.material(j));
        const double radius = a.radius*b.radius/(a.radius + b.radius);
        const double inertia = 0.4/(a.inverseMass/(a.radius*a.radius)
                                    + b.inverseMass/(b.radius*b.radius));
        const Vector3 spin = (1/a.radius)*Vector3{a.sx, a.sy, a.sz}
                             - (1/b.radius)*Vector3{b.sx, b.sy, b.sz};
        const Vector3 torque = rollingTorque(c, laws_.law().elasticForce(c, radius, overlap), radius,
                                             inertia, spin, weights);
        const Vector3 onFirst = (1/a.radius)*torque, onSecond = (-1/b.radius)*torque;
        Load& first = cloud.loads[i];
        first.mx += onFirst.x, first.my += onFirst.y, first.mz += onFirst.z;
        if (k < arrays.inside)
        {
            Load& second = cloud.loads[j];
            second.mx += onSecond.x, second.my += onSecond.y, second.mz += onSecond.z;
        }
        else
        {
            Contribution& second = chunk.across[k - arrays.inside];
            second.mx += float(onSecond.x);
            second.my += float(onSecond.y);
            second.mz += float(onSecond.z);
        }
    }
}

void PairContacts::receive(std::size_t index, SoftCloud& cloud)
{
    Chunk& chunk = chunks_[index];
    for (const Incoming& in : chunk.incoming)
    {
        const Chunk& from = chunks_[in.chunk];
        if (!from.acrossActs) continue;
        if (!chunk.loaded) startSums(index, cloud);
        const Contribution& c = from.across[in.slot];
        Load& load = cloud.loads[in.particle];
        load.fx -= c.fx, load.fy -= c.fy, load.fz -= c.fz;
        load.mx += c.mx, load.my += c.my, load.mz += c.mz;
    }
}

void PairContacts::startSums(std::size_t chunk, SoftCloud& cloud)
{
    dem::startSums(cloud.loads.data(), runs_.begin(chunk), runs_.end(chunk), chunks_[chunk].loaded);
}

double PairContacts::takeLargestOverlap()
{
    double largest = 0;
    for (Chunk& chunk : chunks_)
    {
        largest = std::max(largest, double(chunk.largestOverlap));
        chunk.largestOverlap = 0;
    }
    return largest;
}

std::vector<LastingPair> PairContacts::lasting() const
{
    std::vector<std::size_t> begin(chunks_.size() + 1, 0);
    forEach(threads_, chunks_.size(), [&](std::size_t c) { begin[c + 1] = touching(c); });
    for (std::size_t c = 0; c < chunks_.size(); ++c) begin[c + 1] += begin[c];
    std::vector<LastingPair> all(begin.back());
    forEach(threads_, chunks_.size(), [&](std::size_t c)
    {
        const Arrays& a = chunks_[c].current;
        LastingPair* next = all.data() + begin[c];
        for (std::size_t k = 0; k < a.count; ++k)
        {
            if (a.touching[k]) *next++ = {a.first[k], a.second[k], a.x[k], a.y[k], a.z[k]};
        }
    });
    return all;
}

std::size_t PairContacts::touching(std::size_t chunk) const
{
    const Arrays& a = chunks_[chunk].current;
    return std::size_t(std::count(a.touching.begin(),
                                  a.touching.begin() + std::ptrdiff_t(a.count), 1));
}

std::size_t PairContacts::touching() const
{
    std::size_t count = 0;
    for (std::size_t c = 0; c < chunks_.size(); ++c) count += touching(c);
    return count;
}

std::size_t PairContacts::size() const
{
    std::size_t count = 0;
    for (const Chunk& c : chunks_) count += c.current.count;
    return count;
}

std::size_t PairContacts::bytes() const
{
    std::size_t sum = 0;
    for (const Chunk& c : chunks_)
    {
        sum += c.current.bytes() + c.across.capacity()*sizeof(Contribution)
               + c.incoming.capacity()*sizeof(Incoming);
    }
    return sum;
}

} // namespace elutria::dem

#include "parallel/Gathered.hpp"

#include "parallel/Message.hpp"

#include <algorithm>
#include <array>

namespace elutria::dem
{

namespace
{

using Columns = std::vector<std::vector<double>*>;

void add(Columns& columns, std::initializer_list<VectorArray*> vectors)
{
    for (VectorArray* v : vectors) columns.insert(columns.end(), {&v->x, &v->y, &v->z});
}

Columns sentBack(Particles& p)
{
    Columns columns;
    add(columns, {&p.position, &p.velocity, &p.spin, &p.dragImpulse});
    return columns;
}

Columns sent(Particles& p)
{
    Columns columns = sentBack(p);
    columns.insert(columns.end(),
                   {&p.radius, &p.mass, &p.statisticalWeight, &p.solidFraction, &p.dragRate});
    add(columns, {&p.gasVelocity, &p.acceleration});
    return columns;
}

template<class T>
void append(Incoming& in, std::vector<T>& to)
{
    const auto values = in.get<std::vector<T>>();
    to.insert(to.end(), values.begin(), values.end());
}

} // namespace


Gathered::Gathered(Exchange& exchange, Particles& particles)
  : exchange_(exchange), own_(particles)
{
    if (exchange_.alone()) return;
    std::vector<Outgoing> toEach(exchange_.ranks());
    toEach[0] << own_.id << own_.material;
    for (const std::vector<double>* column : sent(own_)) toEach[0] << *column;
    const std::vector<Bytes> all = exchange_.swap(taken(toEach));
    if (!here()) return;
    all_.stepIndex = own_.stepIndex;
    for (const Bytes& ofRank : all)
    {
        from_.push_back(all_.size());
        Incoming in(ofRank);
        append(in, all_.id);
        append(in, all_.material);
        for (std::vector<double>* column : sent(all_)) append(in, *column);
    }
    from_.push_back(all_.size());
}


void Gathered::giveBack(std::vector<WallHit>& hits)
{
    if (exchange_.alone()) return;
    std::vector<Outgoing> toEach(exchange_.ranks());
    if (here())
    {
        for (Outgoing& out : toEach) out << hits;
        for (const std::vector<double>* column : sentBack(all_))
            for (std::size_t r = 0; r < toEach.size(); ++r)
            {
                // a column may be empty where no rank has given it
                const bool given = column->size() == all_.size();
                toEach[r] << (given ? std::vector<double>(column->begin() + from_[r],
                                                          column->begin() + from_[r + 1])
                                    : std::vector<double>());
            }
    }
    const std::vector<Bytes> back = exchange_.swap(taken(toEach));
    Incoming in(back[0]);
    in >> hits;
    if (!hits.empty())
    {
        std::vector<std::uint64_t> ids = own_.id;
        std::sort(ids.begin(), ids.end());
        hits.erase(std::remove_if(hits.begin(), hits.end(), [&](const WallHit& hit)
                   { return !std::binary_search(ids.begin(), ids.end(), hit.id); }), hits.end());
    }
    for (std::vector<double>* column : sentBack(own_)) in >> *column;
}

} // namespace elutria::dem

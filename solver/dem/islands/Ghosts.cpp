#include "islands/Ghosts.hpp"

namespace elutria::dem
{

std::size_t Ghosts::announce(const std::vector<Bound>& bounds, std::size_t number)
{
    Outgoing out;
    out << number << Hull(bounds);
    hulls_.assign(exchange_.ranks(), {});
    const std::vector<Bytes> all = exchange_.share(out.take());
    std::size_t sum = 0;
    for (std::size_t r = 0; r < all.size(); ++r)
    {
        Incoming in(all[r]);
        sum += in.get<std::size_t>();
        in >> hulls_[r];
    }
    return sum;
}


void Ghosts::fetch(const Piece& piece, const std::vector<Bound>& bounds,
                   std::vector<ParticleState>& ghosts, std::vector<ContactRecord>& contacts)
{
    std::vector<Outgoing> toEach(exchange_.ranks());
    std::vector<ContactRecord> known;
    for (std::size_t i = 0; i < piece.start.size(); ++i)
        forEachTouched(bounds[i], [&](std::size_t r)
        {
            known.clear();
            piece.history.copy(piece.start[i].id, known);
            toEach[r] << piece.start[i] << known;
        });
    for (const Bytes& bytes : exchange_.swap(taken(toEach)))
        for (Incoming in(bytes); !in.atEnd();)
        {
            in >> ghosts.emplace_back() >> known;
            contacts.insert(contacts.end(), known.begin(), known.end());
        }
}

} // namespace elutria::dem

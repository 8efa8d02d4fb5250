#include "laws/LawTable.hpp"

#include "laws/LawList.hpp"

namespace elutria::dem
{

LawTable::LawTable(const ContactLaw& law, const ContactMaterials& materials)
  : law_(&law), size_(materials.size()), table_(size_*size_)
{
    bool otherExponent = false;
    for (std::uint32_t a = 0; a < size_; ++a)
    {
        for (std::uint32_t b = 0; b < size_; ++b)
        {
            const PairProperties& p = materials.pair(a, b);
            laws::Coefficients& c = table_[a*size_ + b];
            c = law.coefficients(materials[a], materials[b], p);
            c.friction = p.friction;
            c.rolling = p.rollingFriction;
            c.cohesion = p.cohesion;
            rolls_ = rolls_ || c.rolling > 0;
            otherExponent = otherExponent || c.exponent != 1.5;
        }
    }
    if (otherExponent && law.name == std::string_view(SpringSliderDashpot::name))
        law_ = &contactLaw<SpringSliderDashpotOfAnyExponent>;
}

} // namespace elutria::dem

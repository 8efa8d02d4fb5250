#include "laws/LawTable.hpp"

namespace elutria::dem
{

LawTable::LawTable(ContactLaw law, const ContactMaterials& materials)
  : law_(law), size_(materials.size()), table_(size_*size_)
{
    for (std::uint32_t a = 0; a < size_; ++a)
    {
        for (std::uint32_t b = 0; b < size_; ++b)
        {
            const ContactMaterial &ma = materials[a], &mb = materials[b];
            const PairProperties& p = materials.pair(a, b);
            const double young = laws::effectiveYoung(ma.youngsModulus, ma.poissonRatio,
                                                      mb.youngsModulus, mb.poissonRatio);
            const double shear = laws::effectiveShear(ma.youngsModulus, ma.poissonRatio,
                                                      mb.youngsModulus, mb.poissonRatio);
            laws::Coefficients& c = table_[a*size_ + b];
            switch (law)
            {
                case ContactLaw::linear:
                    c = laws::linear(p.normalStiffness, p.tangentialRatio, p.restitution);
                    break;
                case ContactLaw::hertz:
                    c = laws::hertz(young, shear, p.restitution);
                    break;
                case ContactLaw::springSliderDashpot:
                    c = laws::springSliderDashpot(young, shear, p.damping, p.exponent);
                    otherExponent_ = otherExponent_ || p.exponent != 1.5;
                    break;
            }
            c.friction = p.friction;
            c.rolling = p.rollingFriction;
            c.cohesion = p.cohesion;
            rolls_ = rolls_ || c.rolling > 0;
        }
    }
}

} // namespace elutria::dem

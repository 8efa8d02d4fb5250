#include "laws/ContactMaterials.hpp"

#include "core/text.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace elutria::dem
{

namespace
{

/// A ten-thousandth of it is diamond; beyond, contact steps are too short to end.
constexpr double stiffest = 1e24;   // Pa

} // namespace

std::uint32_t ContactMaterials::add(const ContactMaterial& material)
{
    materials_.push_back(material);
    pairs_.resize(materials_.size()*(materials_.size() + 1)/2);
    return static_cast<std::uint32_t>(materials_.size() - 1);
}

void ContactMaterials::setPair(std::uint32_t a, std::uint32_t b, const PairProperties& properties)
{
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    if (high >= materials_.size())
    {
        throw std::invalid_argument("contact pair names material " + std::to_string(high)
                                    + "; there are " + std::to_string(materials_.size()));
    }
    pairs_[std::size_t(high)*(high + 1)/2 + low] = properties;
}

void ContactMaterials::check() const
{
    if (materials_.empty()) throw std::invalid_argument("no contact material given");
    for (const ContactMaterial& m : materials_)
    {
        const std::string of = " of contact material '" + m.name + "'";
        require(m.youngsModulus > 0 && m.youngsModulus <= stiffest, "youngsModulus" + of,
                m.youngsModulus, "above 0, up to 1e24 Pa");
        require(m.poissonRatio > -1 && m.poissonRatio <= 0.5, "poissonRatio" + of,
                m.poissonRatio, "above -1, up to 0.5");
    }
    for (std::uint32_t b = 0; b < size(); ++b)
    {
        for (std::uint32_t a = 0; a <= b; ++a)
        {
            const PairProperties& p = pair(a, b);
            const std::string of =
                " of pair '" + materials_[a].name + "' - '" + materials_[b].name + "'";
            require(p.restitution > 0 && p.restitution <= 1, "restitution" + of, p.restitution,
                    "above 0, up to 1");
            require(p.friction >= 0 && std::isfinite(p.friction), "friction" + of, p.friction,
                    "0 or more");
            require(p.rollingFriction >= 0 && std::isfinite(p.rollingFriction),
                    "rollingFriction" + of, p.rollingFriction, "0 or more");
            require(p.cohesion >= 0 && std::isfinite(p.cohesion), "cohesion" + of, p.cohesion,
                    "0 J/m^3 or more");
            require(p.normalStiffness > 0 && std::isfinite(p.normalStiffness),
                    "normalStiffness" + of, p.normalStiffness, "above 0 N/m");
            require(p.tangentialRatio > 0 && p.tangentialRatio <= 10, "tangentialRatio" + of,
                    p.tangentialRatio, "above 0, up to 10");
            require(p.damping >= 0 && std::isfinite(p.damping), "damping" + of, p.damping,
                    "0 or more");
            require(p.exponent >= 1 && p.exponent <= 3, "exponent" + of, p.exponent, "1 to 3");
        }
    }
}

} // namespace elutria::dem

#pragma once

#include "core/Vector3.hpp"
#include "laws/LawTable.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

namespace elutria::dem
{

/// Hard-sphere collision as one impulse: the outcome of the soft law for two solid spheres, or a
/// sphere and a wall, while nothing else touches them.
///
/// With effective mass m, closing speed c and sliding speed s at the contact point, the normal impulse
/// is (1 + e) m c. The tangential impulse, against the sliding, is m c T(s/c): the soft contact law
/// is integrated once for a table over s/c. Large s/c: gross sliding, T = friction*(1 + e) (Walton
/// 1993); small s/c: the contact sticks and T = 2/7 (1 + b) s/c, b being the tangential restitution
/// that the law's spring and dashpot amount to. A law has impacts only if T depends on s/c alone.
///
/// A steady force towards each other (weight on a floor, drag) adds no energy, since it acts on the
/// way in and out alike, but the dashpot takes more: e decreases with g = acceleration*duration/c.
/// e is linear in g up to mostPressing; beyond, a contact is no impact.
class ImpactLaw
{
public:
    ImpactLaw() = default;

    /// Tabulates the law of a pair of materials.
    ImpactLaw(const LawTable& laws, const ContactMaterials& materials, std::uint32_t a,
              std::uint32_t b);

    /// False where one impulse cannot stand for the contact: cohesion, a law that says so
    /// (ContactLaw::impactSuffices), and a rolling resistance so strong that it competes with the
    /// friction.
    bool applies() const { return applies_; }
    double restitution() const { return restitution_; }
    /// Under a force that changes the closing speed by the fraction `pressing` during the contact.
    double restitution(double pressing) const
    {
        return std::clamp(restitution_ + pressingSlope_*pressing, 0.0, 1.0);
    }
    static constexpr double mostPressing = 0.02;
    double rolling() const { return coefficients_.rolling; }

    /// T above, for the ratio s/c >= 0.
    double tangentialImpulse(double ratio) const
    {
        const double place = ratio*inverseSpacing_;
        if (place >= double(table_.size() - 1)) return table_.back();
        const auto k = static_cast<std::size_t>(place);
        return table_[k] + (place - double(k))*(table_[k + 1] - table_[k]);
    }

    /// Duration of the contact, s, at closing speed c (m/s).
    double duration(double effectiveMass, double effectiveRadius, double closingSpeed) const
    {
        return dimensionlessTime_
               *law_->timeScale(coefficients_, effectiveRadius, effectiveMass, closingSpeed);
    }
    /// Largest overlap of an elastic contact of that duration, m.
    double depth(double duration, double closingSpeed) const
    {
        return duration*closingSpeed/law_->wayOverOverlap;
    }

private:
    const ContactLaw* law_ = nullptr;
    laws::Coefficients coefficients_;
    bool applies_ = false;
    double restitution_ = 1, pressingSlope_ = 0;
    double dimensionlessTime_ = 1;
    double inverseSpacing_ = 0;
    std::vector<double> table_{0.0, 0.0};
};

/// The impact laws of every pair of materials.
class ImpactTable
{
public:
    ImpactTable(const LawTable& laws, const ContactMaterials& materials);

    const ImpactLaw& operator()(std::uint32_t a, std::uint32_t b) const
    {
        return laws_[a < b ? b*(b + 1)/2 + a : a*(a + 1)/2 + b];
    }

private:
    std::vector<ImpactLaw> laws_;
};

/// Of particles with each other, and with walls.
class ImpactLaws
{
public:
    ImpactLaws(const LawTables& laws, const ContactMaterials& materials)
      : pairs_(laws.pairs, materials)
    {
        if (!laws.alike()) walls_.emplace(laws.walls, materials);
    }

    const ImpactTable& pairs() const { return pairs_; }
    const ImpactTable& walls() const { return walls_ ? *walls_ : pairs_; }

private:
    ImpactTable pairs_;
    std::optional<ImpactTable> walls_;         // where their law is another one
};

/// A sphere as an impact sees it; a wall has inverseMass 0 and radius 0.
struct ImpactBody
{
    double radius = 0, inverseMass = 0;
    Vector3 velocity, spin;
};

/// Applies the impulse, and the rolling resistance after it; `normal` is the unit vector from b to
/// a, `pressing` as in ImpactLaw::restitution. Momentum and angular momentum are kept to rounding,
/// kinetic energy never grows. Returns false, changing nothing, unless the two approach each other.
bool collide(ImpactBody& a, ImpactBody& b, const Vector3& normal, const ImpactLaw& law,
             double pressing = 0);

} // namespace elutria::dem

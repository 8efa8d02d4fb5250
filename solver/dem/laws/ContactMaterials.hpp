#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace elutria::dem
{

/// What a particle or a wall is made of, as far as contacts are concerned.
struct ContactMaterial
{
    std::string name;
    double youngsModulus = 1e7;    // Pa
    double poissonRatio = 0.3;
};

/// What two materials do to each other.
struct PairProperties
{
    double restitution = 0.9;      // in (0, 1]
    double friction = 0.3;         // Coulomb coefficient, >= 0
    double rollingFriction = 0;    // rolling resistance torque over (normal force x effective radius)
    double cohesion = 0;           // J/m^3, cohesion energy density: pull per contact area
    double normalStiffness = 1e4;  // N/m, linear law only
    double tangentialRatio = 2.0/7;   // tangential over normal stiffness, linear law only
    // spring-slider-dashpot law only (instead of restitution):
    double damping = 0.12;         // alpha
    double exponent = 1.5;         // b, of the overlap
};

/// Materials and the properties of every pair of them.
class ContactMaterials
{
public:
    /// Index of the added material; its pairs get default properties.
    std::uint32_t add(const ContactMaterial& material);

    void setPair(std::uint32_t a, std::uint32_t b, const PairProperties& properties);

    std::size_t size() const { return materials_.size(); }
    const ContactMaterial& operator[](std::uint32_t a) const { return materials_[a]; }
    const PairProperties& pair(std::uint32_t a, std::uint32_t b) const
    {
        return pairs_[a < b ? b*(b + 1)/2 + a : a*(a + 1)/2 + b];
    }

    /// Throws std::invalid_argument naming the first value that is not allowed.
    void check() const;

private:
    std::vector<ContactMaterial> materials_;
    std::vector<PairProperties> pairs_;    // lower triangle, row by row
};

} // namespace elutria::dem

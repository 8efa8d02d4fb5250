#pragma once

#include "laws/ContactLaw.hpp"
#include "laws/Settings.hpp"

#include <vector>

namespace elutria::dem
{

/// Contact coefficients of every pair of materials, under one law.
class LawTable
{
public:
    LawTable(const ContactLaw& law, const ContactMaterials& materials);

    /// The law asked for, or its form for any exponent where a pair of materials needs that.
    const ContactLaw& law() const { return *law_; }

    const laws::Coefficients& operator()(std::uint32_t a, std::uint32_t b) const
    {
        return table_[a*size_ + b];
    }
    std::size_t size() const { return size_; }
    bool rolls() const { return rolls_; }

private:
    const ContactLaw* law_;
    std::size_t size_;
    std::vector<laws::Coefficients> table_;
    bool rolls_ = false;
};

/// The coefficients of particles with each other, and with walls.
struct LawTables
{
    LawTable pairs, walls;

    LawTables(const Settings& settings, const ContactMaterials& materials)
      : pairs(*settings.law, materials), walls(settings.lawAtWalls(), materials)
    {}

    bool alike() const { return &pairs.law() == &walls.law(); }

    /// Calls visit(table, a, b) for every pair of materials, under each law once.
    template<class Visit>
    void forEach(const Visit& visit) const
    {
        forEach(pairs, visit);
        if (!alike()) forEach(walls, visit);
    }

private:
    template<class Visit>
    static void forEach(const LawTable& table, const Visit& visit)
    {
        for (std::uint32_t a = 0; a < table.size(); ++a)
            for (std::uint32_t b = 0; b <= a; ++b) visit(table, a, b);
    }
};

} // namespace elutria::dem

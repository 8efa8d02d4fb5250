#pragma once

#include "laws/Settings.hpp"
#include "laws/laws.hpp"

#include <vector>

namespace elutria::dem
{

/// Contact coefficients of every pair of materials, under one law.
class LawTable
{
public:
    LawTable(ContactLaw law, const ContactMaterials& materials);

    ContactLaw law() const { return law_; }

    const laws::Coefficients& operator()(std::uint32_t a, std::uint32_t b) const
    {
        return table_[a*size_ + b];
    }
    std::size_t size() const { return size_; }
    bool rolls() const { return rolls_; }
    bool otherExponent() const { return otherExponent_; }

private:
    ContactLaw law_;
    std::size_t size_;
    std::vector<laws::Coefficients> table_;
    bool rolls_ = false, otherExponent_ = false;
};

} // namespace elutria::dem

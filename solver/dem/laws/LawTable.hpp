#pragma once

#include "laws/ContactLaw.hpp"

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

} // namespace elutria::dem

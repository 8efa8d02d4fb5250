#include "MeasuredDrag.hpp"

#include "CsvTable.hpp"
#include "drag/SchillerNaumann.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace elutria::laws
{

std::vector<TerminalVelocity> velocityTable(const std::string& csv)
{
    const CsvTable table(csv);
    const CsvTable::Column size = table.sizes();
    const int velocity = table.find("velocity_m_s");
    if (velocity < 0) table.refuseHeader("velocity_m_s, beside the sizes");

    std::vector<TerminalVelocity> found;
    for (std::size_t i = 0; i < table.size(); ++i)
        found.push_back({size.unit*table.number(i, size.index), table.number(i, velocity)});
    return found;
}


MeasuredDrag::MeasuredDrag(std::vector<TerminalVelocity> table, double density, double gasDensity,
                           double gasViscosity, double gravity)
{
    const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
    if (table.size() < 2) refuse("it has fewer than two sizes, allowed: at least two");
    std::sort(table.begin(), table.end(),
              [](const auto& a, const auto& b) { return a.diameter < b.diameter; });

    double smaller = 0, slower = 0;
    for (const TerminalVelocity& one : table)
    {
        const double d = one.diameter, v = one.velocity;
        if (!(d > smaller)) refuse("diameter " + csvText(d) + " m, allowed: sizes above 0, each once");
        if (!(v > slower))
            refuse("velocity " + csvText(v) + " m/s at " + csvText(d)
                   + " m, allowed: above 0, and rising with the size");
        smaller = d;
        slower = v;

        const double Re = gasDensity*v*d/gasViscosity;
        const double weight = (density - gasDensity)*gravity*d*d/(0.75*gasViscosity*v);
        logRe_.push_back(std::log(Re));
        logRatio_.push_back(std::log(weight/SchillerNaumann::CdRe(Re, 1, {})));
    }
    smallest_ = table.front().diameter;
    largest_ = table.back().diameter;
}


double MeasuredDrag::CdRe(double Re) const
{
    const double x = std::log(std::max(Re, 1e-300));
    const auto above = std::upper_bound(logRe_.begin(), logRe_.end(), x);
    double ratio = above == logRe_.begin() ? logRatio_.front() : logRatio_.back();
    if (above != logRe_.begin() && above != logRe_.end())
    {
        const std::size_t i = above - logRe_.begin();
        const double s = (x - logRe_[i - 1])/(logRe_[i] - logRe_[i - 1]);
        ratio = logRatio_[i - 1] + s*(logRatio_[i] - logRatio_[i - 1]);
    }
    return std::exp(ratio)*SchillerNaumann::CdRe(Re, 1, {});
}


double MeasuredDrag::largestRe() const { return std::exp(logRe_.back()); }

} // namespace elutria::laws

// A feed's rate over time: linear between the times of a table, its integral, and the inverse of that.
#pragma once

#include <vector>

namespace elutria::laws
{

class RateTable
{
public:
    /// times: s, rising; rates: kg/s, 0 or more, of the same number. Throws std::invalid_argument
    /// that says what is allowed.
    RateTable(std::vector<double> times, std::vector<double> rates);

    double begin() const { return time_.front(); }
    double end() const { return time_.back(); }

    const std::vector<double>& times() const { return time_; }
    const std::vector<double>& rates() const { return rate_; }

    /// Largest rate, kg/s.
    double peak() const;

    /// Mass between two times, kg. What is outside of the table counts as its end.
    double mass(double from, double to) const { return until(to) - until(from); }

    /// First time at which the mass since another is so much, s; the table's end where it has less.
    double timeOf(double mass, double from) const;

private:
    /// Mass from the table's begin on, kg.
    double until(double time) const;

    std::vector<double> time_, rate_;
    std::vector<double> mass_;      // at each time, from the begin on, kg
};

} // namespace elutria::laws

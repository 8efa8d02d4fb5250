#pragma once

#include <chrono>

namespace elutria::dem
{

/// Adds the wall time of its life to a total, s.
class Stopwatch
{
public:
    explicit Stopwatch(double& total) : total_(total) {}
    Stopwatch(const Stopwatch&) = delete;
    ~Stopwatch()
    {
        total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    double& total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace elutria::dem

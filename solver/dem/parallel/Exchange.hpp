#pragma once

#include "core/Stopwatch.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace elutria::dem
{

using Bytes = std::vector<char>;

/// What ranks (processors with particles of their own) tell each other. All ranks make the same calls
/// in the same order.
class Exchange
{
public:
    /// Of all calls so far.
    struct Traffic
    {
        double seconds = 0;              // wall time, waiting for others included
        std::size_t calls = 0;           // each a message to every other rank, or none
        std::size_t bytes = 0;           // sent to other ranks
    };

    /// Another rank that gets a message and sends one of a size that is known.
    struct Partner
    {
        int rank;
        Bytes sent, received;
    };

    virtual ~Exchange() = default;

    virtual int rank() const = 0;        // 0 to ranks() - 1
    virtual int ranks() const = 0;
    bool alone() const { return ranks() == 1; }

    /// Sends toEach[r] to rank r, for each r. Returns what each rank sent here, by rank.
    std::vector<Bytes> swap(std::vector<Bytes> toEach)
    {
        if (alone()) return toEach;
        const Stopwatch watch(traffic_.seconds);
        ++traffic_.calls;
        for (std::size_t r = 0; r < toEach.size(); ++r)
            if (int(r) != rank()) traffic_.bytes += toEach[r].size();
        return doSwap(std::move(toEach));
    }
    /// What every rank has to say to everyone, by rank.
    std::vector<Bytes> share(Bytes mine)
    {
        if (alone()) return {std::move(mine)};
        const Stopwatch watch(traffic_.seconds);
        ++traffic_.calls;
        traffic_.bytes += mine.size()*std::size_t(ranks() - 1);
        return doShare(std::move(mine));
    }
    /// Where both sides know how much is to come: sends each partner's `sent` to it and fills its
    /// `received`. Ranks that are no partners take no part in it, but make the call.
    void swapWith(std::vector<Partner>& partners)
    {
        if (alone()) return;
        const Stopwatch watch(traffic_.seconds);
        ++traffic_.calls;
        for (const Partner& partner : partners) traffic_.bytes += partner.sent.size();
        doSwapWith(partners);
    }
    /// Each value becomes its sum over all ranks, with the same bits on each.
    void sum(std::vector<double>& values)
    {
        if (alone()) return;
        const Stopwatch watch(traffic_.seconds);
        ++traffic_.calls;
        traffic_.bytes += values.size()*sizeof(double);
        doSum(values);
    }
    const Traffic& traffic() const { return traffic_; }

protected:
    Exchange() = default;
    virtual std::vector<Bytes> doSwap(std::vector<Bytes> toEach) = 0;
    virtual std::vector<Bytes> doShare(Bytes mine) = 0;
    virtual void doSwapWith(std::vector<Partner>& partners) = 0;
    virtual void doSum(std::vector<double>& values) = 0;

private:
    Traffic traffic_;
};


/// A single rank: what is sent comes back.
class Alone final : public Exchange
{
public:
    int rank() const override { return 0; }
    int ranks() const override { return 1; }

private:
    std::vector<Bytes> doSwap(std::vector<Bytes> toEach) override { return toEach; }
    std::vector<Bytes> doShare(Bytes mine) override { return {std::move(mine)}; }
    void doSwapWith(std::vector<Partner>&) override {}
    void doSum(std::vector<double>&) override {}
};

/// For engines that have all particles.
inline Exchange& alone()
{
    static Alone one;
    return one;
}

} // namespace elutria::dem

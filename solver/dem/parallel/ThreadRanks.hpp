#pragma once

#include "parallel/Exchange.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace elutria::dem
{

/// Ranks as threads of one program: each rank's thread has an Exchange of its own.
class ThreadRanks
{
public:
    /// Where each rank has a core, waiting threads may spin: they go on sooner.
    explicit ThreadRanks(int ranks, bool spin = false)
      : mail_(ranks, std::vector<Bytes>(ranks)), spins_(spin ? 1 << 24 : 0)
    {
        for (auto& letters : letters_) letters = mail_;
        for (auto& terms : terms_) terms.resize(ranks);
    }

    /// Calls work(exchange) for every rank, each in a thread; passes the first rank's exception on.
    template<class Work>
    void run(const Work& work)
    {
        std::vector<std::thread> threads;
        std::vector<std::exception_ptr> errors(mail_.size());
        for (std::size_t r = 0; r < mail_.size(); ++r)
            threads.emplace_back([&, r]
            {
                Rank exchange(*this, int(r));
                try { work(static_cast<Exchange&>(exchange)); }
                catch (...) { errors[r] = std::current_exception(); }
            });
        for (std::thread& thread : threads) thread.join();
        for (const std::exception_ptr& error : errors)
            if (error) std::rethrow_exception(error);
    }

private:
    class Rank final : public Exchange
    {
    public:
        Rank(ThreadRanks& all, int rank) : all_(all), rank_(rank) {}
        int rank() const override { return rank_; }
        int ranks() const override { return int(all_.mail_.size()); }

    private:
        std::vector<Bytes> doSwap(std::vector<Bytes> toEach) override
        {
            for (int r = 0; r < ranks(); ++r) all_.mail_[r][rank_] = std::move(toEach[r]);
            all_.wait();
            std::vector<Bytes> got = std::move(all_.mail_[rank_]);
            all_.mail_[rank_].assign(ranks(), {});
            all_.wait();
            return got;
        }
        std::vector<Bytes> doShare(Bytes mine) override
        {
            return doSwap(std::vector<Bytes>(ranks(), mine));
        }

        void doSwapWith(std::vector<Partner>& partners) override
        {
            const unsigned parity = round_++ % 2;
            for (const Partner& p : partners) all_.letters_[parity][rank_][p.rank] = p.sent;
            all_.wait();
            for (Partner& p : partners)
            {
                const Bytes& letter = all_.letters_[parity][p.rank][rank_];
                if (letter.size() != p.received.size())
                    throw std::logic_error("a message is not as long as expected");
                p.received = letter;
            }
        }
        void doSum(std::vector<double>& values) override
        {
            const unsigned parity = round_++ % 2;
            all_.terms_[parity][rank_] = values;
            all_.wait();
            std::fill(values.begin(), values.end(), 0.0);
            for (const std::vector<double>& ofRank : all_.terms_[parity])
                for (std::size_t k = 0; k < values.size(); ++k) values[k] += ofRank[k];
        }

        ThreadRanks& all_;
        int rank_;
        unsigned round_ = 0;             // of what is kept by turns: others may still read the last
    };

    /// Until all ranks are here: a while without giving up the core.
    void wait()
    {
        const std::size_t round = round_.load(std::memory_order_acquire);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == mail_.size())
        {
            arrived_.store(0, std::memory_order_relaxed);
            const std::lock_guard<std::mutex> lock(mutex_);
            round_.store(round + 1, std::memory_order_release);
            all_.notify_all();
            return;
        }
        for (int spin = 0; spin < spins_; ++spin)
            if (round_.load(std::memory_order_acquire) != round) return;
        std::unique_lock<std::mutex> lock(mutex_);
        all_.wait(lock, [&] { return round_.load(std::memory_order_acquire) != round; });
    }

    std::vector<std::vector<Bytes>> mail_;     // to each rank, from each
    std::mutex mutex_;
    std::condition_variable all_;
    std::atomic<std::size_t> arrived_{0}, round_{0};
    std::vector<std::vector<Bytes>> letters_[2];           // from each rank, to each
    std::vector<std::vector<double>> terms_[2];            // of each rank
    int spins_;
};

} // namespace elutria::dem

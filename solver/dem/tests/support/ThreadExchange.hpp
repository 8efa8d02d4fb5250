#pragma once

#include "parallel/Exchange.hpp"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace elutria::dem
{

/// Ranks as threads of one program: each rank's thread has an Exchange of its own.
class ThreadRanks
{
public:
    explicit ThreadRanks(int ranks) : mail_(ranks, std::vector<Bytes>(ranks)) {}

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

        ThreadRanks& all_;
        int rank_;
    };

    /// Until all ranks are here.
    void wait()
    {
        std::unique_lock<std::mutex> lock(mutex_);
        const std::size_t round = round_;
        if (++arrived_ == mail_.size())
        {
            arrived_ = 0, ++round_;
            all_.notify_all();
            return;
        }
        all_.wait(lock, [&] { return round_ != round; });
    }

    std::vector<std::vector<Bytes>> mail_;     // to each rank, from each
    std::mutex mutex_;
    std::condition_variable all_;
    std::size_t arrived_ = 0, round_ = 0;
};

} // namespace elutria::dem

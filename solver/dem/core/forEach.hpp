#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <omp.h>
#include <vector>

namespace elutria::dem
{

/// The calls that a thread begins with; others take from them once their own are done.
struct alignas(64) ThreadShare
{
    std::atomic<std::size_t> next{0};
    std::size_t end = 0;
};

/// Calls work(0) .. work(count - 1) on up to `threads` threads; what they do must not depend on
/// the order. Mostly the same thread makes the same call each time, so that what it works on stays in
/// its core's cache. The first exception is passed on.
template<class Work>
void forEach(unsigned threads, std::size_t count, const Work& work)
{
    threads = unsigned(std::min<std::size_t>(threads, count));
    if (threads <= 1)
    {
        for (std::size_t k = 0; k < count; ++k) work(k);
        return;
    }
    std::exception_ptr error;
    std::vector<ThreadShare> shares(threads);
    for (std::size_t t = 0; t < threads; ++t)
        shares[t].next = count*t/threads, shares[t].end = count*(t + 1)/threads;
#pragma omp parallel num_threads(threads)
    for (unsigned t = 0; t < threads; ++t)
    {
        ThreadShare& share = shares[(unsigned(omp_get_thread_num()) + t) % threads];
        while (share.next.load(std::memory_order_relaxed) < share.end)
        {
            const std::size_t k = share.next.fetch_add(1, std::memory_order_relaxed);
            if (k >= share.end) break;
            try
            {
                work(k);
            }
            catch (...)
            {
#pragma omp critical(elutriaForEach)
                error = std::current_exception();
            }
        }
    }
    if (error) std::rethrow_exception(error);
}

constexpr std::size_t elementBlock = 2048;                // that a thread takes at a time
constexpr std::size_t manyElements = 4*elementBlock;      // worth a second thread

/// Threads to be used for work on so many elements.
inline unsigned threadsFor(std::size_t elements, unsigned most)
{
    return elements < manyElements ? 1 : most;
}

/// What work(begin, end) returns for each block of elements, in their order: a sum over it does not
/// depend on the number of threads.
template<class Work>
auto forBlocks(unsigned mostThreads, std::size_t count, const Work& work)
{
    std::vector<decltype(work(count, count))> found((count + elementBlock - 1)/elementBlock);
    forEach(threadsFor(count, mostThreads), found.size(), [&](std::size_t k)
    {
        found[k] = work(k*elementBlock, std::min(count, (k + 1)*elementBlock));
    });
    return found;
}

/// Calls work(0) .. work(count - 1), in any order, where each call is short.
template<class Work>
void forElements(unsigned mostThreads, std::size_t count, const Work& work)
{
    forEach(threadsFor(count, mostThreads), (count + elementBlock - 1)/elementBlock,
            [&](std::size_t k)
    {
        const std::size_t end = std::min(count, (k + 1)*elementBlock);
        for (std::size_t i = k*elementBlock; i < end; ++i) work(i);
    });
}

} // namespace elutria::dem

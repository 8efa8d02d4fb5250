#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>

namespace elutria::dem
{

/// Calls work(0) .. work(count - 1) on up to `threads` threads; what they do must not depend on
/// the order. The first exception is passed on.
template<class Work>
void forEach(unsigned threads, std::size_t count, const Work& work)
{
    if (threads <= 1 || count <= 1)
    {
        for (std::size_t k = 0; k < count; ++k) work(k);
        return;
    }
    std::exception_ptr error;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (std::size_t k = 0; k < count; ++k)
    {
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
    if (error) std::rethrow_exception(error);
}

constexpr std::size_t elementBlock = 2048;                // that a thread takes at a time
constexpr std::size_t manyElements = 4*elementBlock;      // worth a second thread

/// Threads to be used for work on so many elements.
inline unsigned threadsFor(std::size_t elements, unsigned most)
{
    return elements < manyElements ? 1 : most;
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

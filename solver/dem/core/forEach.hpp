#pragma once

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

} // namespace elutria::dem

#include "core/threads.hpp"

#include <algorithm>
#include <omp.h>

namespace elutria::dem
{

unsigned threadsOfProcess()
{
    return unsigned(std::max(1, std::min(omp_get_num_procs(), omp_get_thread_limit())));
}

} // namespace elutria::dem

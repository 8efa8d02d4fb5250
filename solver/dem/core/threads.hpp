#pragma once

namespace elutria::dem
{

/// Threads that the system and OMP_THREAD_LIMIT let this process run at the same time.
unsigned threadsOfProcess();

} // namespace elutria::dem

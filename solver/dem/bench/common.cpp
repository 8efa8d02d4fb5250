#include "bench.hpp"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <stdexcept>
#include <unistd.h>

using namespace elutria::dem;

NeighbourSearch searchNamed(const std::string& name)
{
    static const std::map<std::string, NeighbourSearch> names{
        {"automatic", NeighbourSearch::automatic}, {"bruteForce", NeighbourSearch::bruteForce},
        {"cells", NeighbourSearch::cells}, {"verlet", NeighbourSearch::verlet},
        {"hierarchical", NeighbourSearch::hierarchical}};
    const auto at = names.find(name);
    if (at == names.end())
    {
        throw std::invalid_argument("search is '" + name
            + "'; allowed: automatic bruteForce cells verlet hierarchical");
    }
    return at->second;
}

double seconds()
{
    using namespace std::chrono;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}

double processorSeconds()
{
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9*double(t.tv_nsec);
}

double residentBytes()
{
    long pages = 0, resident = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r"))
    {
        if (std::fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
        std::fclose(file);
    }
    return double(resident)*double(sysconf(_SC_PAGESIZE));
}

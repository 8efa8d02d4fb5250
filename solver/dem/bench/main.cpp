// Timed runs of the engine alone; one JSON object per line.
//   elutriaDemBench box KEY=VALUE ...          see box.cpp
//   elutriaDemBench neighbours KEY=VALUE ...   see neighbours.cpp
//   elutriaDemBench column KEY=VALUE ...       see column.cpp
//   elutriaDemBench threads KEY=VALUE ...      see threads.cpp
//   elutriaDemBench ranks KEY=VALUE ...        see ranks.cpp

#include "bench.hpp"

#include <exception>
#include <iostream>

int main(int argc, char** argv)
{
    try
    {
        const std::string mode = argc > 1 ? argv[1] : "";
        const Options options(argc, argv);
        if (mode == "box") return runBox(options);
        if (mode == "neighbours") return runNeighbours(options);
        if (mode == "column") return runColumn(options);
        if (mode == "threads") return runThreads(options);
        if (mode == "ranks") return runRanks(options);
        std::cerr << "usage: elutriaDemBench box|neighbours|column|threads|ranks KEY=VALUE ...\n";
        return 2;
    }
    catch (const std::exception& error)
    {
        std::cerr << "elutriaDemBench: " << error.what() << "\n";
        return 2;
    }
}

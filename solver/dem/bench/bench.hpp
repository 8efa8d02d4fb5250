#pragma once

#include "engine/Engine.hpp"

#include <map>
#include <stdexcept>
#include <string>

/// KEY=VALUE arguments behind the mode.
class Options
{
public:
    Options(int argc, char** argv)
    {
        for (int k = 2; k < argc; ++k)
        {
            const std::string argument = argv[k];
            const auto equals = argument.find('=');
            if (equals == std::string::npos)
            {
                throw std::invalid_argument("'" + argument + "' is not of the form KEY=VALUE");
            }
            values_[argument.substr(0, equals)] = argument.substr(equals + 1);
        }
    }
    double number(const std::string& key, double otherwise) const
    {
        const auto at = values_.find(key);
        return at == values_.end() ? otherwise : std::stod(at->second);
    }
    std::string text(const std::string& key, const std::string& otherwise) const
    {
        const auto at = values_.find(key);
        return at == values_.end() ? otherwise : at->second;
    }

private:
    std::map<std::string, std::string> values_;
};

elutria::dem::NeighbourSearch searchNamed(const std::string& name);
double seconds();                       // of a steady clock
double processorSeconds();              // used by this process, all threads
double residentBytes();                 // of this process, now

int runBox(const Options& options);
int runNeighbours(const Options& options);
int runColumn(const Options& options);
int runThreads(const Options& options);
int runRanks(const Options& options);

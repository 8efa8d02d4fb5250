// A warning: what is wrong, by how much, and what to set.
#pragma once

#include <string>

namespace elutria::dem
{

struct Warning
{
    std::string name;       // one word, the same in all runs
    std::string what, howMuch, whatToSet;
    double size;            // of the same warning the larger is the worse

    std::string text() const { return what + ": " + howMuch + "; " + whatToSet; }
};

} // namespace elutria::dem

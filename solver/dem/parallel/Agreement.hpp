#pragma once

#include "parallel/Exchange.hpp"

#include <exception>
#include <functional>

namespace elutria::dem
{

/// As share() of what `make` returns; but where it throws on any rank, all throw what the first of
/// these ranks threw: else the others would wait for it without end.
std::vector<Bytes> shareMade(Exchange& exchange, const std::function<Bytes()>& make);

/// Work of each rank that must succeed on all.
inline void together(Exchange& exchange, const std::function<void()>& work)
{
    if (exchange.alone()) return work();
    shareMade(exchange, [&] { work(); return Bytes{}; });
}

} // namespace elutria::dem

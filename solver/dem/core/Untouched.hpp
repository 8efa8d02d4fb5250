#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace elutria::dem
{

/// Leaves new elements as the memory is: the thread that writes them first gets their pages.
template<class T>
struct UntouchedMemory : std::allocator<T>
{
    template<class U>
    struct rebind { using other = UntouchedMemory<U>; };

    UntouchedMemory() = default;
    template<class U>
    UntouchedMemory(const UntouchedMemory<U>&) {}

    template<class U>
    void construct(U* at) { ::new(static_cast<void*>(at)) U; }
    template<class U, class... From>
    void construct(U* at, From&&... from) { ::new(static_cast<void*>(at)) U(std::forward<From>(from)...); }
};

template<class T>
using Untouched = std::vector<T, UntouchedMemory<T>>;

} // namespace elutria::dem

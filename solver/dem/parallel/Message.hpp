#pragma once

#include "parallel/Exchange.hpp"

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

namespace elutria::dem
{

/// Writes plain values and arrays of them one behind the other.
class Outgoing
{
public:
    template<class T>
    Outgoing& operator<<(const T& value)
    {
        append(&value, 1);
        return *this;
    }
    template<class T>
    Outgoing& operator<<(const std::vector<T>& values)
    {
        *this << std::uint64_t(values.size());
        append(values.data(), values.size());
        return *this;
    }
    Outgoing& operator<<(const std::string& text)
    {
        return *this << Bytes(text.begin(), text.end());
    }

    bool empty() const { return bytes_.empty(); }
    Bytes take() { return std::move(bytes_); }

private:
    template<class T>
    void append(const T* values, std::size_t count)
    {
        static_assert(std::is_trivially_copyable<T>::value, "sent as its bytes");
        const auto* from = reinterpret_cast<const char*>(values);
        bytes_.insert(bytes_.end(), from, from + count*sizeof(T));
    }

    Bytes bytes_;
};


/// Reads what an Outgoing wrote, in the same order. The bytes must outlive it.
class Incoming
{
public:
    explicit Incoming(const Bytes& bytes) : at_(bytes.data()), end_(at_ + bytes.size()) {}

    bool atEnd() const { return at_ == end_; }

    template<class T>
    Incoming& operator>>(T& value)
    {
        copy(&value, 1);
        return *this;
    }
    template<class T>
    Incoming& operator>>(std::vector<T>& values)
    {
        values.resize(get<std::uint64_t>());
        copy(values.data(), values.size());
        return *this;
    }
    Incoming& operator>>(std::string& text)
    {
        const Bytes bytes = get<Bytes>();
        text.assign(bytes.begin(), bytes.end());
        return *this;
    }
    template<class T>
    T get()
    {
        T value{};
        *this >> value;
        return value;
    }

private:
    template<class T>
    void copy(T* values, std::size_t count)
    {
        static_assert(std::is_trivially_copyable<T>::value, "sent as its bytes");
        if (count > 0) std::memcpy(static_cast<void*>(values), at_, count*sizeof(T));
        at_ += count*sizeof(T);
    }

    const char* at_;
    const char* end_;
};


/// What each rank has to say, by rank.
template<class T>
std::vector<T> shareEach(Exchange& exchange, const T& mine)
{
    Outgoing out;
    out << mine;
    std::vector<T> all;
    for (const Bytes& bytes : exchange.share(out.take())) all.push_back(Incoming(bytes).get<T>());
    return all;
}

/// What all ranks have of a list, in the order of ranks.
template<class T>
std::vector<T> joined(const std::vector<std::vector<T>>& lists)
{
    std::vector<T> all;
    for (const std::vector<T>& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

/// The messages that one rank has for each of the others.
inline std::vector<Bytes> taken(std::vector<Outgoing>& toEach)
{
    std::vector<Bytes> bytes;
    for (Outgoing& out : toEach) bytes.push_back(out.take());
    return bytes;
}

} // namespace elutria::dem

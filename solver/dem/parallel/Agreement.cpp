#include "parallel/Agreement.hpp"

#include "core/TooMuchWork.hpp"
#include "parallel/Message.hpp"

#include <exception>
#include <stdexcept>

namespace elutria::dem
{

namespace
{

enum class Failure { none, notAllowed, tooMuchWork, other };

[[noreturn]] void fail(Failure kind, const std::string& text)
{
    if (kind == Failure::notAllowed) throw std::invalid_argument(text);
    if (kind == Failure::tooMuchWork) throw TooMuchWork(text);
    throw std::runtime_error(text);
}

} // namespace


std::vector<Bytes> shareMade(Exchange& exchange, const std::function<Bytes()>& make)
{
    if (exchange.alone()) return exchange.share(make());
    Failure kind = Failure::none;
    std::string text;
    Bytes mine;
    const auto failed = [&](Failure why, const std::exception& error)
    {
        kind = why, text = error.what();
    };
    try { mine = make(); }
    catch (const std::invalid_argument& error) { failed(Failure::notAllowed, error); }
    catch (const TooMuchWork& error) { failed(Failure::tooMuchWork, error); }
    catch (const std::exception& error) { failed(Failure::other, error); }

    Outgoing out;
    out << kind;
    if (kind == Failure::none) out << mine;
    else out << text;
    std::vector<Bytes> all = exchange.share(out.take());
    for (Bytes& bytes : all)
    {
        Incoming in(bytes);
        const auto theirs = in.get<Failure>();
        if (theirs != Failure::none) fail(theirs, in.get<std::string>());
        Bytes made = in.get<Bytes>();
        bytes.swap(made);
    }
    return all;
}

} // namespace elutria::dem

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/BatchedLog.H"

#include <cerrno>
#include <iostream>
#include <unistd.h>

namespace Foam
{

namespace
{

using clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds longest(100);

constexpr std::size_t most = 1 << 16;

} // End anonymous namespace


BatchedLog* BatchedLog::current_ = nullptr;


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void BatchedLog::write()
{
    const char* next = waiting_.data();
    const char* const end = next + waiting_.size();
    while (next < end)
    {
        const ssize_t count = ::write(STDOUT_FILENO, next, end - next);
        if (count > 0)
        {
            next += count;
        }
        else if (errno != EINTR)
        {
            break;      // a full disk: the run is worth more than its log
        }
    }
    waiting_.clear();
}


// * * * * * * * * * * * * Protected Member Functions  * * * * * * * * * * * //

std::streambuf::int_type BatchedLog::overflow(const int_type c)
{
    if (!traits_type::eq_int_type(c, traits_type::eof()))
    {
        waiting_.push_back(traits_type::to_char_type(c));
    }
    return traits_type::not_eof(c);
}


std::streamsize BatchedLog::xsputn(const char* text, const std::streamsize size)
{
    waiting_.append(text, size);
    return size;
}


int BatchedLog::sync()
{
    const clock::time_point now = clock::now();
    if (now - written_ > longest || waiting_.size() > most)
    {
        write();
        written_ = now;
    }
    return 0;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

BatchedLog::BatchedLog()
:
    before_((std::cout.flush(), std::cout.rdbuf(this)))
{
    current_ = this;
}


BatchedLog::~BatchedLog()
{
    write();
    current_ = nullptr;
    std::cout.rdbuf(before_);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void BatchedLog::release()
{
    if (current_)
    {
        current_->write();
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "view/FrameFile.H"
#include "IOstreams.H"
#include "OSspecific.H"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>

namespace Foam
{

namespace
{

//- The format's name and version, the head's length, and the head
std::string fileHead(std::string json)
{
    json.resize((json.size() + 12 + 15)/16*16 - 12, ' ');
    const std::uint32_t bytes = json.size();
    std::string head("ELUFRAM1");
    head.append(reinterpret_cast<const char*>(&bytes), sizeof(bytes));
    return head + json;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

bool FrameFile::put(const char* begin, const std::size_t bytes)
{
    std::size_t done = 0;
    while (done < bytes)
    {
        const ssize_t written =
            file_ < 0 ? -1 : ::write(file_, begin + done, bytes - done);
        if (written < 0 && errno == EINTR && file_ >= 0)
        {
            continue;
        }
        if (written <= 0)
        {
            if (!told_)
            {
                told_ = true;
                Info<< "    Warning: " << path_.c_str() << ": "
                    << std::strerror(errno) << "; frames are left out"
                    << " until there is room, the run goes on" << endl;
            }
            if (file_ >= 0 && ::ftruncate(file_, off_t(size_)) != 0)
            {
                ::close(file_);     // half a frame would spoil what follows
                file_ = -1;
            }
            return false;
        }
        done += written;
    }
    size_ += bytes;
    return true;
}


double FrameFile::kept(const std::string& head, const double until) const
{
    std::ifstream is(path_, std::ios::binary);
    std::string begin(head.size(), '\0');
    if (!is.read(&begin[0], begin.size()) || begin != head)
    {
        return 0;
    }
    is.seekg(0, std::ios::end);
    const double all = is.tellg();

    double end = head.size();
    Head frame;
    while
    (
        is.seekg(std::streamoff(end))
     && is.read(reinterpret_cast<char*>(&frame), sizeof(frame))
     && frame.bytes >= sizeof(frame)
     && end + frame.bytes <= all
     && frame.time <= until
    )
    {
        end += frame.bytes;
    }
    return end;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

FrameFile::FrameFile
(
    const fileName& path,
    const std::string& json,
    const double from,
    const double limit
)
:
    path_(path),
    limit_(limit),
    size_(0),
    file_(-1),
    told_(false)
{
    const std::string head(fileHead(json));
    mkDir(path.path());
    size_ = kept(head, from);
    file_ = ::open(path.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0666);
    if (file_ >= 0 && ::ftruncate(file_, off_t(size_)) != 0)
    {
        ::close(file_);
        file_ = -1;
    }
    if (size_ == 0 && !put(head.data(), head.size()) && file_ >= 0)
    {
        ::close(file_);             // without its head no frame can be read
        file_ = -1;
    }
}


FrameFile::~FrameFile()
{
    if (file_ >= 0)
    {
        ::close(file_);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

double FrameFile::thinning() const
{
    const double left = std::max(1 - size_/limit_, 1e-9);
    return std::exp2(std::floor(-std::log2(left)));
}


bool FrameFile::append(const std::vector<char>& frame)
{
    return
        file_ >= 0
     && size_ + frame.size() <= limit_
     && put(frame.data(), frame.size());
}


} // End namespace Foam

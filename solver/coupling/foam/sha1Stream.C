/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    OpenFOAM before v2206 hashes the dictionary of each function object
    through a stream buffer without overflow(). From GCC 14 on the standard
    library writes a single character with it, so that every function object
    ends with `error in IOstream "sha1"` (Debian 13's OpenFOAM).

    This is that class with overflow(). It is linked before OpenFOAM's
    libraries and so used by them too. The header of the original must not be
    included here.

\*---------------------------------------------------------------------------*/

#include "foam/foamVersion.H"

#if OPENFOAM < 2206

#include "SHA1.H"

#include <streambuf>

namespace Foam
{

class osha1stream
{
public:

    class sha1buf
    :
        public std::streambuf
    {
        SHA1 sha1_;

    protected:

        std::streamsize xsputn(const char* s, std::streamsize n) override;

        int_type overflow(int_type c) override;
    };
};


std::streamsize osha1stream::sha1buf::xsputn
(
    const char* s,
    std::streamsize n
)
{
    sha1_.append(s, n);
    return n;
}


osha1stream::sha1buf::int_type osha1stream::sha1buf::overflow(int_type c)
{
    if (!traits_type::eq_int_type(c, traits_type::eof()))
    {
        const char one = traits_type::to_char_type(c);
        sha1_.append(&one, 1);
    }
    return traits_type::not_eof(c);
}

} // End namespace Foam

#endif

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "foam/caseText.H"
#include "OSspecific.H"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace Foam
{

std::string caseText(const fileName& given)
{
    const fileName file(given.isAbsolute() ? given : getEnv("FOAM_CASE")/given);
    std::ifstream is(file);
    if (!is)
    {
        throw std::invalid_argument
        (
            "file " + given + " is not found, allowed: a csv file in the case"
        );
    }
    std::ostringstream text;
    text << is.rdbuf();
    return text.str();
}


} // End namespace Foam

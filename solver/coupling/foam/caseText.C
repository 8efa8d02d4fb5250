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

fileName fileNameIn(const dictionary& dict, const word& entry)
{
    const string given(dict.get<string>(entry));
    if (!string::valid<fileName>(given))
    {
        FatalIOErrorInFunction(dict)
            << entry << ": '" << given.c_str() << "' has a blank or a quote;"
            << " allowed: a name without" << exit(FatalIOError);
    }
    return fileName(given);
}


std::string caseText(const fileName& given)
{
    const fileName file(given.isAbsolute() ? given : getEnv("FOAM_CASE")/given);
    std::ifstream is(file);
    if (!is)
    {
        throw std::invalid_argument
        (
            "file " + given + " is not found, allowed: a file, by its path in the case"
        );
    }
    std::ostringstream text;
    text << is.rdbuf();
    return text.str();
}


} // End namespace Foam

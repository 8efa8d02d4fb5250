/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Unit tests of the coupling library (doctest). They need OpenFOAM's
    environment, and no case: meshes are made in code.

\*---------------------------------------------------------------------------*/

#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "error.H"

REGISTER_EXCEPTION_TRANSLATOR(Foam::error& error)
{
    return doctest::String(error.message().c_str());
}


int main(int argc, char** argv)
{
    // What OpenFOAM would exit with is thrown, so that tests can expect it
    Foam::FatalError.throwExceptions();
    Foam::FatalIOError.throwExceptions();

    return doctest::Context(argc, argv).run();
}

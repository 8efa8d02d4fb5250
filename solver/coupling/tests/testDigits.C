/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Numbers in messages, as one would write them by hand.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "foam/digits.H"

using namespace Foam;

TEST_SUITE_BEGIN("digits");

TEST_CASE("three digits, without powers of ten where none are needed")
{
    CHECK(threeDigits(0.069843) == "0.0698");
    CHECK(threeDigits(-2) == "-2");
    CHECK(threeDigits(999.4) == "999");
    CHECK(threeDigits(999.6) == "1000");
    CHECK(threeDigits(1333.3) == "1330");
    CHECK(threeDigits(-45678) == "-45700");
    CHECK(threeDigits(999600) == "1e+06");
    CHECK(threeDigits(8.814e-6) == "8.81e-06");
    CHECK(threeDigits(GREAT*GREAT) == "1e+30");
    CHECK(percent(12.3456) == "1230 %");
}

TEST_SUITE_END();

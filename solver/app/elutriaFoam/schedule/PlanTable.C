/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "schedule/PlanTable.H"
#include "IOstreams.H"

#include <iomanip>
#include <sstream>

namespace Foam
{

PlanTable::PlanTable(const std::string& title)
{
    Info<< nl << title.c_str() << nl;
}


void PlanTable::row
(
    const std::string& what,
    const std::string& decision,
    const std::string& why
)
{
    rows_.push_back({what, decision, why});
    std::ostringstream line;
    line << "    " << std::left << std::setw(16) << what << std::setw(30)
        << decision << why;
    Info<< line.str().c_str() << nl;
}


void PlanTable::warn(const RunWarning& warning)
{
    warnings_.push_back(warning.text());
    Warnings::add(warning);
}


void PlanTable::end() const
{
    Info<< endl;
}


} // End namespace Foam

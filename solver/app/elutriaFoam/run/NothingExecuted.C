/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/NothingExecuted.H"
#include "dynamicCode.H"
#include "IStringStream.H"

namespace Foam
{

namespace
{

//- Read what would be executed, and put its name in its place
bool keepName
(
    const char* const name,
    const dictionary& dict,
    primitiveEntry& e,
    Istream& is
)
{
    token code(is);
    if (code.isPunctuation() && code.pToken() == token::BEGIN_BLOCK)
    {
        is.putBack(code);
        dictionary(dict, is);
    }
    IStringStream text(std::string("\"") + name + "\";");
    e.read(dict, text);
    return true;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

NothingExecuted::Directive& NothingExecuted::directive(const word& name)
{
    return
        (*functionEntry::executeprimitiveEntryIstreamMemberFunctionTablePtr_)
        [name];
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

NothingExecuted::NothingExecuted()
:
    calc_(directive("calc")),
    codeStream_(directive("codeStream")),
    allowed_(dynamicCode::allowSystemOperations)
{
    dynamicCode::allowSystemOperations = 0;
    directive("calc") =
        [](const dictionary& dict, primitiveEntry& e, Istream& is)
        {
            return keepName("#calc", dict, e, is);
        };
    directive("codeStream") =
        [](const dictionary& dict, primitiveEntry& e, Istream& is)
        {
            return keepName("#codeStream", dict, e, is);
        };
}


NothingExecuted::~NothingExecuted()
{
    directive("calc") = calc_;
    directive("codeStream") = codeStream_;
    dynamicCode::allowSystemOperations = allowed_;
}


} // End namespace Foam

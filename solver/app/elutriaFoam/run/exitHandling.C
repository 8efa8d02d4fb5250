/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/exitHandling.H"
#include "foam/UnsoundStep.H"
#include "error.H"
#include "IOstreams.H"
#include "Pstream.H"

#include <csignal>
#include <cstring>
#include <sstream>
#include <string>
#include <unistd.h>

namespace Foam
{

namespace
{

constexpr int caseAtFault = 2, runAtFault = 1;

volatile std::sig_atomic_t code = caseAtFault;


//- All white space as one blank each
std::string onOneLine(const std::string& text)
{
    std::istringstream words(text);
    std::string line, word;
    while (words >> word)
    {
        line += (line.empty() ? "" : " ") + word;
    }
    return line;
}


void say(const std::string& reason)
{
    std::cout<< std::flush;
    std::cout<< "\nelutria: failed: " << onOneLine(reason) << std::endl;
}


[[noreturn]] void end(const std::string& reason, const int exitCode)
{
    // Of several processors the first to come ends all
    say(reason);
    UPstream::exit(exitCode);
    std::_Exit(exitCode);
}


//- Only what a signal handler may do
void memoryFault(int)
{
    static const char reading[] =
        "\nelutria: failed: memory fault while the case was read; checkMesh tells"
        " whether the mesh files fit each other, anything else is a defect of"
        " elutriaFoam\n";
    static const char running[] =
        "\nelutria: failed: memory fault within a step, a defect of elutriaFoam;"
        " the run can be continued from the last written time, which is"
        " complete\n";
    const char* const text = code == caseAtFault ? reading : running;
    if (write(STDOUT_FILENO, text, std::strlen(text)) >= 0)
    {
        _exit(code);
    }
    _exit(runAtFault);
}


//- Also where the stack itself is used up
void handleFaults()
{
    static char reserve[1 << 16];
    stack_t stack{};
    stack.ss_sp = reserve;
    stack.ss_size = sizeof(reserve);
    sigaltstack(&stack, nullptr);

    struct sigaction action{};
    action.sa_handler = memoryFault;
    action.sa_flags = SA_ONSTACK;
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL})
    {
        sigaction(signal, &action, nullptr);
    }
}

} // End anonymous namespace


void exitHandling::refuse(const std::string& reason)
{
    end(reason, caseAtFault);
}


void exitHandling::refuseAtExit(const std::string& reason)
{
    say(reason);
    std::_Exit(caseAtFault);
}


void exitHandling::caseIsRead()
{
    code = runAtFault;
}


std::string exitHandling::described(const IOerror& error)
{
    std::ostringstream text;
    text<< error.ioFileName();
    if (error.ioStartLineNumber() >= 0)
    {
        text<< " line " << error.ioStartLineNumber();
    }
    text<< ": " << error.message();
    return onOneLine(text.str());
}


int exitHandling::guarded(const std::function<void()>& work)
{
    FatalError.throwExceptions();
    FatalIOError.throwExceptions();
    handleFaults();

    try
    {
        work();
    }
    catch (const IOerror& error)
    {
        end(described(error), caseAtFault);
    }
    catch (const error& error)
    {
        end(error.message(), code);
    }
    catch (const UnsoundStep& error)
    {
        end(error.what(), runAtFault);
    }
    catch (const std::bad_alloc&)
    {
        end("there is not enough memory", code);
    }
    catch (const std::exception& error)
    {
        end(error.what(), code);
    }
    return 0;
}


} // End namespace Foam

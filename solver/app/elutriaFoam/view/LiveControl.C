/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "view/LiveControl.H"
#include "foam/foamVersion.H"
#include "IFstream.H"

#include <sys/stat.h>
#include <thread>

namespace Foam
{

namespace
{

constexpr std::chrono::milliseconds nap(10);


//- Of what is asked for, what can be done
scalar within(const scalar value, const scalar least, const scalar most)
{
    return value >= least ? min(value, most) : least;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

std::string LiveControl::stamp() const
{
    struct stat found;
    if (::stat(file_.c_str(), &found) != 0)
    {
        return "";
    }
    return
        std::to_string(found.st_ino) + ' '
      + std::to_string(found.st_mtim.tv_sec) + ' '
      + std::to_string(found.st_mtim.tv_nsec);
}


void LiveControl::look()
{
    const std::string now = stamp();
    if (now == stamp_ || now.empty())
    {
        return;
    }
    stamp_ = now;
    try
    {
        IFstream is(file_);
        read(dictionary(is));
    }
    catch (const error& broken)
    {
        Info<< "    Warning: " << file_.c_str() << " is ignored: "
            << broken.message().c_str() << endl;
    }
}


void LiveControl::read(const dictionary& dict)
{
    asked_.gas = within(dict.getOrDefault<scalar>("gas", asked_.gas), 0.01, 100);
    asked_.loading = within(dict.getOrDefault<scalar>("loading", asked_.loading), 1e-6, 100);
    pause_ = dict.getOrDefault("pause", false);
    speed_ = max(dict.getOrDefault<scalar>("speed", 0), scalar(0));
    startPace();
}


void LiveControl::startPace()
{
    paceWall_ = clock::now();
    paceTime_ = time_.value();
}


bool LiveControl::ahead() const
{
    const scalar wall =
        std::chrono::duration<scalar>(clock::now() - paceWall_).count();
    return speed_ > 0 && time_.value() - paceTime_ > wall*speed_;
}


void LiveControl::wait()
{
    look();
    while (pause_ || ahead())
    {
        std::this_thread::sleep_for(nap);
        look();
    }
    const scalar wall =
        std::chrono::duration<scalar>(clock::now() - paceWall_).count();
    if (time_.value() - paceTime_ < (wall - 0.5)*speed_)
    {
        startPace();    // what was slow is not made up for
    }
}


void LiveControl::record()
{
    Steering& steering = feed_->steering();
    const Steering::Change now = steering.at(time_.value());
    if (asked_.gas == now.gas && asked_.loading == now.loading)
    {
        return;
    }
    asked_.time = time_.value();
    if (!steering.add(asked_))
    {
        Info<< "    Warning: system/steering cannot be written: this run can be"
            << " repeated by the lines of its log only" << endl;
    }
}


void LiveControl::apply()
{
    const Steering::Change now = feed_->steering().at(time_.value());
    if (now.gas == applied_.gas && now.loading == applied_.loading)
    {
        return;
    }
    if (now.gas != applied_.gas)
    {
        const wordList others = gas_.scaleInflow(now.gas/applied_.gas);
        if (!others.empty())
        {
            Info<< "    Warning: the gas that enters through " << others
                << " cannot be steered: allowed are conditions by a velocity or"
                << " a constant flow rate" << endl;
        }
    }
    if (now.loading != applied_.loading && !feed_->weighted())
    {
        Info<< "    Warning: the loading cannot be steered: parcels of"
            << " constant/feed is particles, allowed: evenMass, evenSizes"
            << endl;
    }
    applied_ = now;
    Info<< "elutria: gas velocity " << now.gas << " times, loading "
        << now.loading << " times the case's from time " << time_.value()
        << endl;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

LiveControl::LiveControl
(
    const Time& time,
    GasPhase& gas,
    const Feed* feed,
    const bool live
)
:
    time_(time),
    gas_(gas),
    feed_
    (
        feed ? &gas.U().mesh().lookupObjectRef<Feed>(feed->name()) : nullptr
    ),
    live_(live && feed),
    file_(time.globalPath()/"postProcessing"/"frames"/"control"),
    stamp_(stamp()),    // one that lies there is of an earlier run
    pause_(false),
    speed_(0)
{
    if (feed_)
    {
        applied_ = feed_->steering().before(time.value());
        asked_ = feed_->steering().at(time.value());
    }
    startPace();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void LiveControl::follow()
{
    if (!feed_ || (!live_ && feed_->steering().empty()))
    {
        return;
    }
    if (live_)
    {
        const std::string before = stamp_;
        if (Pstream::master())
        {
            wait();
        }
        FixedList<scalar, 3> told;
        told[0] = asked_.gas;
        told[1] = asked_.loading;
        told[2] = stamp_ != before;
        elutriaBroadcast(told);
        asked_.gas = told[0];
        asked_.loading = told[1];
        if (told[2] > 0)
        {
            record();
        }
    }
    apply();
}


} // End namespace Foam

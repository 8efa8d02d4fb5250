/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    The feed of a run that goes on: as it was until now, from the record, and
    from now on, or from its end on, as constant/feed asks.

\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "feed/FeedRecord.H"
#include "feed/feedRate.H"
#include "foam/foamVersion.H"

#include <cmath>

namespace Foam
{

namespace
{

//- How much a feed asks for
struct Asked
{
    scalar duration;    // s, GREAT: until its particles are fed
    bool counted;
    label particles;    // the most there can be: not counted

    explicit Asked(const dictionary& feed)
    :
        counted(feed.found("particles")),
        particles(feed.getOrDefault<label>("particles", labelMax))
    {
        const auto table =
            feed.found("massFlowRate") ? readRateTable(feed) : nullptr;
        duration = feedDuration(feed, table.get());
    }

    //- Is the number of parcels, which weigh, spread over the duration?
    bool spread(const Feed& before) const
    {
        return before.weighted() && counted && duration < GREAT;
    }
};


//- Would the parcels weigh as those of the feed as it was?
bool weighAlike(const Feed& before, const Asked& was, const Asked& now)
{
    const scalar wanted = scalar(now.particles)*was.duration;
    return
        !now.spread(before) || now.particles == was.particles
     || mag(wanted - was.particles*now.duration) < 1e-9*wanted;
}


//- Number of the parcels of a stretch of this length, after `fed` of them
label ownParticles
(
    const Feed& before,
    const Asked& was,
    const Asked& now,
    const label fed,
    const scalar length
)
{
    if (now.spread(before) && now.particles == was.particles)
    {
        return max(1, label(std::round(now.particles/was.duration*length)));
    }
    return now.particles - fed;
}


//- The feed's entries, with those of a stretch of it
dictionary withStretch
(
    const dictionary& feed,
    const scalar start,
    const scalar duration,
    const label particles
)
{
    dictionary settings(feed);
    settings.set("start", start);
    if (feed.found("duration"))
    {
        settings.set("duration", duration);
    }
    if (feed.found("particles"))
    {
        settings.set("particles", particles);
    }
    return settings;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Feed::have(const dictionary& settings)
{
    const fileName file(dictionary::name());
    dictionary::operator=(settings);
    dictionary::name() = file;
}


void Feed::takeOver(const word& phaseName, const dictionary& told)
{
    told_ = told;
    first_ = told.get<label>("first");
    if (told.found("before"))
    {
        before_.reset(new Feed(mesh_, phaseName, told.subDict("before")));
    }
}


void Feed::goOn(const word& phaseName)
{
    case_ = *this;
    files_ = feedRecord::caseFiles(mesh_, case_);
    const dictionary record(feedRecord::read(mesh_));
    if (record.empty())
    {
        return;
    }

    wordHashSet changed(feedRecord::changes(mesh_, record, case_, files_));
    changed.erase("drainTime");
    if (!changed.empty())
    {
        beginStretch(phaseName, record, changed);
        return;
    }

    dictionary settings(record.subDict("stretch").subDict("settings"));
    settings.remove("drainTime");
    if (const entry* drain = case_.findEntry("drainTime"))
    {
        settings.add(*drain);
    }
    have(settings);
    takeOver(phaseName, record.subDict("stretch"));
}


void Feed::beginStretch
(
    const word& phaseName,
    const dictionary& record,
    const wordHashSet& changed
)
{
    const dictionary& was = record.subDict("case");
    const auto refuse = [&](const keyType& entry, const string& allowed)
    {
        feedRecord::refuse(mesh_, entry, was, case_, allowed);
    };
    for (const word entry : {"duration", "particles"})
    {
        if (was.found(entry) != case_.found(entry))
        {
            refuse(entry, "that, or a run from the start");
        }
    }

    before_.reset(new Feed(mesh_, phaseName, record.subDict("stretch")));
    const bool otherRate =
        changed.found("loading") || changed.found("massFlowRate");

    // Parcels that weigh as before go on where the feed would have ended
    const Asked asked(case_), askedBefore(was);
    const scalar now = mesh_.time().value();
    const bool goesOn =
        !otherRate
     && asked.duration >= askedBefore.duration
     && asked.particles >= askedBefore.particles
     && weighAlike(*before_, askedBefore, asked);
    const scalar from = goesOn ? max(now, before_->end()) : now;
    const scalar end = before_->start() + asked.duration;
    first_ = before_->fedUntil(from);

    OStringStream more;
    if (!(end > from))
    {
        more<< "more than " << from - before_->start()
            << ", as that much is over";
        refuse
        (
            changed.found("duration") ? "duration" : *changed.begin(),
            more.str()
        );
    }
    const label own =
        ownParticles(*before_, askedBefore, asked, first_, end - from);
    if (asked.counted && own < 1)
    {
        more<< "more than " << first_ << ", as so many are fed";
        refuse("particles", more.str());
    }
    have(withStretch(case_, from, end - from, own));

    const dictionary last(before_->stretch());
    if (last.found("focus"))
    {
        told_.add("focus", last.subDict("focus"));
    }
    if (!otherRate)
    {
        told_.add("massFlow", before_->massFlow());
    }
    Info<< "elutria: feed changes at time " << from << ':';
    for (const word& entry : changed.sortedToc())
    {
        Info<< ' ' << entry;
    }
    Info<< " of constant/feed" << endl;
}


void Feed::requireDrainAhead() const
{
    const scalar now = mesh_.time().value();
    const dictionary record(feedRecord::read(mesh_));
    if
    (
        now > drained() && !record.empty()
     && feedRecord::changes(mesh_, record, case_, files_).found("drainTime")
    )
    {
        OStringStream over;
        over<< "at least " << now - end() << ", as that much is over";
        feedRecord::refuse
        (
            mesh_, "drainTime", record.subDict("case"), case_, over.str()
        );
    }
}


dictionary Feed::stretch() const
{
    dictionary record, focus;
    record.add("first", first_);
    record.add("settings", static_cast<const dictionary&>(*this));
    record.add("massFlow", massFlow_);
    if (maxParticles_ < labelMax)
    {
        record.add("parcels", maxParticles_);
    }
    for (const Material& m : materials_)
    {
        if (m.focus > 0)
        {
            focus.add(m.name, m.focus);
        }
    }
    if (!focus.empty())
    {
        record.add("focus", focus);
    }
    if (before_)
    {
        record.add("before", before_->stretch());
    }
    return record;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Feed::writeRecord() const
{
    dictionary record;
    record.add("case", case_);
    record.add("files", files_);
    record.add("mesh", feedRecord::shape(mesh_));
    record.add("stretch", stretch());
    feedRecord::write(mesh_, record);
}


} // End namespace Foam

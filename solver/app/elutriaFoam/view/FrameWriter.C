/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "view/FrameWriter.H"
#include "view/boundaryFile.H"
#include "foam/foamVersion.H"
#include "foam/requireAllowed.H"
#include "foam/Json.H"
#include "profiling.H"

#include <cstring>

namespace Foam
{

namespace
{

constexpr scalar full = 65535;


std::uint16_t quantised(const scalar share)
{
    return std::uint16_t(full*min(max(share, scalar(0)), scalar(1)) + 0.5);
}


template<class Record>
void append(std::vector<char>& bytes, const Record& record)
{
    const char* const begin = reinterpret_cast<const char*>(&record);
    bytes.insert(bytes.end(), begin, begin + sizeof(record));
}


scalar largestDiameter(const Feed& feed)
{
    scalar largest = 0;
    for (const Feed::Material& material : feed.materials())
    {
        largest = max(largest, material.sizes.max());
    }
    return largest;
}


std::string vectorAsJson(const vector& v)
{
    return json::list
    ({
        json::number(v.x()), json::number(v.y()), json::number(v.z())
    });
}


dictionary readSettings(const Time& time)
{
    const IOdictionary settings
    (
        IOobject
        (
            "frames", time.system(), time, IOobject::READ_IF_PRESENT,
            IOobject::NO_WRITE, false
        )
    );
    requireEntries(settings, wordList({"record", "perSecond", "limit"}));
    return settings;
}


scalar readSetting(const dictionary& dict, const word& entry, scalar fallback)
{
    const scalar value = dict.getOrDefault<scalar>(entry, fallback);
    requireAllowed(entry, value, above(0), dict);
    return value;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

std::string FrameWriter::head() const
{
    std::vector<std::string> materials, products;
    for (const Feed::Material& material : feed_.materials())
    {
        materials.push_back
        (
            json::object
            ({
                {"name", json::text(material.name)},
                {"density_kg_m3", json::number(material.density)}
            })
        );
    }
    for (const word& product : feed_.products())
    {
        products.push_back(json::text(product));
    }
    return json::object
    ({
        {"box_m", json::list({vectorAsJson(box_.min()), vectorAsJson(box_.max())})},
        {"largest_diameter_m", json::number(largest_)},
        {"up", vectorAsJson(up_)},
        {"materials", json::list(materials)},
        {"products", json::list(products)},
        {"partition_to", json::text(feed_.partitionTo())},
        {"slice", slice_.json()}
    });
}


bool FrameWriter::due(const Steering::Change& now) const
{
    bool due = false;
    if (Pstream::master())
    {
        const scalar wait = interval_*file_->thinning();
        const scalar passed =
            std::chrono::duration<scalar>(clock::now() - lastWall_).count();
        // steps are slow while the gas changes: what was asked for shows after
        // the first of them
        const bool steered = now.gas != gasShown_ || now.loading != loadingShown_;
        due =
            passed >= wait
         && (steered || time_.value() - lastTime_ >= wait*(1 - 1e-9));
    }
    elutriaBroadcast(due);
    return due;
}


FrameFile::Particle FrameWriter::particle(const StockParcel& p) const
{
    FrameFile::Particle record;
    const vector place(p.position() - box_.min());
    for (direction i = 0; i < vector::nComponents; ++i)
    {
        record.position[i] = quantised(place[i]/max(box_.span()[i], VSMALL));
    }
    record.diameter = quantised(p.d()/largest_);
    record.rise = quantised((1000*(p.U() & up_) + 32768)/full);
    record.material = p.typeId();
    const std::uint32_t id = p.origId();
    record.id[0] = id & 0xffff;
    record.id[1] = id >> 16;
    return record;
}


List<char> FrameWriter::gatherParticles() const
{
    std::vector<char> own;
    own.reserve(cloud_.size()*sizeof(FrameFile::Particle));
    cloud_.catchUp();
    for (const StockParcel& p : cloud_)
    {
        append(own, particle(p));
    }
    List<List<char>> all(Pstream::nProcs());
    all[Pstream::myProcNo()].setSize(own.size());
    std::copy(own.begin(), own.end(), all[Pstream::myProcNo()].begin());
    Pstream::gatherList(all);

    List<char> together;
    for (const List<char>& part : all)
    {
        together.append(part);
    }
    return together;
}


void FrameWriter::gatherDepartures()
{
    List<List<Ledger::Row>> all(Pstream::nProcs());
    all[Pstream::myProcNo()] = cloud_.takeSeen();
    Pstream::gatherList(all);
    if (Pstream::master())
    {
        for (const List<Ledger::Row>& part : all)
        {
            waiting_.append(part);
        }
    }
}


std::vector<char> FrameWriter::departures() const
{
    std::vector<char> bytes;
    for (const Ledger::Row& row : waiting_)
    {
        FrameFile::Departure record;
        record.id = row.id;
        record.material = feed_.materialOf(row.id);
        record.product = row.outlet;
        record.time = row.time;
        record.age = row.age;
        record.diameter = row.diameter;
        record.number =
            row.nParticle
           *(feed_.densityOf(row.id)/feed_.materials()[record.material].density);
        append(bytes, record);
    }
    return bytes;
}


scalar FrameWriter::massInside() const
{
    scalar mass = 0;
    for (const StockParcel& p : cloud_)
    {
        mass += p.nParticle()*p.mass();
    }
    return returnReduce(mass, sumOp<scalar>());
}


void FrameWriter::put
(
    FrameFile::Head head,
    const List<char>& particles,
    std::vector<std::uint16_t>& speeds
)
{
    const std::vector<char> left = departures();
    head.particles = particles.size()/sizeof(FrameFile::Particle);
    head.departures = waiting_.size();
    head.samples = speeds == speeds_ ? 0 : speeds.size();
    head.wall = std::chrono::duration<double>(lastWall_ - start_).count();
    head.bytes = sizeof(head) + particles.size() + left.size()
      + head.samples*sizeof(speeds[0]);

    std::vector<char> frame;
    frame.reserve(head.bytes);
    append(frame, head);
    frame.insert(frame.end(), particles.begin(), particles.end());
    frame.insert(frame.end(), left.begin(), left.end());
    const char* const gas = reinterpret_cast<const char*>(speeds.data());
    frame.insert(frame.end(), gas, gas + head.samples*sizeof(speeds[0]));
    if (file_->append(frame))
    {
        waiting_.clear();
        speeds_.swap(speeds);
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

FrameWriter::FrameWriter
(
    const Time& time,
    const GasPhase& gas,
    ElutriaCloud& cloud,
    const Feed& feed
)
:
    time_(time),
    gas_(gas),
    cloud_(cloud),
    feed_(feed),
    box_(cloud.mesh().bounds()),
    largest_(largestDiameter(feed)),
    slice_(cloud.mesh(), gas.gravity()),
    up_(-gas.gravity()/max(mag(gas.gravity()), VSMALL)),
    start_(clock::now()),
    lastWall_(start_ - std::chrono::hours(1)),
    lastTime_(-GREAT),
    gasShown_(1),
    loadingShown_(1)
{
    const dictionary settings(readSettings(time));
    interval_ = 1/readSetting(settings, "perSecond", 30);
    const scalar limit = 1e6*readSetting(settings, "limit", 500);
    const fileName folder(time.globalPath()/"postProcessing"/"frames");
    if (!writeBoundary(cloud.mesh(), cloud.wallSurfaces(), folder/"boundary.obj"))
    {
        Info<< "    Warning: " << folder.c_str() << " cannot be written: there will be no"
            << " picture, the run goes on" << endl;
    }
    if (Pstream::master())
    {
        file_.reset
        (
            new FrameFile(folder/"frames.bin", head(), time.value(), limit)
        );
    }
    cloud_.watch();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

bool FrameWriter::asked(const Time& time)
{
    return readSettings(time).getOrDefault("record", false);
}


void FrameWriter::write
(
    const ElutriaCloud::Count& count,
    const Steering::Change& now,
    const bool last
)
{
    if (!due(now) && !last)
    {
        return;
    }
    addProfiling(frames, "elutria::frames");
    FrameFile::Head head;
    head.time = time_.value();
    head.inside = massInside();
    head.gas = now.gas;
    head.loading = now.loading;
    head.fed = count.fed;
    head.lost = max(count.lost, label(0));

    const List<char> particles = gatherParticles();
    gatherDepartures();
    std::vector<std::uint16_t> speeds = slice_.speeds(gas_.U());
    lastTime_ = time_.value();
    gasShown_ = now.gas;
    loadingShown_ = now.loading;
    if (Pstream::master())
    {
        lastWall_ = clock::now();
        put(head, particles, speeds);
    }
}


} // End namespace Foam

#include "elutriaLaws.h"

#include "FeedRules.hpp"
#include "OutputFiles.hpp"
#include "Settling.hpp"
#include "SizeCurves.hpp"
#include "SizeTables.hpp"

#include <algorithm>
#include <exception>
#include <memory>

using namespace elutria::laws;

struct elutriaSizes
{
    SizeCurves curves;
};

namespace
{

/// A text that outlives the call, one for each thread
const char* keep(const std::string& text)
{
    thread_local std::string kept;
    kept = text;
    return kept.c_str();
}


template<class Laws>
const char* names(const Laws& laws)
{
    std::string all;
    for (const auto& law : laws) all += (all.empty() ? "" : " ") + std::string(law.name);
    return keep(all);
}


/// A grain, and the drag of its measured velocities
struct OwnGrain
{
    std::unique_ptr<const MeasuredDrag> measured;
    Grain grain;

    explicit OwnGrain(const elutriaGrain& given)
    :
        grain{given.density, {given.sphericity, given.flatness, given.elongation}}
    {
        if (!given.velocities) return;
        measured = std::make_unique<MeasuredDrag>(velocityTable(given.velocities), given.density,
                                                  given.gasDensity, given.gasViscosity);
        grain.form.measured = measured.get();
    }
};


/// Do the work with a law; what is wrong, or null
template<class Law, class Work>
const char* with(const Law* law, const char* name, const Work& work)
{
    if (!law) return keep("no law is named " + std::string(name));
    try
    {
        work(*law);
    }
    catch (const std::exception& error)
    {
        return keep(error.what());
    }
    return nullptr;
}


template<class Make>
const char* make(elutriaSizes** sizes, int weighting, const Make& curve)
{
    try
    {
        const auto of = weighting == 0 ? Weighting::mass : Weighting::number;
        *sizes = std::make_unique<elutriaSizes>(elutriaSizes{SizeCurves(curve(), of)}).release();
    }
    catch (const std::exception& error)
    {
        return keep(error.what());
    }
    return nullptr;
}

} // namespace


const double elutriaLeastDensity = leastDensity;
const double elutriaLargestDensity = largestDensity;
const double elutriaLargestSize = largestSize;
const char* const elutriaParticleColumns = particleColumns;

const char* elutriaDragLaws() { return names(dragLaws()); }

const char* elutriaDragTitle(const char* law)
{
    const DragLaw* found = findDragLaw(law);
    return found ? found->title : nullptr;
}

const char* elutriaSizeLaws() { return names(sizeLaws()); }

const char* elutriaSizeParameters(const char* law)
{
    const SizeLaw* found = findSizeLaw(law);
    if (!found) return nullptr;
    std::string all;
    for (const char* name : found->parameters) all += (all.empty() ? "" : " ") + std::string(name);
    return keep(all);
}

const char* elutriaCdRe(const char* name, const double* re, const double* voidFraction,
                        const double* form, double* cdRe, int n)
{
    return with(findDragLaw(name), name, [=](const DragLaw& law)
    {
        for (int i = 0; i < n; ++i)
        {
            const double* own = form + 5*i;
            cdRe[i] = law.CdRe(re[i], voidFraction[i], {own[0], own[1], own[2], own[3], own[4]});
        }
    });
}

double elutriaEllipsoidSphericity(double flatness, double elongation)
{
    return ellipsoidSphericity(flatness, elongation);
}

const char* elutriaTerminalVelocity(const char* name, const elutriaGrain* grain, const double gas[2],
                                    double gravity, const double* diameter, double* velocity, int n)
{
    return with(findDragLaw(name), name, [=](const DragLaw& law)
    {
        const OwnGrain own(*grain);
        for (int i = 0; i < n; ++i)
            velocity[i] = terminalVelocity(law.CdRe, own.grain, diameter[i], {gas[0], gas[1]},
                                           gravity);
    });
}

const char* elutriaSettlingSize(const char* name, const elutriaGrain* grain, const double gas[2],
                                double gravity, const double limits[2], const double* velocity,
                                double* diameter, int n)
{
    return with(findDragLaw(name), name, [=](const DragLaw& law)
    {
        const OwnGrain own(*grain);
        for (int i = 0; i < n; ++i)
            diameter[i] = settlingSize(law.CdRe, own.grain, velocity[i], {gas[0], gas[1]}, gravity,
                                       limits[0], limits[1]);
    });
}

const char* elutriaLawSizes(const char* name, const double* parameters, const double limits[2],
                            double most, int weighting, elutriaSizes** sizes)
{
    const SizeLaw* law = findSizeLaw(name);
    if (!law) return keep("no law is named " + std::string(name));
    return make(sizes, weighting,
                [=] { return truncated(*law, parameters, limits[0], limits[1], most); });
}

const char* elutriaSievedSizes(const double* diameter, const double* finer, int n,
                               const char* named, double most, int weighting, elutriaSizes** sizes)
{
    return make(sizes, weighting, [=]
    { return sieved({diameter, diameter + n}, {finer, finer + n}, named, most); });
}

const char* elutriaSieveTable(const char* csv, double min, int weighting, elutriaSizes** sizes)
{
    return make(sizes, weighting, [=] { return sieveTable(csv, min); });
}

const char* elutriaMixedSizes(elutriaSizes* const* parts, const double* shares, int n, int weighting,
                              elutriaSizes** sizes)
{
    return make(sizes, weighting, [=]
    {
        std::vector<CumulativeCurve> curves;
        for (int i = 0; i < n; ++i)
        {
            const SizeCurves& own = parts[i]->curves;
            const auto& finer = weighting == 0 ? own.massFiner() : own.numberFiner();
            curves.push_back({own.diameters(), finer, own.limits()});
        }
        return mixed(curves, {shares, shares + n});
    });
}

const char* elutriaSingleSize(double diameter, elutriaSizes** sizes)
{
    return make(sizes, 0, [=] { return single(diameter); });
}

int elutriaSizePoints(const elutriaSizes* sizes)
{
    return int(sizes->curves.diameters().size());
}

double elutriaMeanCube(const elutriaSizes* sizes) { return sizes->curves.meanCube(); }

void elutriaSizeCurves(const elutriaSizes* sizes, double* diameter, double* massFiner,
                       double* numberFiner)
{
    const SizeCurves& curves = sizes->curves;
    std::copy(curves.diameters().begin(), curves.diameters().end(), diameter);
    std::copy(curves.massFiner().begin(), curves.massFiner().end(), massFiner);
    std::copy(curves.numberFiner().begin(), curves.numberFiner().end(), numberFiner);
}

void elutriaFreeSizes(elutriaSizes* sizes) { delete sizes; }

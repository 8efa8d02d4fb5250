/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "parallel/ParticleExchange.H"
#include "foam/foamVersion.H"
#include "core/ParticleName.hpp"
#include "PstreamBuffers.H"
#include "UIPstream.H"
#include "UOPstream.H"
#include "ListOps.H"
#include "sigFpe.H"

#include <cstring>

namespace Foam
{

namespace
{

using elutria::dem::ParticleName;
using elutria::dem::Particles;
using elutria::dem::VectorArray;

//- The columns that travel to the master, and those that travel back
std::vector<std::vector<double>*> columns(Particles& p, const bool back)
{
    std::vector<std::vector<double>*> list;
    const auto vectors = [&](std::initializer_list<VectorArray*> arrays)
    {
        for (VectorArray* a : arrays)
        {
            list.insert(list.end(), {&a->x, &a->y, &a->z});
        }
    };

    vectors({&p.position, &p.velocity, &p.spin});
    if (back)
    {
        vectors({&p.dragImpulse});
    }
    else
    {
        for
        (
            auto* column :
            {&p.radius, &p.mass, &p.statisticalWeight, &p.solidFraction, &p.dragRate}
        )
        {
            list.push_back(column);
        }
        vectors({&p.gasVelocity, &p.acceleration});
    }
    return list;
}


scalarList packed(Particles& p, const bool back)
{
    const auto cols = columns(p, back);
    scalarList data(p.size()*cols.size());
    scalar* out = data.data();

    for (const auto* column : cols)
    {
        out = std::copy(column->begin(), column->end(), out);
    }
    return data;
}


//- Insert the columns of n particles at `first`
void unpack
(
    const scalarList& data,
    const size_t first,
    const size_t n,
    Particles& p,
    const bool back
)
{
    const scalar* in = data.cdata();
    for (auto* column : columns(p, back))
    {
        column->resize(std::max(column->size(), first + n));
        std::copy(in, in + n, column->begin() + first);
        in += n;
    }
}

} // End anonymous namespace


void ParticleExchange::onMaster
(
    Particles& local,
    const std::function<void(Particles&)>& work
)
{
    // The engine's vector kernels compute lanes that nobody uses
    const sigFpe::ignore untrapped;

    if (!Pstream::parRun())
    {
        work(local);
        return;
    }

    // Names travel as pairs of 32-bit labels: high id, low id, material
    List<labelList> names(Pstream::nProcs());
    List<scalarList> data(Pstream::nProcs());
    const label me = Pstream::myProcNo();

    names[me].resize(3*local.size());
    for (size_t i = 0; i < local.size(); ++i)
    {
        const ParticleName name(local.id[i]);
        names[me][3*i] = label(name.origin);
        names[me][3*i + 1] = label(name.number);
        names[me][3*i + 2] = label(local.material[i]);
    }
    data[me] = packed(local, false);

    Pstream::gatherList(names);
    Pstream::gatherList(data);

    if (Pstream::master())
    {
        Particles all;
        all.stepIndex = local.stepIndex;
        for (label proci = 0; proci < Pstream::nProcs(); ++proci)
        {
            const size_t first = all.size();
            const size_t n = names[proci].size()/3;
            for (size_t i = 0; i < n; ++i)
            {
                const labelList& name = names[proci];
                all.id.push_back
                (
                    ParticleName(name[3*i], name[3*i + 1]).id()
                );
                all.material.push_back(uint32_t(name[3*i + 2]));
            }
            unpack(data[proci], first, n, all, false);
        }
        all.dragImpulse.assign(all.size(), {});

        work(all);

        size_t first = 0;
        for (label proci = 0; proci < Pstream::nProcs(); ++proci)
        {
            const size_t n = names[proci].size()/3;
            const auto cols = columns(all, true);
            scalarList& back = data[proci];
            back.resize(n*cols.size());
            scalar* out = back.data();
            for (const auto* column : cols)
            {
                out = std::copy_n(column->begin() + first, n, out);
            }
            first += n;
        }
    }

    // Not scatterList: it leaves a processor's own entry as it was gathered
    PstreamBuffers buffers(Pstream::commsTypes::nonBlocking);
    if (Pstream::master())
    {
        for (label proci = 1; proci < Pstream::nProcs(); ++proci)
        {
            UOPstream os(proci, buffers);
            os << data[proci];
        }
    }
    buffers.finishedSends();
    if (!Pstream::master())
    {
        UIPstream is(Pstream::masterNo(), buffers);
        is >> data[me];
    }
    unpack(data[me], 0, local.size(), local, true);
}


} // End namespace Foam

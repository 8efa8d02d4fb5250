/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "parallel/FoamExchange.H"
#include "Pstream.H"
#include "PstreamBuffers.H"
#include "PstreamReduceOps.H"
#include "UIPstream.H"
#include "UOPstream.H"
#include "vector2D.H"

namespace Foam
{

int FoamExchange::rank() const
{
    return Pstream::parRun() ? Pstream::myProcNo() : 0;
}


int FoamExchange::ranks() const
{
    return Pstream::parRun() ? Pstream::nProcs() : 1;
}


std::vector<FoamExchange::Bytes> FoamExchange::doSwap(std::vector<Bytes> toEach)
{
    PstreamBuffers buffers(Pstream::commsTypes::nonBlocking);
    for (label proci = 0; proci < ranks(); ++proci)
    {
        const Bytes& bytes = toEach[proci];
        if (proci != rank() && !bytes.empty())
        {
            UOPstream os(proci, buffers);
            os << UList<char>(const_cast<char*>(bytes.data()), bytes.size());
        }
    }
    labelList received(ranks(), Zero);
    buffers.finishedSends(received);

    std::vector<Bytes> got(ranks());
    got[rank()] = std::move(toEach[rank()]);
    for (label proci = 0; proci < ranks(); ++proci)
    {
        if (proci != rank() && received[proci])
        {
            UIPstream is(proci, buffers);
            const List<char> bytes(is);
            got[proci].assign(bytes.begin(), bytes.end());
        }
    }
    return got;
}


std::vector<FoamExchange::Bytes> FoamExchange::doShare(Bytes mine)
{
    return doSwap(std::vector<Bytes>(ranks(), mine));
}


void FoamExchange::doSwapWith(std::vector<Partner>& partners)
{
    const label startOfRequests = UPstream::nRequests();
    for (Partner& partner : partners)
    {
        if (!partner.received.empty())
        {
            UIPstream::read
            (
                UPstream::commsTypes::nonBlocking,
                partner.rank,
                partner.received.data(),
                partner.received.size()
            );
        }
    }
    for (const Partner& partner : partners)
    {
        if (!partner.sent.empty())
        {
            UOPstream::write
            (
                UPstream::commsTypes::nonBlocking,
                partner.rank,
                partner.sent.data(),
                partner.sent.size()
            );
        }
    }
    UPstream::waitRequests(startOfRequests);
}


void FoamExchange::doSum(std::vector<double>& values)
{
    // Two at a time: OpenFOAM hands these to MPI as they are
    for (std::size_t i = 0; i < values.size(); i += 2)
    {
        const bool both = i + 1 < values.size();
        vector2D sums(values[i], both ? values[i + 1] : 0);
        reduce(sums, sumOp<vector2D>());
        values[i] = sums.x();
        if (both)
        {
            values[i + 1] = sums.y();
        }
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "view/GasSlice.H"
#include "foam/Json.H"
#include "Pstream.H"

#include <algorithm>

namespace Foam
{

namespace
{

constexpr label longestSide = 96;   // points


direction largestOf(const vector& v)
{
    direction axis = 0;
    for (direction i = 1; i < vector::nComponents; ++i)
    {
        axis = mag(v[i]) > mag(v[axis]) ? i : axis;
    }
    return axis;
}

} // End anonymous namespace


GasSlice::GasSlice(const fvMesh& mesh, const vector& gravity)
:
    corner_(mesh.bounds().min()),
    across_(Zero),
    along_(Zero)
{
    const vector span(mesh.bounds().span());
    const direction up = largestOf(gravity);
    vector sides(span);
    sides[up] = 0;
    const direction wide = largestOf(sides);
    const direction normal = 3 - up - wide;

    across_[wide] = span[wide];
    along_[up] = span[up];
    corner_[normal] += 0.5*span[normal];
    const scalar edge = max(span[wide], span[up])/longestSide;
    nAcross_ = max(label(2), label(span[wide]/edge + 0.5));
    nAlong_ = max(label(2), label(span[up]/edge + 0.5));

    cells_.resize(nAcross_*nAlong_);
    forAll(cells_, i)
    {
        cells_[i] = mesh.findCell
        (
            corner_ + (i % nAcross_ + 0.5)/nAcross_*across_
          + (i / nAcross_ + 0.5)/nAlong_*along_
        );
    }
}


std::string GasSlice::json() const
{
    const auto asList = [](const vector& v)
    {
        return json::list
        ({
            json::number(v.x()), json::number(v.y()), json::number(v.z())
        });
    };
    return json::object
    ({
        {"corner_m", asList(corner_)},
        {"across_m", asList(across_)},
        {"along_m", asList(along_)},
        {"points", json::list({json::number(nAcross_), json::number(nAlong_)})}
    });
}


std::vector<std::uint16_t> GasSlice::speeds(const volVectorField& U) const
{
    labelList all(cells_.size(), label(nowhere));
    forAll(cells_, i)
    {
        if (cells_[i] >= 0)
        {
            all[i] = label(min(1000*mag(U[cells_[i]]), scalar(nowhere - 1)));
        }
    }
    Pstream::listCombineGather(all, minEqOp<label>());
    return {all.begin(), all.end()};
}


} // End namespace Foam

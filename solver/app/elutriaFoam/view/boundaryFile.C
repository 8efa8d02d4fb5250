/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "view/boundaryFile.H"
#include "OSspecific.H"
#include "Pstream.H"
#include "processorPolyPatch.H"

#include <fstream>
#include <sstream>

namespace Foam
{

namespace
{

//- This processor's faces: their points are counted back from the last, so that
//  the parts of all processors can stand one after the other
std::string ownPart(const polyMesh& mesh)
{
    std::ostringstream os;
    os.precision(9);
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (isA<processorPolyPatch>(patch) || patch.empty())
        {
            continue;
        }
        os << "g " << patch.name() << ' ' << patch.type() << '\n';
        const pointField& points = patch.localPoints();
        for (const point& p : points)
        {
            os << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
        }
        for (const face& f : patch.localFaces())
        {
            os << 'f';
            for (const label corner : f)
            {
                os << ' ' << corner - points.size();
            }
            os << '\n';
        }
    }
    return os.str();
}


//- Walls that are no patches; each triangle has its own points
std::string partOf(const WallSurface& surface)
{
    std::ostringstream os;
    os.precision(9);
    os << "g " << surface.name << " wall\n";
    for (const FixedList<point, 3>& corners : surface.triangles)
    {
        for (const point& p : corners)
        {
            os << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
        }
        os << "f -3 -2 -1\n";
    }
    return os.str();
}

} // End anonymous namespace


bool writeBoundary
(
    const polyMesh& mesh,
    const UList<WallSurface>& surfaces,
    const fileName& file
)
{
    List<string> parts(Pstream::nProcs());
    parts[Pstream::myProcNo()] = ownPart(mesh);
    Pstream::gatherList(parts);
    if (!Pstream::master())
    {
        return true;
    }
    mkDir(file.path());
    const fileName draft(file + ".part");
    std::ofstream os(draft);
    os << "# Faces of the patches, in metres\n";
    for (const string& part : parts)
    {
        os << part.c_str();
    }
    for (const WallSurface& surface : surfaces)
    {
        os << partOf(surface);
    }
    os << std::flush;
    return os && mv(draft, file);
}


} // End namespace Foam

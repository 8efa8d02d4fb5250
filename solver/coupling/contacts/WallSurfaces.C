/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/WallSurfaces.H"
#include "foam/caseText.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "foam/requireAllowed.H"
#include "cyclicPolyPatch.H"
#include "OSspecific.H"
#include "triSurface.H"

#include <fstream>

namespace Foam
{

namespace
{

[[noreturn]] void refuse
(
    const dictionary& dict,
    const WallSurface& surface,
    const string& found,
    const string& allowed
)
{
    FatalIOErrorInFunction(dict)
        << "file: " << surface.file.c_str() << ": " << found.c_str()
        << "; allowed: " << allowed.c_str() << exit(FatalIOError);
    std::abort();   // never reached
}


//- The format by which OpenFOAM reads the file: a binary STL may begin with
//  "solid", which OpenFOAM takes for a text's beginning
word formatOf(const fileName& path)
{
    constexpr off_t header = 80, triangle = 50;
    uint32_t number = 0;
    std::ifstream file(path, std::ios::binary);
    file.seekg(header);
    file.read(reinterpret_cast<char*>(&number), sizeof(number));
    const bool binary =
        path.hasExt("stl") && file
     && fileSize(path) == header + off_t(sizeof(number)) + triangle*number;
    return binary ? "stlb" : path.ext();
}


//- Triangles of the file that have an area [m]
List<FixedList<point, 3>> trianglesOf
(
    const dictionary& dict,
    const WallSurface& surface,
    const scalar scale
)
{
    const fileName path
    (
        surface.file.isAbsolute()
      ? surface.file : getEnv("FOAM_CASE")/surface.file
    );
    if (!isFile(path))
    {
        refuse(dict, surface, "no such file", "a file, by its path in the case");
    }
    if (!triSurface::canRead(path, false))
    {
        refuse
        (
            dict, surface, "is of no format that OpenFOAM reads",
            "a triangulated surface: stl, obj, ..."
        );
    }
    const triSurface read(path, formatOf(path), scale);
    DynamicList<FixedList<point, 3>> triangles;
    for (const labelledTri& t : read)
    {
        if (t.mag(read.points()) > 0)
        {
            FixedList<point, 3> corners;
            forAll(corners, k)
            {
                corners[k] = read.points()[t[k]];
            }
            triangles.append(corners);
        }
    }
    if (triangles.empty())
    {
        refuse(dict, surface, "has no triangles", "a surface with an area");
    }
    return List<FixedList<point, 3>>(std::move(triangles));
}


boundBox boundsOf(const WallSurface& surface)
{
    boundBox bounds;
    for (const FixedList<point, 3>& corners : surface.triangles)
    {
        bounds.add(corners);
    }
    return bounds;
}


string told(const boundBox& bounds)
{
    OStringStream text;
    text.precision(6);
    text<< bounds.min() << " to " << bounds.max() << " m";
    return text.str();
}


//- Where no particle would meet it, or only one of its periodic images
void requireInside
(
    const dictionary& dict,
    const WallSurface& surface,
    const polyMesh& mesh
)
{
    const boundBox bounds(boundsOf(surface));
    if (!bounds.overlaps(mesh.bounds()))
    {
        refuse
        (
            dict, surface,
            "lies outside of the mesh: " + told(bounds),
            "within " + told(mesh.bounds()) + " (scale 0.001 where the file is"
            " in mm)"
        );
    }
    const scalar rounding = 1e-6*mesh.bounds().mag();
    const vector beyond
    (
        max(mesh.bounds().min() - bounds.min(), bounds.max() - mesh.bounds().max())
    );
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        const auto* cyclic = isA<cyclicPolyPatch>(patch);
        if (!cyclic || !cyclic->size())
        {
            continue;
        }
        const vector across(cmptMag(cyclic->faceNormals()[0]));
        if ((across & max(beyond, vector::zero)) > rounding)
        {
            refuse
            (
                dict, surface,
                "reaches beyond the cyclic patch " + patch.name() + ": "
              + told(bounds),
                "a surface between the cyclic patches"
            );
        }
    }
}


void requireOwnName(const dictionary& surfaces, const word& name, const polyMesh& mesh)
{
    if (mesh.boundaryMesh().findPatchID(name) >= 0)
    {
        FatalIOErrorInFunction(surfaces)
            << name << " is the name of a patch too; allowed: another name"
            << exit(FatalIOError);
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Functions * * * * * * * * * * * * * * * * //

List<WallSurface> readWallSurfaces(const dictionary& dict, const polyMesh& mesh)
{
    DynamicList<WallSurface> surfaces;
    const dictionary& all = dict.subOrEmptyDict("surfaces");
    for (const word& name : all.toc())
    {
        requireOwnName(all, name, mesh);
        const dictionary& one = all.subDict(name);
        requireOwnEntries(one, ownDictionary::wallSurface);
        const scalar scale = one.getOrDefault<scalar>("scale", 1);
        requireAllowed("scale", scale, above(0, 1e6), one);
        WallSurface surface{name, fileNameIn(one, "file"), {}};
        if (Pstream::master())
        {
            surface.triangles = trianglesOf(one, surface, scale);
        }
        elutriaBroadcast(surface.triangles);
        requireInside(one, surface, mesh);
        surfaces.append(surface);
    }
    return List<WallSurface>(std::move(surfaces));
}


wordList namesOf(const UList<WallSurface>& surfaces)
{
    wordList names;
    for (const WallSurface& surface : surfaces)
    {
        names.append(surface.name);
    }
    return names;
}


} // End namespace Foam

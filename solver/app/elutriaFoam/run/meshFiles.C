/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/meshFiles.H"
#include "IFstream.H"
#include "OSspecific.H"
#include "entry.H"
#include "fvMesh.H"
#include "faceList.H"
#include "labelList.H"
#include "pointField.H"
#include "polyMesh.H"
#include "volMesh.H"

#include <algorithm>
#include <vector>

namespace Foam
{

namespace
{

//- Of a cell; no polyhedron has fewer
constexpr label fewestFaces = 4;


//- A file of the mesh, read behind its header
class MeshFile
{
    const fileName shown_;
    IFstream is_;
    IOobject header_;
    bool readable_;

public:

    MeshFile(const Time& runTime, const fileName& mesh, const word& name)
    :
        shown_(mesh/name),
        is_(runTime.path()/shown_),
        header_(name, mesh, runTime),
        readable_(is_.good() && header_.readHeader(is_))
    {}

    bool readable() const { return readable_; }

    const word& className() const { return header_.headerClassName(); }

    template<class List>
    List read()
    {
        List values(is_);
        token after;
        if (is_.read(after).good() && after.good())
        {
            refuse("its list is followed by more", "the list alone");
        }
        return values;
    }

    [[noreturn]] void refuse
    (
        const std::string& found,
        const std::string& allowed
    ) const
    {
        FatalErrorInFunction
            << shown_.c_str() << ": " << found.c_str() << "; allowed: "
            << allowed.c_str() << exit(FatalError);
        std::abort();
    }

    //- Every number is one of `count` things
    template<class Labels>
    void requireWithin
    (
        const Labels& numbers,
        const label count,
        const char* const things
    ) const
    {
        for (const label number : numbers)
        {
            if (number < 0 || number >= count)
            {
                refuse
                (
                    std::to_string(number),
                    "0 to " + std::to_string(count - 1) + ", the " + things
                );
            }
        }
    }
};


//- What a compact list of faces holds: where each begins, and all their points
struct CompactFaces
{
    const labelList begins, points;

    explicit CompactFaces(Istream& is)
    :
        begins(is),
        points(is)
    {}

    //- Do the faces follow each other, to the end?
    bool fit() const
    {
        return
            begins.size() && begins.first() == 0
         && begins.last() == points.size()
         && std::is_sorted(begins.begin(), begins.end());
    }
};


//- The points of all faces
labelList pointsOf(MeshFile& faces)
{
    if (faces.className() == "faceCompactList")
    {
        const CompactFaces all(faces.read<CompactFaces>());
        if (!all.fit())
        {
            faces.refuse
            (
                "its faces do not follow each other in the list of their points",
                "as many points as the first list says"
            );
        }
        return all.points;
    }
    DynamicList<label> points;
    for (const face& corners : faces.read<faceList>())
    {
        points.append(corners);
    }
    return labelList(std::move(points));
}


void requireCells(MeshFile& owner, MeshFile& neighbour)
{
    const labelList own(owner.read<labelList>());
    if (!neighbour.readable() && own != labelList(own.size(), Zero))
    {
        neighbour.refuse    // OpenFOAM takes all faces as the mesh's surface
        (
            "is no list of labels, or is not there",
            "the neighbour of each face between cells"
        );
    }
    const labelList next
    (
        neighbour.readable() ? neighbour.read<labelList>() : labelList()
    );
    const label most = (own.size() + next.size())/fewestFaces;
    owner.requireWithin(own, most, "cells");
    neighbour.requireWithin(next, most, "cells");

    std::vector<label> faces(most, 0);
    label cells = 0;
    for (const labelList* const list : {&own, &next})
    {
        for (const label cell : *list)
        {
            ++faces[cell];
            cells = max(cells, cell + 1);
        }
    }
    for (label cell = 0; cell < cells; ++cell)
    {
        if (faces[cell] < fewestFaces)
        {
            owner.refuse
            (
                "cell " + std::to_string(cell) + " has "
              + std::to_string(faces[cell]) + " faces",
                std::to_string(fewestFaces) + " or more of each cell"
            );
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void requireSoundMesh(const Time& runTime)
{
    const word& folder = polyMesh::meshSubDir;
    const fileName mesh
    (
        runTime.findInstance(folder, "faces", IOobject::READ_IF_PRESENT)/folder
    );
    MeshFile points(runTime, mesh, "points"), faces(runTime, mesh, "faces");
    if (points.readable() && faces.readable())
    {
        const label count = points.read<pointField>().size();
        faces.requireWithin(pointsOf(faces), count, "points");
    }
    MeshFile owner(runTime, mesh, "owner"), next(runTime, mesh, "neighbour");
    if (owner.readable())
    {
        requireCells(owner, next);
    }
    MeshFile boundary(runTime, mesh, "boundary");
    if (boundary.readable())
    {
        boundary.read<PtrList<entry>>();
    }
}


void requireVolumes(const fvMesh& mesh)
{
    const scalar least = gMin(mesh.V().field());
    if (!(least > 0))
    {
        FatalErrorInFunction
            << (mesh.facesInstance()/polyMesh::meshSubDir).c_str()
            << ": a cell has " << least
            << " m3; allowed: above 0. checkMesh tells where" << exit(FatalError);
    }
}


} // End namespace Foam

/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "tests/BoxMesh.H"
#include "foam/foamVersion.H"
#include "wallPolyPatch.H"

#include <fstream>
#include <unistd.h>

using namespace Foam;

namespace
{

void writeDictionary
(
    const std::filesystem::path& file,
    const std::string& entries
)
{
    std::ofstream(file)
        << "FoamFile { version 2.0; format ascii; class dictionary; object "
        << file.filename().string() << "; }\n" << entries;
}


//- A folder of this process' own, with schemes
std::filesystem::path makeFolder()
{
    static int count = 0;
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path()
       /("elutriaCouplingTests." + std::to_string(::getpid()) + '.'
       + std::to_string(count++));
    std::filesystem::create_directories(folder/"case"/"system");
    writeDictionary
    (
        folder/"case"/"system"/"fvSchemes",
        "ddtSchemes { default Euler; } gradSchemes { default Gauss linear; }"
        " divSchemes { default none; }"
        " laplacianSchemes { default Gauss linear corrected; }"
        " interpolationSchemes { default linear; }"
        " snGradSchemes { default corrected; }\n"
    );
    writeDictionary(folder/"case"/"system"/"fvSolution", "solvers {}\n");
    return folder;
}


dictionary timeControls()
{
    dictionary dict;
    dict.add("startFrom", word("startTime"));
    dict.add("startTime", 0);
    dict.add("stopAt", word("endTime"));
    dict.add("endTime", 1);
    dict.add("deltaT", 1);
    dict.add("writeControl", word("timeStep"));
    dict.add("writeInterval", 1);
    return dict;
}


//- Faces of a box of cells, with owners and neighbours
struct BoxFaces
{
    const Vector<label> n;
    DynamicList<face> faces;
    DynamicList<label> owner, neighbour;

    label cell(const Vector<label>& at) const
    {
        return at.x() + n.x()*(at.y() + n.y()*at.z());
    }

    //- Corner of a cell, each axis 0 or 1
    label corner(const Vector<label>& at, label x, label y, label z) const
    {
        return
            at.x() + x
          + (n.x() + 1)*(at.y() + y + (n.y() + 1)*(at.z() + z));
    }

    //- Face on the cell's high (1) or low (0) side of an axis, normal outwards
    face side(const Vector<label>& at, const direction axis, label high) const
    {
        // The other two axes, in cyclic order
        const direction a = (axis + 1) % 3, b = (axis + 2) % 3;
        face f(4);
        const label turns[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (label k = 0; k < 4; ++k)
        {
            Vector<label> c(0, 0, 0);
            c[axis] = high;
            c[a] = turns[k][0];
            c[b] = turns[k][1];
            f[high ? k : 3 - k] = corner(at, c.x(), c.y(), c.z());
        }
        return f;
    }

    template<class Visit>
    void forCells(const Visit& visit) const
    {
        Vector<label> at;
        for (at.z() = 0; at.z() < n.z(); ++at.z())
        {
            for (at.y() = 0; at.y() < n.y(); ++at.y())
            {
                for (at.x() = 0; at.x() < n.x(); ++at.x())
                {
                    visit(at);
                }
            }
        }
    }

    explicit BoxFaces(const Vector<label>& cells)
    :
        n(cells)
    {
        forCells([&](const Vector<label>& at)
        {
            for (direction axis = 0; axis < 3; ++axis)
            {
                Vector<label> next(at);
                if (++next[axis] < n[axis])
                {
                    faces.append(side(at, axis, 1));
                    owner.append(cell(at));
                    neighbour.append(cell(next));
                }
            }
        });
        forCells([&](const Vector<label>& at)
        {
            for (direction axis = 0; axis < 3; ++axis)
            {
                for (const label high : {0, 1})
                {
                    if (at[axis] == (high ? n[axis] - 1 : 0))
                    {
                        faces.append(side(at, axis, high));
                        owner.append(cell(at));
                    }
                }
            }
        });
    }
};

} // End anonymous namespace


BoxMesh::BoxMesh(const Vector<label>& cells, const scalar side)
:
    folder_(makeFolder()),
    time_
    (
        new Time
        (
            timeControls(), fileName(folder_.string()), "case", "system",
            "constant", false, false
        )
    )
{
    pointField points((cells.x() + 1)*(cells.y() + 1)*(cells.z() + 1));
    label i = 0;
    for (label z = 0; z <= cells.z(); ++z)
    {
        for (label y = 0; y <= cells.y(); ++y)
        {
            for (label x = 0; x <= cells.x(); ++x)
            {
                points[i++] = side*vector(x, y, z);
            }
        }
    }

    BoxFaces box(cells);
    const label inner = box.neighbour.size(), all = box.faces.size();
    mesh_.reset
    (
        new fvMesh
        (
            IOobject
            (
                // READ: of the schemes; there are no files of the mesh
                polyMesh::defaultRegion, time_->constant(), *time_,
                IOobject::READ_IF_PRESENT, IOobject::NO_WRITE
            ),
            std::move(points),
            faceList(std::move(box.faces)),
            labelList(std::move(box.owner)),
            labelList(std::move(box.neighbour)),
            false
        )
    );
    List<polyPatch*> patches(1);
    patches[0] = new wallPolyPatch
    (
        "walls", all - inner, inner, 0, mesh_->boundaryMesh(),
        wallPolyPatch::typeName
    );
    mesh_->addFvPatches(patches, false);
}


BoxMesh::~BoxMesh()
{
    mesh_.clear();
    time_.clear();
    std::filesystem::remove_all(folder_);
}

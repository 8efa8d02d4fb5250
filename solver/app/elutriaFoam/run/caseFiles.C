/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/caseFiles.H"
#include "IOdictionary.H"
#include "OSspecific.H"
#include "Time.H"
#include "wordRes.H"

#include <fstream>
#include <sstream>

namespace Foam
{

namespace
{

//- Read by the run; PHASE and CLOUD stand for the case's own names
const char* const readFiles[] =
{
    "constant/g",
    "constant/transportProperties",
    "constant/turbulenceProperties.PHASE",
    "constant/feed",
    "constant/CLOUDProperties",
    "constant/CLOUDPositions",
    "constant/fvOptions",
    "system/controlDict",
    "system/fvSchemes",
    "system/fvSolution",
    "system/fvOptions",
    "system/scenePlan",
    "system/decomposeParDict"
};

//- Of programs that make the mesh or evaluate a run
const char* const otherPrograms[] =
{
    "system/.*MeshDict.*",
    "system/meshDict",
    "system/meshQualityDict.*",
    "system/surface.*Dict.*",
    "system/topoSetDict.*",
    "system/create.*Dict.*",
    "system/.*ExtrudeMesh.*",
    "system/setFieldsDict.*",
    "system/mapFieldsDict.*",
    "system/changeDictionaryDict.*",
    "system/sample.*",
    "constant/.*\\.(stl|obj|vtk|eMesh|stlb|nas)(\\.gz)?"
};


dictionary fileIfThere(const fvMesh& mesh, const word& name)
{
    IOobject header
    (
        name, mesh.time().constant(), mesh,
        IOobject::READ_IF_PRESENT, IOobject::NO_WRITE, false
    );
    return IOdictionary(header);
}


[[noreturn]] void refuseEntry
(
    const fvMesh& mesh,
    const word& name,
    const string& why
)
{
    FatalErrorInFunction
        << (mesh.time().constant()/name).c_str() << ": " << why.c_str()
        << exit(FatalError);
    std::abort();
}


string textOf(const fileName& file)
{
    std::ifstream stream(file);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}


//- Files of a folder of the case, as folder/name
wordList filesOf(const fileName& root, const word& folder)
{
    DynamicList<word> found;
    for (const fileName& name : readDir(root/folder))
    {
        found.append(word(folder + '/' + name, false));
    }
    return wordList(std::move(found));
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void caseFiles::refuse(const fvMesh& mesh)
{
    const dictionary rotating(fileIfThere(mesh, "MRFProperties"));
    for (const entry& zone : rotating)
    {
        if (zone.isDict() && zone.dict().getOrDefault("active", true))
        {
            refuseEntry
            (
                mesh, "MRFProperties",
                zone.keyword() + ": elutriaFoam has no rotating zones;"
                " allowed: active no, or no such file. Walls may have a"
                " velocity (the field U)"
            );
        }
    }
    const word motion
    (
        fileIfThere(mesh, "dynamicMeshDict")
       .getOrDefault<word>("dynamicFvMesh", "staticFvMesh")
    );
    if (motion != "staticFvMesh")
    {
        refuseEntry
        (
            mesh, "dynamicMeshDict",
            "dynamicFvMesh: '" + motion + "'; allowed: staticFvMesh, since"
            " elutriaFoam moves no mesh. Walls may have a velocity (the field"
            " U)"
        );
    }
}


wordList caseFiles::unused
(
    const fvMesh& mesh,
    const word& cloud,
    const word& phase
)
{
    const fileName root(mesh.time().globalPath());
    const fileName fields(mesh.time().timePath());
    wordRes known;
    string text;
    for (string name : readFiles)
    {
        name.replaceAll("PHASE", phase).replaceAll("CLOUD", cloud);
        known.append(wordRe(name, wordRe::LITERAL));
        text += textOf(root/name);
    }
    for (const char* const pattern : otherPrograms)
    {
        known.append(wordRe(pattern, wordRe::REGEX));
    }
    const bool first = mesh.time().timeIndex() == 0;    // later ones we wrote
    const fileNameList inTime(first ? readDir(fields) : fileNameList());
    for (const fileName& name : inTime)
    {
        text += textOf(fields/name);
    }

    // A file that a used one includes, or names, is used too
    DynamicList<word> left(filesOf(root, "constant"));
    left.append(filesOf(root, "system"));
    for (label before = -1; before != left.size();)
    {
        before = left.size();
        DynamicList<word> still;
        for (const word& file : left)
        {
            if (known.match(file))
            {
                continue;
            }
            if (text.find(fileName(file).name()) == string::npos)
            {
                still.append(file);
            }
            else
            {
                text += textOf(root/file);
            }
        }
        left.transfer(still);
    }
    for (const fileName& field : inTime)
    {
        if (!mesh.foundObject<regIOobject>(field))
        {
            left.append(word(mesh.time().timeName() + '/' + field, false));
        }
    }
    return wordList(std::move(left));
}


} // End namespace Foam

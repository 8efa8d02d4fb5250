/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "foam/honoured.H"

#include <regex>

namespace Foam
{

namespace
{

using honoured::kind;
using honoured::use;

const char* const ofMppic =
    "it is of MPPICFoam; allowed: collisionModel cellList (contacts) or none"
    " instead of packingModel, dampingModel and isotropyModel, and gravity among"
    " the particleForces: without it nothing falls";

//- PHASE and CLOUD stand for the case's own names
const std::vector<honoured::Item> all =
{
    {kind::file, "constant/g", use::works, ""},
    {kind::file, "constant/transportProperties", use::works, ""},
    {kind::file, "constant/turbulenceProperties.PHASE", use::works, ""},
    {kind::file, "constant/feed", use::works, ""},
    {kind::file, "constant/CLOUDProperties", use::works, ""},
    {kind::file, "constant/CLOUDPositions", use::data, ""},
    {kind::file, "constant/fvOptions", use::works, ""},
    {kind::file, "system/controlDict", use::works, ""},
    {kind::file, "system/fvSchemes", use::works, ""},
    {kind::file, "system/fvSolution", use::works, ""},
    {kind::file, "system/fvOptions", use::works, ""},
    {kind::file, "system/scenePlan", use::works, ""},
    {kind::file, "system/decomposeParDict", use::works, ""},
    {kind::file, "system/frames", use::works, ""},
    {kind::file, "system/steering", use::works, ""},
    {kind::file, "system/.*MeshDict.*", use::others, ""},
    {kind::file, "system/meshDict", use::others, ""},
    {kind::file, "system/meshQualityDict.*", use::others, ""},
    {kind::file, "system/surface.*Dict.*", use::others, ""},
    {kind::file, "system/topoSetDict.*", use::others, ""},
    {kind::file, "system/create.*Dict.*", use::others, ""},
    {kind::file, "system/.*ExtrudeMesh.*", use::others, ""},
    {kind::file, "system/setFieldsDict.*", use::others, ""},
    {kind::file, "system/mapFieldsDict.*", use::others, ""},
    {kind::file, "system/changeDictionaryDict.*", use::others, ""},
    {kind::file, "system/sample.*", use::others, ""},
    {
        kind::file, "constant/.*\\.(stl|obj|vtk|eMesh|stlb|nas)(\\.gz)?",
        use::others, ""
    },
    {
        kind::file, "constant/MRFProperties", use::refused,
        "elutriaFoam has no rotating zones; allowed: active no, or no such"
        " file. Walls may have a velocity (the field U)"
    },
    {
        kind::file, "constant/dynamicMeshDict", use::refused,
        "allowed: staticFvMesh, since elutriaFoam moves no mesh. Walls may have"
        " a velocity (the field U)"
    },

    // What contacts of the engine do not do
    {
        kind::patchWithContacts, "cyclicAMI", use::refused,
        "contacts do not reach across it; allowed: cyclic, or collisionModel"
        " none"
    },
    {
        kind::patchWithContacts, "cyclicACMI", use::refused,
        "contacts do not reach across it; allowed: cyclic, or collisionModel"
        " none"
    },
    {kind::wallWithContacts, "rebound", use::works, ""},
    {kind::wallWithContacts, "stick", use::works, ""},
    {kind::wallWithContacts, "escape", use::works, ""},
    {kind::wallFunctionWithContacts, "facePostProcessing", use::works, ""},
    {kind::wallFunctionWithContacts, "particleErosion", use::works, ""},
    {kind::wallFunctionWithContacts, "patchCollisionDensity", use::works, ""},
    {kind::wallFunctionWithContacts, "patchPostProcessing", use::works, ""},
    {
        kind::symmetryWithContacts, "stick", use::refused,
        "rebound there, a patch of the type wall, or collisionModel none"
    },
    {
        kind::symmetryWithContacts, "escape", use::refused,
        "rebound there, a patch of the type wall, or collisionModel none"
    },
    {
        kind::symmetryFunctionWithContacts, "particleErosion", use::refused,
        "patches that are no planes of symmetry, or collisionModel none"
    },
    {
        kind::symmetryFunctionWithContacts, "patchCollisionDensity",
        use::refused, "a mesh without planes of symmetry, or collisionModel none"
    },
    {
        kind::symmetryFunctionWithContacts, "patchPostProcessing", use::refused,
        "patches that are no planes of symmetry, or collisionModel none"
    },
    {
        kind::surfaceWithContacts, "stick", use::refused,
        "rebound, or localInteraction, which names patches"
    },
    {
        kind::surfaceWithContacts, "escape", use::refused,
        "rebound, or localInteraction, which names patches"
    },
    {
        kind::surfaceFunctionWithContacts, "particleErosion", use::refused,
        "patches of the mesh"
    },
    {
        kind::surfaceFunctionWithContacts, "patchPostProcessing", use::refused,
        "patches of the mesh"
    },

    // Of stock's cloud, beside its models
    {
        kind::cloudEntry, "cellValueSourceCorrection", use::noEffect,
        "the gas takes the momentum of the whole window in one step"
    },
    {
        kind::cloudEntry, "sourceTerms", use::noEffect,
        "the gas takes the particles' drag implicitly and their other forces"
        " explicitly"
    },
    {
        kind::cloudEntry, "integrationSchemes", use::noEffect,
        "flights are exact between contacts, with the mean drag of both ends"
    },
    {kind::cloudEntry, "interpolationSchemes", use::works, ""},
    {
        kind::cloudEntry, "maxCo", use::noEffect,
        "a particle is tracked once a step, through any number of cells"
    },

    // MPPICFoam's
    {kind::cloudModel, "packingModel", use::refused, ofMppic},
    {kind::cloudModel, "dampingModel", use::refused, ofMppic},
    {kind::cloudModel, "isotropyModel", use::refused, ofMppic},

    {
        kind::particleForce, "SRF", use::refused,
        "elutriaFoam's gas has no rotating frame; allowed: nonInertialFrame"
    }
};


std::string replaced
(
    std::string text,
    const std::string& from,
    const std::string& to
)
{
    const size_t at = text.find(from);
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

const std::vector<honoured::Item>& honoured::items()
{
    return all;
}


const honoured::Item* honoured::find(const kind of, const std::string& name)
{
    for (const Item& item : all)
    {
        if (item.of == of && std::regex_match(name, std::regex(item.name)))
        {
            return &item;
        }
    }
    return nullptr;
}


bool honoured::isRefused(const kind of, const std::string& name)
{
    const Item* const item = find(of, name);
    return item && item->is == use::refused;
}


std::string honoured::named
(
    const Item& item,
    const word& cloud,
    const word& phase
)
{
    return replaced(replaced(item.name, "CLOUD", cloud), "PHASE", phase);
}


} // End namespace Foam

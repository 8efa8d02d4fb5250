/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/stockRecords.H"
#include "foam/foamVersion.H"
#include "IOField.H"
#include "OSspecific.H"
#include "Time.H"
#include "cloud.H"
#include "labelField.H"
#include "vectorField.H"

namespace Foam
{

namespace
{

IOobject inCloud
(
    const word& name,
    const word& cloudName,
    const polyMesh& mesh,
    const IOobject::readOption read
)
{
    return IOobject
    (
        name,
        mesh.time().timeName(),
        cloud::prefix/cloudName,
        mesh,
        read,
        IOobject::NO_WRITE,
        false
    );
}


template<class Type>
void writeEmpty(const IOobject& io, const label parcels)
{
    if (!isFile(io.objectPath()))
    {
        listsInFile<Type>(io, parcels).write();
    }
}

} // End anonymous namespace


const word& withStockRecords(const word& cloudName, const polyMesh& mesh)
{
    const auto object = [&](const word& name, const IOobject::readOption read)
    {
        return inCloud(name, cloudName, mesh, read);
    };
    const label parcels =
        IOField<label>(object("origId", IOobject::READ_IF_PRESENT)).size();
    if (parcels)
    {
        for
        (
            const char* const name :
            {
                "PairAccessed", "PairOrigProcOfOther", "PairOrigIdOfOther",
                "WallAccessed"
            }
        )
        {
            writeEmpty<label>
            (
                object(word("collisionRecords") + name, IOobject::NO_READ),
                parcels
            );
        }
        for (const char* const name : {"PairData", "WallPRel", "WallData"})
        {
            writeEmpty<vector>
            (
                object(word("collisionRecords") + name, IOobject::NO_READ),
                parcels
            );
        }
    }
    return cloudName;
}


} // End namespace Foam

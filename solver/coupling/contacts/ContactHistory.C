/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/ContactHistory.H"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "foam/stateFile.H"
#include "core/ParticleName.hpp"
#include "islands/SortedContacts.hpp"
#include "parallel/Message.hpp"
#include "IOField.H"

namespace Foam
{

namespace
{

using elutria::dem::ParticleName;

//- Labels of one record: two names of 64 bits in halves, wall or not
constexpr label nLabels = 5;

//- Those of all processors, on the master
std::vector<elutria::dem::ContactRecord> allContacts
(
    const elutria::dem::Engine& engine
)
{
    using namespace elutria::dem;
    std::vector<Outgoing> toEach(engine.exchange().ranks());
    toEach[0] << engine.exportContacts();
    std::vector<std::vector<ContactRecord>> lists;
    for (const Bytes& bytes : engine.exchange().swap(taken(toEach)))
    {
        if (!bytes.empty())
        {
            lists.push_back(Incoming(bytes).get<std::vector<ContactRecord>>());
        }
    }
    return SortedContacts(joined(lists)).records();
}

} // End anonymous namespace


void contactHistory::write(const cloud& c, const elutria::dem::Engine& engine)
{
    const auto records = allContacts(engine);

    IOField<label> names
    (
        stateFile(c, "contactNames", IOobject::NO_READ),
        label(nLabels*records.size())
    );
    IOField<vector> displacements
    (
        stateFile(c, "contactDisplacements", IOobject::NO_READ),
        label(records.size())
    );

    label i = 0;
    for (const auto& record : records)
    {
        const ParticleName first(record.first), second(record.second);
        names[nLabels*i] = label(first.origin);
        names[nLabels*i + 1] = label(first.number);
        names[nLabels*i + 2] = label(second.origin);
        names[nLabels*i + 3] = label(second.number);
        names[nLabels*i + 4] = record.wall;
        displacements[i++] = toFoam(record.tangential);
    }
    names.write();
    displacements.write();
}


void contactHistory::read(const cloud& c, elutria::dem::Engine& engine)
{
    const IOobject namesHeader
    (
        stateFile(c, "contactNames", IOobject::READ_IF_PRESENT)
    );
    const IOField<label> names(namesHeader);
    const IOField<vector> displacements
    (
        stateFile(c, "contactDisplacements", IOobject::READ_IF_PRESENT)
    );

    std::vector<elutria::dem::ContactRecord> records(displacements.size());
    if (names.size() != nLabels*displacements.size())
    {
        FatalErrorInFunction
            << namesHeader.objectPath() << " has " << names.size()
            << " entries, allowed: " << nLabels*displacements.size()
            << exit(FatalError);
    }
    forAll(displacements, i)
    {
        const label* name = names.cdata() + nLabels*i;
        records[i].first = ParticleName(name[0], name[1]).id();
        records[i].second = ParticleName(name[2], name[3]).id();
        records[i].wall = name[4];
        records[i].tangential = toEngine(displacements[i]);
    }
    if (Pstream::master())
    {
        engine.importContacts(records);
    }
}


} // End namespace Foam

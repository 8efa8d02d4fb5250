/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/nothingLost.H"
#include "foam/digits.H"
#include "cloud/ElutriaCloud.H"
#include "foam/foamVersion.H"

namespace Foam
{

void requireNothingLost(const fvMesh& mesh, const ElutriaCloud& cloud)
{
    const label lost = cloud.count().lost;
    const labelList gone(cloud.goneThrough());
    if (lost == 0 || !Pstream::master())
    {
        return;
    }
    const Ledger& ledger = *cloud.ledger();
    OStringStream text;
    text<< lost << " parcels";
    if (ledger.lost().parcels == lost)
    {
        text<< ", " << ledger.lost().mass << " kg ("
            << percent(ledger.lost().mass/ledger.injectedMass()).c_str()
            << " of the feed)";
    }
    text<< " are in no product and not inside";
    forAll(gone, patchi)
    {
        if (gone[patchi] > 0 && cloud.feed()->productOfPatch(patchi) < 0)
        {
            text<< "; " << gone[patchi] << " left through the patch "
                << mesh.boundaryMesh()[patchi].name();
        }
    }
    FatalErrorInFunction
        << text.str().c_str() << "; allowed: none lost; name each patch that"
        << " particles leave through in outlets of constant/feed"
        << exit(FatalError);
}


} // End namespace Foam

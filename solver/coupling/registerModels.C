/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Enters Elutria's models in OpenFOAM's selection tables.

\*---------------------------------------------------------------------------*/

#include "basicKinematicCollidingCloud.H"
#include "contacts/CellListCollision.H"
#include "forces/ContinuousDispersion.H"
#include "feed/FeedInjection.H"
#include "outlets/OutletRecorder.H"
#include "forces/LawDragForce.H"
#include "laws/DragLaws.hpp"
#include "foam/foamVersion.H"

namespace Foam
{

typedef basicKinematicCollidingCloud::kinematicCloudType kinematicCloud_;
typedef basicKinematicCollidingCloud::collidingCloudType collidingCloud_;

// One line per model: its template, its cloud and the table it is entered in
#define enterModel(Model, Table, Cloud)                                        \
    defineNamedTemplateTypeNameAndDebug(Model<Cloud>, 0);                      \
    Table<Cloud>::adddictionaryConstructorToTable<Model<Cloud>>                \
        add##Model##ToTable_;

enterModel(CellListCollision, CollisionModel, collidingCloud_)
enterModel(FeedInjection, InjectionModel, kinematicCloud_)
enterModel(OutletRecorder, CloudFunctionObject, kinematicCloud_)
enterModel(ContinuousDispersion, DispersionModel, kinematicCloud_)

#define enterDragLaw(Law)                                                      \
    typedef LawDragForce<kinematicCloud_, elutria::laws::Law> Law##Force_;          \
    defineTemplateTypeNameAndDebugWithName                                     \
    (                                                                          \
        Law##Force_, elutria::laws::Law::name, 0                                    \
    );                                                                         \
    ParticleForce<kinematicCloud_>::                                           \
        adddictionaryConstructorToTable<Law##Force_> add##Law##ToTable_;

ELUTRIA_FOR_EACH_DRAG_LAW(enterDragLaw)

} // End namespace Foam

// Drag laws, each a stateless struct of one file in drag/. Each gives Cd Re, where
//
//     drag force = (mass/rho_p) (3/4) mu (Cd Re)/d^2 (u - v)
//
// Re = rho |u - v| d/mu with the interstitial slip, d the diameter of the sphere of equal volume, alpha
// the void fraction (gas volume per volume, 1 when dilute); Form.hpp has what else a law may know.
//
// The gas equation keeps the whole pressure gradient (model B of Gidaspow 1994), so that laws for
// dense suspensions carry a factor 1/alpha.
//
// A law says where it was made (maxRe, minAlpha: use beyond is reported), and whether it depends on
// the void fraction, on the shape, and on the mean size around (knowsVoid, knowsShape, knowsMean).
//
// To add a law: write drag/NAME.hpp, include it here and add NAME to the list. The solver then knows
// it as a particle force, the tools by the C interface.
#pragma once

#include "drag/BagheriBonadonna.hpp"
#include "drag/Beetstra.hpp"
#include "drag/Clift.hpp"
#include "drag/DiFelice.hpp"
#include "drag/Ganser.hpp"
#include "drag/Gidaspow.hpp"
#include "drag/HaiderLevenspiel.hpp"
#include "drag/HoelzerSommerfeld.hpp"
#include "drag/MeasuredVelocity.hpp"
#include "drag/Putnam.hpp"
#include "drag/SchillerNaumann.hpp"
#include "drag/WenYu.hpp"

#include <string>
#include <vector>

/// The laws that are particle forces of ours: use(NAME) once each.
#define ELUTRIA_FOR_EACH_DRAG_LAW(use)                                                             \
    use(SchillerNaumann) use(Clift) use(HaiderLevenspiel) use(Ganser) use(HoelzerSommerfeld)        \
    use(BagheriBonadonna) use(BagheriBonadonnaFlat) use(MeasuredVelocity)                          \
    use(DiFelice) use(WenYu) use(Gidaspow) use(Beetstra)

namespace elutria::laws
{

/// A law, where it is chosen while the program runs.
struct DragLaw
{
    const char* name;      // as a case's particleForces name it
    const char* title;     // as a person does
    double maxRe, minAlpha;
    bool knowsVoid, knowsShape, knowsMean;
    double (*CdRe)(double Re, double alpha, const Form&);
};

/// All of them, and OpenFOAM's own law of spheres.
const std::vector<DragLaw>& dragLaws();

/// By its title, or the name of a particle force, ours or OpenFOAM's where it is the same law; null:
/// not known.
const DragLaw* findDragLaw(const std::string& name);

} // namespace elutria::laws

// Undisturbed slip of a particle that feels gas slowed by its own drag: the self-induced velocity.
//
// Two-way coupling lets a particle sample gas that its own drag has slowed, while drag laws are made
// for the slip against undisturbed gas. A drag S s (S: kg/s, s: slip) that acts on the gas through a
// Gaussian of standard deviation w moves the gas in its middle by
//
//     u = S s b,   b = sqrt(2/pi)/(6 pi mu w)/(1 + 0.5 |s| w/nu)
//
// against the slip: the regularised Stokeslet (Maxey & Patel 2001,
// doi 10.1016/S0301-9322(01)00014-3), and the Oseen equation's steady answer, of which
// 1/(1 + 0.5 Re) is a fit within 3 %. Then s = sampled slip/(1 - S b). The same idea for other
// kernels: Horwitz & Mani 2016, doi 10.1016/j.jcp.2016.05.034; Evrard, Denner & van Wachem 2020,
// doi 10.1016/j.ijmultiphaseflow.2020.103264.
//
// Neighbours at the mean distance l reduce b by 2.837/(6 pi mu l) (Hasimoto 1959,
// doi 10.1017/S0022112059000222): in a suspension the mean gas velocity that drag laws refer to
// includes what all particles do together. Where inertia dominates, little of b is left: in dense
// suspensions the neighbours dominate the local velocity.
//
// On cells of side h, Stokes' equations on a lattice with our gas equation's way of putting the force
// on faces move a particle's cell as a Gaussian does (within 2 %) of
//
//     w^2 = (0.337 h)^2 + kernel^2 min(1, 0.28 + 0.57 kernel/h).
//
// Where inertia dominates (s h/nu >> 12) the gas carries the force of a hovering particle out of its
// cell, u = F/(rho s h^2); slow gas that a particle rises with stays around it, while a particle that
// falls leaves it behind:
//
//     w^2 = (0.277 h)^2 + kernel^2 min(1, 0.75 kernel/h),
//     u times 1 + 1.3 v/s (0.277 h/w)^2,  v: velocity relative to the cells along the slip,
//                                         |v| <= 0.4 s
//
// Between the two, w^2 changes over with s h/nu, nu including the gas' turbulence. While the gas is
// not solved, a particle moves out of the disturbance that it made when the gas was last solved; after
// the distance x along the slip it still feels
//
//     u times (1 + erf(x/(sqrt(2) w))) exp(-(max(x, 0)/(4 w))^2).
//
// These are fits to single grains (verification book, chapter wake). Steady, unbounded gas is assumed.
#pragma once

namespace elutria::laws
{

/// Gas around a particle's deposit of force.
struct DepositSurroundings
{
    double kernel;      // m, standard deviation of the smoothing; 0: none
    double cellSize;    // m
    double spacing;     // m, to the particles around
    double mu, nu;      // Pa s, m2/s: of the gas and its turbulence
};

/// Motion of a particle relative to the gas, all along the slip.
struct DepositMotion
{
    double slip;        // m/s, undisturbed
    double velocity;    // m/s, relative to the cells
    double distance;    // m, since the gas was solved
};

/// Share of the undisturbed slip that a particle of drag rate S [kg/s] has taken from the gas that it
/// samples; at most 0.5.
double selfInducedShare(double dragRate, const DepositMotion&, const DepositSurroundings&);

/// Is the disturbance so far behind [m] that nothing of it is felt? No deposit is wider than cell and
/// kernel together.
bool outOfDisturbance(double distance, double kernel, double cellSize);

/// Part of a deposit that stays in its cell (diffusion on a lattice).
double depositKept(double kernel, double cellSize);

/// Distance to neighbours, m, from the solid fraction in the cell of a parcel of that volume [m3]; what
/// may still be the parcel's own is not counted.
double neighbourSpacing(double solidFraction, double parcelVolume, double ownFraction);

} // namespace elutria::laws

#pragma once

#include "laws/ContactForce.hpp"
#include "laws/ContactMaterials.hpp"

namespace elutria::dem
{

/// A contact law as the engine calls it: the members of the law's struct. A law is one file, see
/// HertzMindlin.hpp; contactLaw<Law> is what Settings take. Radius and mass are the effective ones.
struct ContactLaw
{
    using Coefficients = laws::Coefficients;

    const char* name;                  // also the word in dictionaries
    bool givenStiffness;               // by PairProperties::normalStiffness, not by moduli
    bool givenDamping;                 // by PairProperties::damping, not by the restitution
    double wayOverOverlap;             // contact time times closing speed over largest overlap

    /// Of two materials; friction, rolling resistance and cohesion are added by LawTable.
    Coefficients (*coefficients)(const ContactMaterial&, const ContactMaterial&,
                                 const PairProperties&);
    double (*elasticForce)(const Coefficients&, double radius, double overlap);        // N
    /// s; an impact's duration is this times a number of the law.
    double (*timeScale)(const Coefficients&, double radius, double mass, double speed);
    double (*contactTime)(const Coefficients&, double radius, double mass, double speed);    // s
    double (*largestOverlap)(const Coefficients&, double radius, double mass, double speed); // m
    double (*storedEnergy)(const Coefficients&, double radius, double overlap);        // J
    /// Whether one impulse, tabulated over sliding against closing speed, can stand for a contact.
    bool (*impactSuffices)(const Coefficients&);

    /// Force of one contact, also in the step in which it begins or ends; advances its history.
    ContactForce (*force)(const Coefficients&, const Encounter&, ContactHistory&, StepWeights);
};

namespace laws
{

template<class Law>
double elasticForce(const Coefficients& c, double radius, double overlap)
{
    Kinematics<double> k{};
    k.normal = {0, 0, 1};
    k.overlap = overlap, k.radius = radius;
    return Law::force(c, k).elastic;
}

} // namespace laws

template<class Law>
inline constexpr ContactLaw contactLaw = {
    Law::name, Law::givenStiffness, Law::givenDamping, Law::wayOverOverlap,
    Law::coefficients, laws::elasticForce<Law>, Law::timeScale, Law::contactTime,
    Law::largestOverlap, Law::storedEnergy, Law::impactSuffices, contactForce<Law>};

} // namespace elutria::dem

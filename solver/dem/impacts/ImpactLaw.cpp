#include "impacts/ImpactLaw.hpp"

#include "laws/ContactForce.hpp"
#include "laws/LawTable.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

constexpr double tangentialMobility = 3.5;     // effective mass over tangential one: 1 + m R^2/I
constexpr int tableSize = 192;
constexpr double stepsPerContact = 400;
constexpr double mostRolling = 0.01;           // beyond it rolling and sliding cannot be told apart

struct Outcome
{
    double restitution, tangentialImpulse, duration;
};

/// One contact at unit stiffness, effective mass, radius and closing speed, sliding speed `ratio`,
/// under a constant acceleration `press` towards each other.
Outcome integrate(const ContactLaw& law, const laws::Coefficients& coefficients, double ratio,
                  double press = 0)
{
    laws::Coefficients c = coefficients;
    c.stiffness = 1;
    const double step = laws::pi/std::sqrt(c.elastic)/stepsPerContact;
    const StepWeights weights{0.5*step, 0.5*step};
    ContactHistory history;
    double overlap = 0, closing = 1, sliding = ratio;
    double push = -press, drag = 0;            // accelerations at the end of the last step
    double impulse = 0;
    for (int i = 1; i < 100*stepsPerContact; ++i)
    {
        overlap += step*(closing - 0.5*step*push);
        const Encounter e{{0, 0, 1}, overlap, {sliding + step*tangentialMobility*drag, 0,
                                               step*push - closing}, 1, 1};
        const ContactForce f = law.force(c, e, history, weights);
        impulse += 0.5*step*(drag + f.tangential.x);
        closing -= 0.5*step*(push + f.normal - press);
        sliding += 0.5*step*tangentialMobility*(drag + f.tangential.x);
        push = f.normal - press;
        drag = f.tangential.x;
        if (!history.touching)
            return {-closing + 0.5*step*push, -impulse, i*step};
    }
    return {0, 0, 100*laws::pi};               // never apart again: not an impact
}

/// Change of spin by a unit of angular impulse, 1/(kg m^2).
double spinMobility(const ImpactBody& body)
{
    return body.radius > 0 ? 2.5*body.inverseMass/(body.radius*body.radius) : 0;
}

/// Angular impulse of the rolling resistance (see rollingTorque in ContactForce.hpp): `strength`, N s,
/// times the effective radius, at most what stops the relative spin.
void resistRolling(ImpactBody& a, ImpactBody& b, double strength)
{
    const Vector3 spin = a.spin - b.spin;
    const double speed = norm(spin);
    if (!(speed > 0)) return;
    const double radius = b.radius > 0 ? a.radius*b.radius/(a.radius + b.radius) : a.radius;
    const double mobilityA = spinMobility(a), mobilityB = spinMobility(b);
    const double impulse = std::min(strength*radius, speed/(mobilityA + mobilityB));
    a.spin -= (mobilityA*impulse/speed)*spin;
    b.spin += (mobilityB*impulse/speed)*spin;
}

} // namespace


ImpactLaw::ImpactLaw(const LawTable& laws, const ContactMaterials& materials, std::uint32_t a,
                     std::uint32_t b)
  : law_(&laws.law()), coefficients_(laws(a, b))
{
    const laws::Coefficients& c = coefficients_;
    const ContactLaw& law = *law_;
    const Outcome central = integrate(law, c, 0);
    dimensionlessTime_ = central.duration;
    restitution_ = law.givenDamping ? std::clamp(central.restitution, 0.0, 1.0)
                                    : materials.pair(a, b).restitution;
    // at the dashpots' own time scale; the integration's own error falls out of the difference
    const double press = ImpactLaw::mostPressing/central.duration;
    pressingSlope_ = (integrate(law, c, 0, press).restitution
                      - integrate(law, c, 0, -press).restitution)/(2*ImpactLaw::mostPressing);
    applies_ = c.cohesion == 0 && c.rolling <= mostRolling && central.duration < 100
        && law.impactSuffices(c);
    if (!applies_ || c.friction == 0) return;

    // Gross sliding is certain from this ratio on; half as much again for the law's own dashpot.
    const double sliding = c.friction*(1 + restitution_);
    const double spacing = 1.5*tangentialMobility*sliding/tableSize;
    inverseSpacing_ = 1/spacing;
    table_.assign(tableSize + 1, 0.0);
    for (int k = 1; k <= tableSize; ++k)
    {
        const double ratio = k*spacing;
        // A spring that stiffens under load can give back more than it took: energy may not grow.
        const double elastic = 2*ratio/tangentialMobility;
        table_[k] = std::clamp(integrate(law, c, ratio).tangentialImpulse, 0.0, elastic);
    }
    table_.back() = sliding;
}


ImpactTable::ImpactTable(const LawTable& laws, const ContactMaterials& materials)
{
    for (std::uint32_t a = 0; a < materials.size(); ++a)
        for (std::uint32_t b = 0; b <= a; ++b) laws_.emplace_back(laws, materials, a, b);
}


bool collide(ImpactBody& a, ImpactBody& b, const Vector3& normal, const ImpactLaw& law,
             double pressing)
{
    const Vector3 relative = a.velocity - b.velocity
                             - cross(a.radius*a.spin + b.radius*b.spin, normal);
    const double closing = -dot(relative, normal);
    if (!(closing > 0)) return false;
    const double mass = 1/(a.inverseMass + b.inverseMass);
    const Vector3 sliding = relative + closing*normal;
    const double speed = norm(sliding);
    const double push = (1 + law.restitution(pressing))*mass*closing;

    Vector3 tangential;
    if (speed > 0)
        tangential = (-mass*closing*law.tangentialImpulse(speed/closing)/speed)*sliding;
    const Vector3 impulse = push*normal + tangential;
    a.velocity += a.inverseMass*impulse;
    b.velocity -= b.inverseMass*impulse;
    const Vector3 turn = cross(normal, tangential);   // solid spheres: radius/inertia = 2.5/(m r)
    if (a.radius > 0) a.spin -= (2.5*a.inverseMass/a.radius)*turn;
    if (b.radius > 0) b.spin -= (2.5*b.inverseMass/b.radius)*turn;
    if (law.rolling() > 0) resistRolling(a, b, law.rolling()*push);
    return true;
}

} // namespace elutria::dem

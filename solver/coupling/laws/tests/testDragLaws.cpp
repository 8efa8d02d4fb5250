// Drag laws against published values, deviations and limits. The tool's tests hold them to values
// that other codes tabulate.
#include "DragLaws.hpp"

#include "near.hpp"

#include <cmath>
#include <string>

using namespace elutria::laws;

namespace
{

double Cd(const char* law, double Re, double alpha = 1, double sphericity = 1)
{
    const DragLaw* found = findDragLaw(law);
    REQUIRE(found);
    return found->CdRe(Re, alpha, {sphericity})/Re;
}

} // namespace

TEST_SUITE("drag laws")
{

// The standard curve of Clift, Grace and Weber 1978, Bubbles, Drops and Particles, at these Re
constexpr double reynolds[]{0.5, 50, 500, 2500}, standardCurve[]{51.54, 1.574, 0.5549, 0.4082};

TEST_CASE("the standard curve of Clift, Grace and Weber in four of its pieces")
{
    // 5e-4: they give it in four digits
    for (int i = 0; i < 4; ++i) CHECK(Cd("CliftDrag", reynolds[i]) == near(standardCurve[i], 5e-4));
}

TEST_CASE("laws of spheres leave the standard curve by as much as is known of them")
{
    const struct { const char* law; double percent[4]; } known[]{
        {"SchillerNaumannDrag", {1.8, -2.3, 1.4, 7.8}},
        {"sphereDrag", {2.9, -0.5, -0.5, 3.9}},
        {"DiFeliceDrag", {6.8, 8.8, 28.6, 29.1}}};
    for (const auto& k : known)
        for (int i = 0; i < 4; ++i)
        {
            CAPTURE(k.law);
            CAPTURE(reynolds[i]);
            // 0.1: the deviations are given in tenths, the curve to 0.05 %
            const double percent = 100*(Cd(k.law, reynolds[i])/standardCurve[i] - 1);
            CHECK(std::abs(percent - k.percent[i]) < 0.1);
        }
}

TEST_CASE("drag is Newton's above Re 1000, and nearly continuous there")
{
    for (const char* law : {"SchillerNaumannDrag", "sphereDrag"})
    {
        CAPTURE(law);
        CHECK(Cd(law, 1001) == near(Cd(law, 1e5), 1e-12));
        // Schiller and Naumann's 0.44 has two digits: the curve ends within 0.005 of it
        CHECK(std::abs(Cd(law, 999) - Cd(law, 1001)) < 0.005);
    }
}

TEST_CASE("all laws of single spheres end in Stokes' drag, 24/Re")
{
    for (const char* law : {"CliftDrag", "SchillerNaumannDrag", "sphereDrag", "HaiderLevenspielDrag",
                            "GanserDrag", "BagheriBonadonnaDrag", "BagheriBonadonnaFlatDrag",
                            "MeasuredVelocityDrag", "WenYuVoidDrag", "GidaspowDrag", "BeetstraDrag"})
    {
        CAPTURE(law);
        // 1e-4: what inertia adds at this Re is less than 0.2 Re^0.64
        CHECK(1e-6*Cd(law, 1e-6) == near(24, 1e-4));
    }
}

TEST_CASE("Hoelzer and Sommerfeld's law: spheres, and a slender spheroid in Stokes' range")
{
    const double percent[]{2, -16, 9, 20};
    for (int i = 0; i < 4; ++i)
    {
        const double ratio = Cd("HoelzerSommerfeldDrag", reynolds[i])/standardCurve[i];
        CHECK(std::abs(100*(ratio - 1) - percent[i]) < 0.6);
    }
    CHECK(1e-10*Cd("HoelzerSommerfeldDrag", 1e-10) == near(24, 1e-5));

    // Mean over all orientations of a prolate spheroid, 5 to 1, in creeping flow: Perrin 1934. Its
    // sphericity from the closed form of its surface. 0.1: the law has no exact limit for shapes
    const double p = 5, e = std::sqrt(1 - 1/(p*p));
    const double surface = 0.5*(1 + p*std::asin(e)/e);      // over that of the sphere of its width
    const double sphericity = std::pow(p, 2.0/3)/surface;
    const double perrin = std::sqrt(p*p - 1)/(std::cbrt(p)*std::log(p + std::sqrt(p*p - 1)));
    CHECK(1e-10*Cd("HoelzerSommerfeldDrag", 1e-10, 1, sphericity)/24 == near(perrin, 0.1));
}

/// Of a spheroid over the sphere of equal volume in creeping flow, aspect p (Happel & Brenner 1965,
/// 4-30 and 5-11): along the axis and across it
struct SpheroidDrag { double along, across; };

SpheroidDrag prolate(double p)
{
    const double q = p*p - 1, log = std::log(p + std::sqrt(q))/std::sqrt(q);
    return {4.0/3*q/((2*p*p - 1)*log - p)/std::cbrt(p), 8.0/3*q/((2*p*p - 3)*log + p)/std::cbrt(p)};
}

SpheroidDrag oblate(double f)
{
    const double q = 1 - f*f, arc = std::acos(f)/std::sqrt(q);
    return {4.0/3*q/(f + (1 - 2*f*f)*arc)/std::cbrt(f), 8.0/3*q/(-f + (3 - 2*f*f)*arc)/std::cbrt(f)};
}

/// Over all orientations the mobilities are averaged
double tumbling(const SpheroidDrag& drag) { return 3/(1/drag.along + 2/drag.across); }

double creeping(const char* law, const Form& form)
{
    return findDragLaw(law)->CdRe(1e-12, 1, form)/24;
}

TEST_CASE("Bagheri and Bonadonna's law: spheroids in creeping flow, tumbling and flat")
{
    // 0.1: the mean error that they give
    for (const double slender : {0.7, 0.4, 0.2})
    {
        CAPTURE(slender);
        const Form needle{1, 1, slender}, disc{1, slender, 1};
        CHECK(creeping("BagheriBonadonnaDrag", needle) == near(tumbling(prolate(1/slender)), 0.1));
        CHECK(creeping("BagheriBonadonnaDrag", disc) == near(tumbling(oblate(slender)), 0.1));
        CHECK(creeping("BagheriBonadonnaFlatDrag", needle) == near(prolate(1/slender).across, 0.1));
        CHECK(creeping("BagheriBonadonnaFlatDrag", disc) == near(oblate(slender).along, 0.1));
    }
}

TEST_CASE("less round particles have more drag, where the law knows of their shape")
{
    for (const DragLaw& law : dragLaws())
    {
        CAPTURE(law.name);
        const double round = law.CdRe(100, 1, {}), flat = law.CdRe(100, 1, {0.6, 0.4, 0.5});
        if (law.knowsShape) CHECK(flat > 1.3*round);
        else CHECK(flat == round);
    }
}

TEST_CASE("a law's range reaches below void fraction 0.9 where it knows of the void fraction")
{
    for (const DragLaw& law : dragLaws())
    {
        CAPTURE(law.name);
        CHECK(law.knowsVoid == (law.CdRe(100, 0.6, {}) != law.CdRe(100, 1, {})));
        CHECK(law.knowsVoid == (law.minAlpha < 0.9));
    }
}

TEST_CASE("a packed bed's drag is Ergun's pressure drop")
{
    // 1 mm spheres in air, 0.4 m/s superficial; dp/L by Ergun 1952
    const double d = 1e-3, mu = 1.8e-5, rho = 1.2, superficial = 0.4;
    for (const double alpha : {0.42, 0.79})
    {
        const double solid = 1 - alpha;
        const double drop = 150*mu*superficial*solid*solid/(d*d*alpha*alpha*alpha)
                          + 1.75*rho*superficial*superficial*solid/(d*alpha*alpha*alpha);

        const double slip = superficial/alpha, Re = rho*slip*d/mu;
        const double perVolume = 0.75*mu*slip/(d*d)*Cd("GidaspowDrag", Re, alpha)*Re;
        CHECK(solid*perVolume == near(drop, 1e-12));
    }
}

TEST_CASE("Gidaspow's drag is Wen and Yu's from void fraction 0.8 on")
{
    for (const double alpha : {0.8, 0.81, 0.95})
        CHECK(Cd("GidaspowDrag", 30, alpha) == Cd("WenYuVoidDrag", 30, alpha));
}

/// n of a suspension that settles with u = v alpha^n, u superficial, Re of the single sphere. In our
/// gas equation the drag carries weight less buoyancy.
double settlingExponent(const char* law, double Re, double alpha)
{
    const double carried = Cd(law, Re)*Re*Re;
    double low = 1e-3*Re, high = Re;      // of the slip between the others
    for (int i = 0; i < 60; ++i)
    {
        const double middle = 0.5*(low + high);
        (Cd(law, middle, alpha)*middle*middle < carried ? low : high) = middle;
    }
    return std::log(alpha*low/Re)/std::log(alpha);
}

TEST_CASE("a suspension by Wen and Yu settles as measured where viscosity or inertia rules")
{
    for (const double alpha : {0.6, 0.7, 0.8})
    {
        // Richardson and Zaki 1954 measured n = 4.65 below Re 0.2; 1e-4: inertia, as above
        CHECK(settlingExponent("WenYuVoidDrag", 1e-6, alpha) == near(4.65, 1e-4));
        // drag goes as the velocity squared: half of Wen and Yu's 4.7, which has one decimal
        CHECK(std::abs(2*settlingExponent("WenYuVoidDrag", 1e5, alpha) - 4.7) < 0.0501);
    }
}

TEST_CASE("Di Felice's exponent is 3.7 in creeping and in fast flow, 3.05 at Re 32")
{
    // Di Felice 1994: drag on a sphere at the same superficial Re goes as alpha^-exponent
    const struct { double Re, exponent; } published[]{{1e-6, 3.7}, {31.62, 3.05}, {1e9, 3.7}};
    for (const auto& p : published)
        for (const double alpha : {0.5, 0.8})
        {
            const double force = Cd("DiFeliceDrag", p.Re/alpha, alpha)/alpha;    // Cd Re over p.Re
            CHECK(-std::log(force/Cd("DiFeliceDrag", p.Re))/std::log(alpha)
                  == near(p.exponent, 1e-4));
        }
}

TEST_CASE("Beetstra's creeping flow through a dense array is Carman and Kozeny's and little more")
{
    // F = 10 phi/alpha^2 (k = 5) of a packed bed; what the fit adds fades with alpha^2, and is at
    // most 2.5 alpha^2: 1 of the single sphere, 1.5 of its first neighbours
    for (const double alpha : {0.4, 0.5, 0.6})
    {
        const double F = 1e-6*Cd("BeetstraDrag", 1e-6, alpha)/24;
        const double packed = 10*(1 - alpha)/(alpha*alpha);
        CHECK(F > packed);
        CHECK(F < packed + 2.5*alpha*alpha);
    }
}

TEST_CASE("Beetstra's law for several sizes has the values of another code")
{
    // MFIX, drag_gs.f, BVK: F of a size y over the mean's, at the mean's superficial Re, in eight
    // digits, evaluated once
    const struct { double Re, alpha, y, F; } theirs[]{
        {1, 0.45, 0.5, 10.107804}, {100, 0.45, 0.5, 24.308247},
        {1, 0.45, 2, 91.950373}, {100, 0.45, 2, 221.13134},
        {1, 0.6, 0.5, 4.7941432}, {100, 0.6, 0.5, 12.44418},
        {1, 0.6, 2, 36.799313}, {100, 0.6, 2, 95.520152},
        {1, 0.85, 0.5, 1.5395292}, {100, 0.85, 0.5, 4.9445951},
        {1, 0.85, 2, 8.9727683}, {100, 0.85, 2, 28.81836}
    };
    for (const auto& t : theirs)
    {
        Form form;
        form.overMean = t.y;
        CHECK(Beetstra::CdRe(t.y*t.Re/t.alpha, t.alpha, form)/24 == near(t.F, 1e-7));
    }
}

TEST_CASE("a packed bed of two sizes has Carman and Kozeny's pressure drop of the Sauter mean")
{
    // Each size's drag per volume, F/d^2, adds up to the mean's but for the term 0.064 alpha y^3:
    // 10 % here at most. dense: half of the volume are spheres of twice the size
    const double d[]{1, 2}, mean = 2/(1/d[0] + 1/d[1]), alpha = 0.4;
    double sum = 0;
    for (const double size : d)
    {
        Form form;
        form.overMean = size/mean;
        sum += 0.5*Beetstra::CdRe(1e-6*size, alpha, form)/(size*size);
    }
    CHECK(sum == near(24*10*(1 - alpha)/(alpha*alpha)/(mean*mean), 0.1));
}

TEST_CASE("Beetstra's law of several sizes ends in that of a single sphere, without a step")
{
    for (const double y : {0.5, 0.999999, 1.000001, 2.0})
    {
        Form form;
        form.overMean = y;
        CHECK(Beetstra::CdRe(1e-6, 1, form) == near(24, 1e-4));
        const double below = Beetstra::CdRe(10, 0.9 - 1e-9, form);
        CHECK(Beetstra::CdRe(10, 0.9 + 1e-9, form) == near(below, 1e-6));
    }
}

TEST_CASE("OpenFOAM's names of the same laws are known, and others are not")
{
    CHECK(findDragLaw("nonSphereDrag") == findDragLaw("HaiderLevenspielDrag"));
    CHECK(findDragLaw("ErgunWenYuDrag") == findDragLaw("GidaspowDrag"));
    CHECK(findDragLaw("WenYuDrag") == findDragLaw("WenYuVoidDrag"));
    CHECK(findDragLaw("sphereDrag")->name == std::string("sphereDrag"));
    CHECK(findDragLaw("PlessisMasliyahDrag") == nullptr);
    CHECK(findDragLaw("noDrag") == nullptr);
}

}

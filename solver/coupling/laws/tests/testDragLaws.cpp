// Drag laws against measured and tabulated values of the literature, never against a formula retyped.
#include "DragLaws.hpp"

#include "near.hpp"

#include <cmath>
#include <string>

using namespace elutria::laws;

namespace
{

struct Measured
{
    double Re, Cd;
};

/// A sphere's drag: Lapple & Shepherd 1940, doi 10.1021/ie50365a007, table of recommended values
constexpr Measured sphere[]{
    {0.1, 244}, {0.2, 124}, {0.3, 83.8}, {0.5, 51.5}, {0.7, 37.6}, {1, 27.2}, {2, 14.8}, {3, 10.5},
    {5, 7.03}, {7, 5.48}, {10, 4.26}, {20, 2.72}, {30, 2.12}, {50, 1.57}, {70, 1.31}, {100, 1.09},
    {200, 0.776}, {300, 0.653}, {500, 0.555}, {700, 0.508}, {1000, 0.471}, {2000, 0.421},
    {3000, 0.400}, {5000, 0.385}, {7000, 0.390}, {10000, 0.405}};

double Cd(const char* law, double Re, double alpha = 1, double sphericity = 1)
{
    const DragLaw* found = findDragLaw(law);
    REQUIRE(found);
    return found->CdRe(Re, alpha, sphericity)/Re;
}

} // namespace

TEST_SUITE("drag laws")
{

TEST_CASE("each law of spheres follows the measured drag as closely as is known of it")
{
    // law, up to Re, largest deviation there
    const struct { const char* law; double to, off; } known[]{
        {"CliftDrag", 1e4, 0.025},
        {"SchillerNaumannDrag", 700, 0.06}, {"SchillerNaumannDrag", 1e4, 0.15},
        {"sphereDrag", 700, 0.08}, {"sphereDrag", 1e4, 0.11},
        {"HaiderLevenspielDrag", 1e4, 0.1},
        {"GanserDrag", 1e4, 0.28},
        {"DiFeliceDrag", 1e4, 0.31}};
    for (const auto& k : known)
        for (const Measured& m : sphere)
            if (m.Re <= k.to)
            {
                CAPTURE(k.law);
                CAPTURE(m.Re);
                CHECK(Cd(k.law, m.Re) == near(m.Cd, k.off));
            }
}

TEST_CASE("the standard curve of Clift, Grace and Weber in four of its pieces")
{
    const Measured curve[]{{0.5, 51.54}, {50, 1.574}, {500, 0.5549}, {2500, 0.4082}};
    for (const Measured& m : curve) CHECK(Cd("CliftDrag", m.Re) == near(m.Cd, 1e-3));
}

TEST_CASE("all laws of single spheres end in Stokes' drag, 24/Re")
{
    for (const char* law : {"CliftDrag", "SchillerNaumannDrag", "sphereDrag", "HaiderLevenspielDrag",
                            "GanserDrag", "WenYuVoidDrag", "GidaspowDrag", "BeetstraDrag"})
    {
        CAPTURE(law);
        CHECK(1e-6*Cd(law, 1e-6) == near(24, 2e-3));
    }
}

TEST_CASE("less round particles have more drag, where the law knows of their shape")
{
    for (const DragLaw& law : dragLaws())
    {
        CAPTURE(law.name);
        const double round = law.CdRe(100, 1, 1), flat = law.CdRe(100, 1, 0.6);
        if (law.knowsShape) CHECK(flat > 1.3*round);
        else CHECK(flat == round);
    }
}

TEST_CASE("a law's range reaches below void fraction 0.9 where it knows of the void fraction")
{
    for (const DragLaw& law : dragLaws())
    {
        CAPTURE(law.name);
        CHECK(law.knowsVoid == (law.CdRe(100, 0.6, 1) != law.CdRe(100, 1, 1)));
        CHECK(law.knowsVoid == (law.minAlpha < 0.9));
    }
}

TEST_CASE("a packed bed's drag is Ergun's pressure drop")
{
    // 1 mm spheres in air at void fraction 0.42, 0.4 m/s superficial; dp/L by Ergun 1952
    const double d = 1e-3, alpha = 0.42, mu = 1.8e-5, rho = 1.2, superficial = 0.4;
    const double solid = 1 - alpha;
    const double drop = 150*mu*superficial*solid*solid/(d*d*alpha*alpha*alpha)
                      + 1.75*rho*superficial*superficial*solid/(d*alpha*alpha*alpha);

    const double slip = superficial/alpha, Re = rho*slip*d/mu;
    const double perVolume = 0.75*mu*slip/(d*d)*Cd("GidaspowDrag", Re, alpha)*Re;
    CHECK(solid*perVolume == near(drop, 1e-12));
}

TEST_CASE("a suspension settles as Richardson and Zaki measured")
{
    // u = v alpha^n, n = 4.45 Re^-0.1 for 1 < Re < 500 (Richardson & Zaki 1954); Re of the single
    // sphere, u superficial. In our gas equation the drag carries weight less buoyancy.
    // Not Beetstra's: that is of spheres held in place, which lets less gas through.
    const struct { const char* law; double off; } known[]{
        {"WenYuVoidDrag", 0.22}, {"DiFeliceDrag", 0.075}};
    for (const auto& k : known)
        for (const double Re : {5.0, 50.0, 300.0})
            for (const double alpha : {0.6, 0.7, 0.8})
            {
                const double carried = Cd(k.law, Re)*Re*Re;
                double low = 1e-3*Re, high = Re;      // of the slip between the others
                for (int i = 0; i < 60; ++i)
                {
                    const double middle = 0.5*(low + high);
                    (Cd(k.law, middle, alpha)*middle*middle < carried ? low : high) = middle;
                }
                CAPTURE(k.law);
                CAPTURE(Re);
                CAPTURE(alpha);
                CHECK(alpha*low/Re
                      == near(std::pow(alpha, 4.45*std::pow(Re, -0.1)), k.off));
            }
}

TEST_CASE("Beetstra's drag in a packed bed is Ergun's, within what both are known to")
{
    for (const double alpha : {0.4, 0.45, 0.5})
        for (const double superficial : {1.0, 10.0, 100.0, 500.0})
            CHECK(Cd("BeetstraDrag", superficial/alpha, alpha)
                  == near(Cd("GidaspowDrag", superficial/alpha, alpha), 0.3));
}

TEST_CASE("Beetstra's creeping flow through a dense array is Carman and Kozeny's")
{
    // F_total = 10 phi/alpha^3 (k = 5); Beetstra's F without the pressure's part is alpha of it
    const double alpha = 0.5, F = 1e-6*Cd("BeetstraDrag", 1e-6, alpha)/24;
    CHECK(F/alpha == near(10*0.5/(alpha*alpha*alpha), 0.05));
}

TEST_CASE("OpenFOAM's names of the same laws are known, and others are not")
{
    CHECK(findDragLaw("nonSphereDrag") == findDragLaw("HaiderLevenspielDrag"));
    CHECK(findDragLaw("ErgunWenYuDrag") == findDragLaw("GidaspowDrag"));
    CHECK(findDragLaw("WenYuDrag") == findDragLaw("WenYuVoidDrag"));
    CHECK(findDragLaw("noDrag") == nullptr);
}

}

// Shapes: surfaces of ellipsoids against the closed forms of spheroids.
#include "Form.hpp"

#include "near.hpp"

#include <cmath>
#include <initializer_list>

using namespace elutria::laws;

namespace
{

/// Half axes 1, 1 and a: the surface over that of the sphere of equal volume, inverted
double spheroidSphericity(double a)
{
    const double sphere = 4*M_PI*std::pow(a, 2.0/3);
    const double e = std::sqrt(a > 1 ? 1 - 1/(a*a) : 1 - a*a);
    const double surface =
        a > 1 ? 2*M_PI*(1 + a/e*std::asin(e)) : 2*M_PI*(1 + (1 - e*e)/e*std::atanh(e));
    return sphere/surface;
}

} // namespace

TEST_SUITE("form")
{

TEST_CASE("a spheroid's sphericity is that of its closed form")
{
    for (const double slender : {0.9, 0.5, 0.1})
    {
        CAPTURE(slender);
        CHECK(ellipsoidSphericity(1, slender) == near(spheroidSphericity(1/slender), 1e-9));
        CHECK(ellipsoidSphericity(slender, 1) == near(spheroidSphericity(slender), 1e-9));
    }
    CHECK(ellipsoidSphericity(1, 1) == near(1, 1e-12));
    CHECK(ellipsoidSphericity(0.999999, 0.999999) == near(1, 1e-9));
}

TEST_CASE("an ellipsoid of three axes has the surface that its patches add up to")
{
    // by the length of the normal of a fine grid on it
    const double a = 1, b = 0.6, c = 0.3;
    double surface = 0;
    const int n = 800;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
        {
            const double t = M_PI*(i + 0.5)/n, p = 2*M_PI*(k + 0.5)/n;
            const double x = b*c*std::sin(t)*std::cos(p), y = a*c*std::sin(t)*std::sin(p),
                         z = a*b*std::cos(t);
            surface += std::sin(t)*std::sqrt(x*x + y*y + z*z)*(M_PI/n)*(2*M_PI/n);
        }
    const double sphere = 4*M_PI*std::pow(a*b*c, 2.0/3);
    CHECK(ellipsoidSphericity(c/b, b/a) == near(sphere/surface, 1e-5));
}

}

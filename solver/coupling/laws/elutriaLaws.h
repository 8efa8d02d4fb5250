/* The laws for programs in other languages (libelutriaLaws.so). SI units, plain arrays of n numbers.
 *
 * Functions that can fail return 0 when they have not, else what is wrong as a text that is valid
 * until the next call of the same thread. */
#ifndef elutriaLaws_h
#define elutriaLaws_h

#ifdef __cplusplus
extern "C" {
#endif

/* kg/m3, kg/m3 and m, see FeedRules.hpp and SizeLaws.hpp */
extern const double elutriaLeastDensity, elutriaLargestDensity, elutriaLargestSize;

/* Columns of particles.csv, a comma between them */
extern const char* const elutriaParticleColumns;

/* Names of the laws, one blank between them; of a size law's parameters, in their order; 0: no such
 * law. A drag law is known by the name of its particle force, and by its title, which is what a
 * person calls it. */
const char* elutriaDragLaws(void);
const char* elutriaDragTitle(const char* law);
const char* elutriaSizeLaws(void);
const char* elutriaSizeParameters(const char* law);

/* Drag coefficient times Re, at a particle Re (interstitial slip), void fraction and form: n rows of
 * sphericity, flatness, elongation, density over the gas', size over the mean around. */
const char* elutriaCdRe(const char* law, const double* re, const double* voidFraction,
                        const double* form, double* cdRe, int n);

/* A grain's material: density, sphericity, flatness, elongation; where its terminal velocities were
 * measured, the text of a csv (see MeasuredDrag.hpp), and density and viscosity of that gas, else
 * velocities is 0. */
typedef struct
{
    double density, sphericity, flatness, elongation;
    const char* velocities;
    double gasDensity, gasViscosity;
} elutriaGrain;

/* Of an ellipsoid. */
double elutriaEllipsoidSphericity(double flatness, double elongation);

/* Terminal velocity of n sizes, and the size of n terminal velocities between two limits; 0 where
 * there is none. gas: density and viscosity. */
const char* elutriaTerminalVelocity(const char* law, const elutriaGrain* grain, const double gas[2],
                                    double gravity, const double* diameter, double* velocity, int n);
const char* elutriaSettlingSize(const char* law, const elutriaGrain* grain, const double gas[2],
                                double gravity, const double limits[2], const double* velocity,
                                double* diameter, int n);

/* A size distribution: of a law truncated to limits; of a sieve analysis, none above `most` (numbers,
 * which messages call as `named` says, or the text of a csv, see SizeTables.hpp); of several others; or
 * of a single size. From shares of mass (weighting 0) or of number (1). elutriaSizePoints() says how
 * many points its curves have; free it with elutriaFreeSizes(). */
typedef struct elutriaSizes elutriaSizes;
const char* elutriaLawSizes(const char* law, const double* parameters, const double limits[2],
                            double most, int weighting, elutriaSizes** sizes);
const char* elutriaSievedSizes(const double* diameter, const double* finer, int n,
                               const char* named, double most, int weighting, elutriaSizes** sizes);
const char* elutriaSieveTable(const char* csv, double min, int weighting, elutriaSizes** sizes);
const char* elutriaMixedSizes(elutriaSizes* const* parts, const double* shares, int n, int weighting,
                              elutriaSizes** sizes);
const char* elutriaSingleSize(double diameter, elutriaSizes** sizes);
int elutriaSizePoints(const elutriaSizes*);
double elutriaMeanCube(const elutriaSizes*);
void elutriaSizeCurves(const elutriaSizes*, double* diameter, double* massFiner,
                       double* numberFiner);
void elutriaFreeSizes(elutriaSizes*);

#ifdef __cplusplus
}
#endif

#endif

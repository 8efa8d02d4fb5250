// The kernels' body; each of kernelsBaseline.cpp, kernelsAvx2.cpp and kernelsAvx512.cpp includes it
// with its own compiler flags. Nothing here may have external linkage but the table.

#include "kernels.hpp"

namespace elutria::dem
{

namespace
{

typedef double Double4 __attribute__((vector_size(32)));
typedef float Float4 __attribute__((vector_size(16)));
typedef float Float8 __attribute__((vector_size(32)));
typedef double Double8 __attribute__((vector_size(64)));

struct Staging
{
    alignas(64) Double4 apart[contactBlock];      // x, y, z of first minus second; sum of radii
    alignas(64) Float8 relative[contactBlock];    // velocity difference, sums of 1/m, s and 1/r
    alignas(64) float dx[contactBlock], dy[contactBlock], dz[contactBlock];
    alignas(64) float distance2[contactBlock], excess[contactBlock], sum[contactBlock];
    alignas(64) float was[contactBlock];
    alignas(64) float changed[contactBlock];
    alignas(64) Float8 result[contactBlock];
    alignas(64) float coefficient[8][contactBlock];
};

ELUTRIA_INLINE void stage(const PairWork& w, std::size_t start, std::size_t count, Staging& s)
{
    const Double4 signs = {-1, -1, -1, 1};
    const Float8 relativeSigns = {-1, -1, -1, 1, 1, 1, 1, 1};
    const std::uint32_t *first = w.contacts.first + start, *second = w.contacts.second + start;
    for (std::size_t k = 0; k < count; ++k)
    {
        const Row &a = w.rows[first[k]], &b = w.rows[second[k]];
        s.apart[k] = *reinterpret_cast<const Double4*>(&a.x)
                     + signs**reinterpret_cast<const Double4*>(&b.x);
        s.relative[k] = *reinterpret_cast<const Float8*>(&a.vx)
                        + relativeSigns**reinterpret_cast<const Float8*>(&b.vx);
    }
    for (std::size_t k = count; k < contactBlock; ++k)
    {
        s.apart[k] = Double4{1, 0, 0, 0.5};
        s.relative[k] = Float8{0, 0, 0, 1, 0, 0, 0, 1};
    }
    for (std::size_t k = 0; k < contactBlock; ++k) s.was[k] = w.contacts.touching[start + k];
}

/// Shortest image by rounding to the nearest multiple of the length (adding and taking away
/// 1.5*2^52 rounds).
ELUTRIA_INLINE double shortest(double d, double length, double inverse)
{
    const double big = 6755399441055744.0;
    return d - length*((d*inverse + big) - big);
}

ELUTRIA_INLINE void measure(const PairWork& w, Staging& s)
{
    const double* apart = reinterpret_cast<const double*>(s.apart);
    const double lx = w.length[0], ly = w.length[1], lz = w.length[2];
    const double ix = w.inverseLength[0], iy = w.inverseLength[1], iz = w.inverseLength[2];
    for (std::size_t k = 0; k < contactBlock; ++k)
    {
        const double x = shortest(apart[4*k], lx, ix);
        const double y = shortest(apart[4*k + 1], ly, iy);
        const double z = shortest(apart[4*k + 2], lz, iz);
        const double sum = apart[4*k + 3], d2 = x*x + y*y + z*z;
        s.dx[k] = float(x), s.dy[k] = float(y), s.dz[k] = float(z);
        s.distance2[k] = float(d2), s.excess[k] = float(sum*sum - d2), s.sum[k] = float(sum);
    }
}

ELUTRIA_INLINE void lookUp(const PairWork& w, std::size_t start, std::size_t count, Staging& s)
{
    const std::uint32_t *first = w.contacts.first + start, *second = w.contacts.second + start;
    for (std::size_t k = 0; k < contactBlock; ++k)
    {
        const std::size_t pair = w.material == nullptr || k >= count ? 0
            : w.material[first[k]]*w.materials + w.material[second[k]];
        const laws::CoefficientsOf<float>& c = w.coefficients[pair];
        s.coefficient[0][k] = c.stiffness;
        s.coefficient[1][k] = c.elastic;
        s.coefficient[2][k] = c.damping;
        s.coefficient[3][k] = c.shear;
        s.coefficient[4][k] = c.shearDamping;
        s.coefficient[5][k] = c.friction;
        s.coefficient[6][k] = c.cohesion;
        s.coefficient[7][k] = c.exponent;
    }
}

template<ContactLaw law, bool otherExponent>
ELUTRIA_INLINE void forces(const PairWork& w, std::size_t start, Staging& s, float& largest,
                           float& changes)
{
    const float* relative = reinterpret_cast<const float*>(s.relative);
    float* result = reinterpret_cast<float*>(s.result);
    float* __restrict stretchX = w.contacts.stretchX + start;
    float* __restrict stretchY = w.contacts.stretchY + start;
    float* __restrict stretchZ = w.contacts.stretchZ + start;
    const float before = float(w.before), after = float(w.after);
    float deepest = largest, events = 0;
    for (std::size_t k = 0; k < contactBlock; ++k)
    {
        const float distance = laws::root(s.distance2[k]), inverse = 1/distance;
        const float overlap = s.excess[k]/(s.sum[k] + distance), share = distance/s.sum[k];
        const float nx = s.dx[k]*inverse, ny = s.dy[k]*inverse, nz = s.dz[k]*inverse;
        const float ux = relative[8*k], uy = relative[8*k + 1], uz = relative[8*k + 2];
        const float sx = share*relative[8*k + 4], sy = share*relative[8*k + 5],
                    sz = share*relative[8*k + 6];
        const float along = ux*nx + uy*ny + uz*nz;
        const bool touches = overlap > 0;
        const float was = s.was[k];

        laws::Touch<float> t;
        t.normal = {nx, ny, nz};
        t.slip = {ux - (sy*nz - sz*ny), uy - (sz*nx - sx*nz), uz - (sx*ny - sy*nx)};
        t.turning = {inverse*(ux - along*nx), inverse*(uy - along*ny), inverse*(uz - along*nz)};
        t.stretch = {stretchX[k], stretchY[k], stretchZ[k]};
        t.overlap = touches ? overlap : 0.0f;
        t.radius = 1/relative[8*k + 7];
        t.mass = 1/relative[8*k + 3];
        t.before = before;
        t.after = after;
        laws::CoefficientsOf<float> c;
        c.stiffness = s.coefficient[0][k];
        c.elastic = s.coefficient[1][k];
        c.damping = s.coefficient[2][k];
        c.shear = s.coefficient[3][k];
        c.shearDamping = s.coefficient[4][k];
        c.friction = s.coefficient[5][k];
        c.cohesion = s.coefficient[6][k];
        c.exponent = s.coefficient[7][k];
        const laws::Push<float> p = laws::push<law, otherExponent>(c, t);

        const float active = touches ? was : 0.0f;
        const float fx = p.tangential.x, fy = p.tangential.y, fz = p.tangential.z;
        result[8*k] = active*(p.normal*nx + fx);
        result[8*k + 1] = active*(p.normal*ny + fy);
        result[8*k + 2] = active*(p.normal*nz + fz);
        result[8*k + 3] = 0;
        result[8*k + 4] = active*share*(nz*fy - ny*fz);
        result[8*k + 5] = active*share*(nx*fz - nz*fx);
        result[8*k + 6] = active*share*(ny*fx - nx*fy);
        result[8*k + 7] = 0;
        stretchX[k] = active > 0 ? p.stretch.x : stretchX[k];
        stretchY[k] = active > 0 ? p.stretch.y : stretchY[k];
        stretchZ[k] = active > 0 ? p.stretch.z : stretchZ[k];
        const float change = (touches ? 1.0f : 0.0f) != was ? 1.0f : 0.0f;
        s.changed[k] = change;
        events = change > events ? change : events;
        const float depth = overlap*relative[8*k + 7]*0.5f;
        deepest = depth > deepest ? depth : deepest;
    }
    largest = deepest;
    changes = events;
}

ELUTRIA_INLINE void scatter(const PairWork& w, std::size_t start, std::size_t count,
                            const Staging& s)
{
    const Double8 onSecond = {-1, -1, -1, 0, 1, 1, 1, 0};
    const std::uint32_t *first = w.contacts.first + start, *second = w.contacts.second + start;
    const std::size_t inside = w.inside < start ? 0 : w.inside - start;
    const std::size_t local = inside < count ? inside : count;
    for (std::size_t k = 0; k < local; ++k)
    {
        const Double8 sum = __builtin_convertvector(s.result[k], Double8);
        Double8& a = *reinterpret_cast<Double8*>(w.loads + first[k]);
        Double8& b = *reinterpret_cast<Double8*>(w.loads + second[k]);
        a += sum;
        b += onSecond*sum;
    }
    for (std::size_t k = local; k < count; ++k)
    {
        Double8& a = *reinterpret_cast<Double8*>(w.loads + first[k]);
        a += __builtin_convertvector(s.result[k], Double8);
        *reinterpret_cast<Float8*>(w.across + (start + k - w.inside)) = s.result[k];
    }
}

template<ContactLaw law, bool otherExponent>
void pairForces(PairWork& w)
{
    Staging s;
    float largest = 0;
    lookUp(w, 0, w.contacts.count < contactBlock ? w.contacts.count : contactBlock, s);
    for (std::size_t start = 0; start < w.contacts.count; start += contactBlock)
    {
        const std::size_t left = w.contacts.count - start;
        const std::size_t count = left < contactBlock ? left : contactBlock;
        stage(w, start, count, s);
        measure(w, s);
        if (w.material != nullptr && start > 0) lookUp(w, start, count, s);
        float changes;
        forces<law, otherExponent>(w, start, s, largest, changes);
        if (changes > 0)
        {
            for (std::size_t k = 0; k < count; ++k)
            {
                if (s.changed[k] > 0)
                {
                    const Contribution c = w.transition(w.self, start + k);
                    s.result[k] = Float8{c.fx, c.fy, c.fz, 0, c.mx, c.my, c.mz, 0};
                }
            }
        }
        scatter(w, start, count, s);
    }
    w.largestOverlap = largest;
}

/// One step of every particle in the range; see SoftIntegrator for the scheme.
template<bool drag>
ELUTRIA_INLINE void moveRange(MoveWork& w)
{
    const Double4 frame = {w.frame[0], w.frame[1], w.frame[2], 0};
    const Double4 vectorOnly = {1, 1, 1, 0};
    Double4 push = {w.push[0], w.push[1], w.push[2], 0};
    double first = w.step, second = 0.5*w.step, decay = 1;
    Double4 sum = {0, 0, 0, 0};
    double fastest = 0, fastestInFrame = 0;
    for (std::size_t i = w.begin; i < w.end; ++i)
    {
        Load& load = w.loads[i];
        Base& base = w.bases[i];
        Row& row = w.rows[i];
        if (drag)
        {
            const Forcing& f = w.forcing[i];
            push = Double4{f.ax, f.ay, f.az, 0};
            first = f.first, second = f.second, decay = f.decay;
        }
        const double inverse = base.inverseMass;
        Double4& force = *reinterpret_cast<Double4*>(&load.fx);
        Double4& moment = *reinterpret_cast<Double4*>(&load.mx);
        Double4& velocity = *reinterpret_cast<Double4*>(&base.vx);
        Double4& surface = *reinterpret_cast<Double4*>(&base.sx);
        Double4& position = *reinterpret_cast<Double4*>(&row.x);
        const Double4 contact = inverse*force;
        const Double4 turn = (2.5*inverse)*moment;
        force = Double4{}, moment = Double4{};
        const Double4 v = velocity*vectorOnly + second*contact;
        const Double4 total = push + contact;
        const Double4 moved = first*v + (w.step*second)*total;
        const Double4 predicted = decay*v + first*total;
        position += moved;
        Double4 base4 = predicted - second*contact;
        base4[3] = inverse;
        velocity = base4;
        const Double4 relative = predicted - frame;
        Float4 row4 = __builtin_convertvector(relative, Float4);
        row4[3] = row.inverseMass;
        *reinterpret_cast<Float4*>(&row.vx) = row4;

        const Double4 s = surface + (0.5*w.step)*turn;
        surface = s + (0.5*w.step)*turn;
        Float4 surface4 = __builtin_convertvector(s + w.step*turn, Float4);
        surface4[3] = row.inverseRadius;
        *reinterpret_cast<Float4*>(&row.sx) = surface4;

        sum += predicted;
        const Double4 squared = moved*moved, shifted = moved - w.step*frame;
        const Double4 squaredInFrame = shifted*shifted;
        const double speed2 = squared[0] + squared[1] + squared[2];
        const double inFrame2 = squaredInFrame[0] + squaredInFrame[1] + squaredInFrame[2];
        fastest = speed2 > fastest ? speed2 : fastest;
        fastestInFrame = inFrame2 > fastestInFrame ? inFrame2 : fastestInFrame;
    }
    w.fastest = fastest/(w.step*w.step);
    w.fastestInFrame = fastestInFrame/(w.step*w.step);
    w.sum[0] = sum[0], w.sum[1] = sum[1], w.sum[2] = sum[2];
}

void move(MoveWork& w)
{
    if (w.forcing != nullptr) moveRange<true>(w);
    else moveRange<false>(w);
}

} // namespace

extern const Kernels ELUTRIA_KERNELS = {
    ELUTRIA_KERNELS_NAME,
    {pairForces<ContactLaw::linear, false>, pairForces<ContactLaw::hertz, false>,
     pairForces<ContactLaw::springSliderDashpot, false>,
     pairForces<ContactLaw::springSliderDashpot, true>},
    move};

} // namespace elutria::dem

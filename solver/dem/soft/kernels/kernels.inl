// The kernels' body; each of baseline.cpp, avx2.cpp and avx512.cpp includes it
// with its own compiler flags. Nothing here may have external linkage but the table.

#include "laws/LawList.hpp"
#include "soft/kernels/Kernels.hpp"

namespace elutria::dem
{

namespace
{

typedef double Double4 __attribute__((vector_size(32)));
typedef float Float4 __attribute__((vector_size(16)));
typedef float Float8 __attribute__((vector_size(32)));
typedef double Double8 __attribute__((vector_size(64)));

/// One block of contacts, component by component.
struct Staging
{
    alignas(64) double apart[4][contactBlock];    // x, y, z of first minus second; sum of radii
    alignas(64) float relative[8][contactBlock];  // velocity difference, 1/m, s and 1/r summed
    alignas(64) float dx[contactBlock], dy[contactBlock], dz[contactBlock];
    alignas(64) float distance2[contactBlock], excess[contactBlock], sum[contactBlock];
    alignas(64) float was[contactBlock];
    alignas(64) float changed[contactBlock];
    alignas(64) float result[8][contactBlock];
    alignas(64) Float8 rows[contactBlock];        // the same, contact by contact
    alignas(64) float coefficient[8][contactBlock];
};

/// Eight rows of eight to eight columns.
ELUTRIA_INLINE void transpose(Float8 r[8])
{
    Float8 t[8], u[8];
    for (int k = 0; k < 8; k += 2)
    {
        t[k] = __builtin_shufflevector(r[k], r[k + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        t[k + 1] = __builtin_shufflevector(r[k], r[k + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (int k = 0; k < 8; k += 4)
    {
        u[k] = __builtin_shufflevector(t[k], t[k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        u[k + 1] = __builtin_shufflevector(t[k], t[k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        u[k + 2] = __builtin_shufflevector(t[k + 1], t[k + 3], 0, 1, 8, 9, 4, 5, 12, 13);
        u[k + 3] = __builtin_shufflevector(t[k + 1], t[k + 3], 2, 3, 10, 11, 6, 7, 14, 15);
    }
    for (int k = 0; k < 4; ++k)
    {
        r[k] = __builtin_shufflevector(u[k], u[k + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        r[k + 4] = __builtin_shufflevector(u[k], u[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

/// Four rows of four to four columns.
ELUTRIA_INLINE void transpose(Double4 r[4])
{
    const Double4 a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6);
    const Double4 b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
    const Double4 c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6);
    const Double4 d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
    r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    r[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    r[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/// Differences and sums of the partners' rows. Lanes behind the last contact repeat it.
ELUTRIA_INLINE void stage(const PairWork& w, std::size_t start, std::size_t count, Staging& s)
{
    const Double4 signs = {-1, -1, -1, 1};
    const Float8 relativeSigns = {-1, -1, -1, 1, 1, 1, 1, 1};
    const std::uint32_t *first = w.contacts.first + start, *second = w.contacts.second + start;
    const std::size_t rest = w.contacts.count - start;
    for (std::size_t k = 0; k < contactBlock; k += 8)
    {
        Double4 apart[8];
        Float8 relative[8];
        for (std::size_t l = 0; l < 8; ++l)
        {
            const std::size_t m = k + l < count ? k + l : count - 1;
            const Row &a = w.rows[first[m]], &b = w.rows[second[m]];
            __builtin_prefetch(w.loads + second[m], 1);
            if (m + contactBlock < rest) __builtin_prefetch(w.rows + second[m + contactBlock]);
            apart[l] = *reinterpret_cast<const Double4*>(&a.x)
                       + signs**reinterpret_cast<const Double4*>(&b.x);
            relative[l] = *reinterpret_cast<const Float8*>(&a.vx)
                          + relativeSigns**reinterpret_cast<const Float8*>(&b.vx);
        }
        transpose(apart);
        transpose(apart + 4);
        transpose(relative);
        for (int c = 0; c < 4; ++c)
        {
            *reinterpret_cast<Double4*>(s.apart[c] + k) = apart[c];
            *reinterpret_cast<Double4*>(s.apart[c] + k + 4) = apart[c + 4];
        }
        for (int c = 0; c < 8; ++c) *reinterpret_cast<Float8*>(s.relative[c] + k) = relative[c];
    }
    for (std::size_t k = 0; k < contactBlock; ++k) s.was[k] = w.contacts.touching[start + k];
}

ELUTRIA_INLINE void collect(Staging& s)
{
    for (std::size_t k = 0; k < contactBlock; k += 8)
    {
        Float8 rows[8];
        for (int c = 0; c < 8; ++c) rows[c] = *reinterpret_cast<const Float8*>(s.result[c] + k);
        transpose(rows);
        for (std::size_t l = 0; l < 8; ++l) s.rows[k + l] = rows[l];
    }
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
    const double lx = w.length[0], ly = w.length[1], lz = w.length[2];
    const double ix = w.inverseLength[0], iy = w.inverseLength[1], iz = w.inverseLength[2];
    for (std::size_t k = 0; k < contactBlock; ++k)
    {
        const double x = shortest(s.apart[0][k], lx, ix);
        const double y = shortest(s.apart[1][k], ly, iy);
        const double z = shortest(s.apart[2][k], lz, iz);
        const double sum = s.apart[3][k], d2 = x*x + y*y + z*z;
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

template<class Law>
ELUTRIA_INLINE void forces(const PairWork& w, std::size_t start, Staging& s, float& largest,
                           float& changes, float& acts)
{
    float* __restrict displacementX = w.contacts.displacementX + start;
    float* __restrict displacementY = w.contacts.displacementY + start;
    float* __restrict displacementZ = w.contacts.displacementZ + start;
    const float before = float(w.before), after = float(w.after);
    float deepest = largest, events = 0, most = 0;
#pragma GCC ivdep
    for (std::size_t k = 0; k < contactBlock; ++k)
    {
        const float distance = laws::root(s.distance2[k]), inverse = 1/distance;
        const float overlap = s.excess[k]/(s.sum[k] + distance), share = distance/s.sum[k];
        const float nx = s.dx[k]*inverse, ny = s.dy[k]*inverse, nz = s.dz[k]*inverse;
        const float ux = s.relative[0][k], uy = s.relative[1][k], uz = s.relative[2][k];
        const float sx = share*s.relative[4][k], sy = share*s.relative[5][k],
                    sz = share*s.relative[6][k];
        const float along = ux*nx + uy*ny + uz*nz;
        const bool touches = overlap > 0;
        const float was = s.was[k];

        laws::Kinematics<float> t;
        t.normal = {nx, ny, nz};
        t.slip = {ux - (sy*nz - sz*ny), uy - (sz*nx - sx*nz), uz - (sx*ny - sy*nx)};
        t.normalRate = {inverse*(ux - along*nx), inverse*(uy - along*ny), inverse*(uz - along*nz)};
        t.displacement = {displacementX[k], displacementY[k], displacementZ[k]};
        t.overlap = touches ? overlap : 0.0f;
        t.radius = 1/s.relative[7][k];
        t.mass = 1/s.relative[3][k];
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
        const laws::Force<float> p = Law::force(c, t);

        const float active = touches ? was : 0.0f;
        const float fx = p.tangential.x, fy = p.tangential.y, fz = p.tangential.z;
        s.result[0][k] = active*(p.normal*nx + fx);
        s.result[1][k] = active*(p.normal*ny + fy);
        s.result[2][k] = active*(p.normal*nz + fz);
        s.result[4][k] = active*share*(nz*fy - ny*fz);
        s.result[5][k] = active*share*(nx*fz - nz*fx);
        s.result[6][k] = active*share*(ny*fx - nx*fy);
        displacementX[k] = active > 0 ? p.displacement.x : displacementX[k];
        displacementY[k] = active > 0 ? p.displacement.y : displacementY[k];
        displacementZ[k] = active > 0 ? p.displacement.z : displacementZ[k];
        const float change = (touches ? 1.0f : 0.0f) != was ? 1.0f : 0.0f;
        s.changed[k] = change;
        events = change > events ? change : events;
        most = active > most ? active : most;
        const float depth = overlap*s.relative[7][k]*0.5f;
        deepest = depth > deepest ? depth : deepest;
    }
    largest = deepest;
    changes = events;
    acts = most;
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
        const Double8 sum = __builtin_convertvector(s.rows[k], Double8);
        Double8& a = *reinterpret_cast<Double8*>(w.loads + first[k]);
        Double8& b = *reinterpret_cast<Double8*>(w.loads + second[k]);
        a += sum;
        b += onSecond*sum;
    }
    for (std::size_t k = local; k < count; ++k)
    {
        Double8& a = *reinterpret_cast<Double8*>(w.loads + first[k]);
        a += __builtin_convertvector(s.rows[k], Double8);
        *reinterpret_cast<Float8*>(w.across + (start + k - w.inside)) = s.rows[k];
    }
}

/// What scatter() does where no contact of the block acts.
ELUTRIA_INLINE void scatterNothing(const PairWork& w, std::size_t start, std::size_t count)
{
    const std::size_t inside = w.inside < start ? 0 : w.inside - start;
    for (std::size_t k = inside; k < count; ++k)
        *reinterpret_cast<Float8*>(w.across + (start + k - w.inside)) = Float8{};
}

template<class Law>
void pairForces(PairWork& w)
{
    w.largestOverlap = 0;
    if (w.contacts.count == 0) return;
    Staging s;
    float largest = 0;
    for (std::size_t k = 0; k < contactBlock; ++k) s.result[3][k] = s.result[7][k] = 0;
    lookUp(w, 0, w.contacts.count < contactBlock ? w.contacts.count : contactBlock, s);
    for (std::size_t start = 0; start < w.contacts.count; start += contactBlock)
    {
        const std::size_t left = w.contacts.count - start;
        const std::size_t count = left < contactBlock ? left : contactBlock;
        stage(w, start, count, s);
        measure(w, s);
        if (w.material != nullptr && start > 0) lookUp(w, start, count, s);
        float changes, acts;
        forces<Law>(w, start, s, largest, changes, acts);
        if (!(changes > 0 || acts > 0))
        {
            scatterNothing(w, start, count);
            continue;
        }
        collect(s);
        if (changes > 0)
        {
            for (std::size_t k = 0; k < count; ++k)
            {
                if (s.changed[k] > 0)
                {
                    const Contribution c = w.transition(w.self, start + k);
                    s.rows[k] = Float8{c.fx, c.fy, c.fz, 0, c.mx, c.my, c.mz, 0};
                }
            }
        }
        startSums(w.loads, w.begin, w.end, w.loaded);
        w.acrossActs = w.acrossActs || start + count > w.inside;
        scatter(w, start, count, s);
    }
    w.largestOverlap = largest;
}

/// The first three of `a`, the last of `b`.
ELUTRIA_INLINE Double4 keepLast(Double4 a, Double4 b)
{
    return __builtin_shufflevector(a, b, 0, 1, 2, 7);
}
ELUTRIA_INLINE Float4 keepLast(Float4 a, Float4 b)
{
    return __builtin_shufflevector(a, b, 0, 1, 2, 7);
}

/// One step of every particle in the range; see SoftIntegrator for the scheme.
template<bool drag, bool loaded>
ELUTRIA_INLINE void moveRange(MoveWork& w)
{
    const Double4 frame = {w.frame[0], w.frame[1], w.frame[2], 0};
    const Double4 vectorOnly = {1, 1, 1, 0};
    Double4 push = {w.push[0], w.push[1], w.push[2], 0};
    double first = w.step, second = 0.5*w.step, decay = 1;
    Double4 sum = {0, 0, 0, 0};
    Double4 fastest = {0, 0, 0, 0}, fastestInFrame = {0, 0, 0, 0};   // largest of each component
    const Double4 shift = {w.step*w.ownFrame[0], w.step*w.ownFrame[1], w.step*w.ownFrame[2], 0};
    for (std::size_t i = w.begin; i < w.end; ++i)
    {
        Base& base = w.bases[i];
        Row& row = w.rows[i];
        if (drag)
        {
            const Forcing& f = w.forcing[i];
            push = Double4{f.ax, f.ay, f.az, 0};
            first = f.first, second = f.second, decay = f.decay;
        }
        const double inverse = base.inverseMass;
        Double4& velocity = *reinterpret_cast<Double4*>(&base.vx);
        Double4& surface = *reinterpret_cast<Double4*>(&base.sx);
        Double4& position = *reinterpret_cast<Double4*>(&row.x);
        Double4 contact = {}, turn = {};
        if (loaded)
        {
            contact = inverse**reinterpret_cast<const Double4*>(&w.loads[i].fx);
            turn = (2.5*inverse)**reinterpret_cast<const Double4*>(&w.loads[i].mx);
        }
        const Double4 v = velocity*vectorOnly + second*contact;
        const Double4 total = push + contact;
        const Double4 moved = first*v + (w.step*second)*total;
        const Double4 predicted = decay*v + first*total;
        position += moved;
        velocity = keepLast(predicted - second*contact, velocity);
        Float4& velocityRow = *reinterpret_cast<Float4*>(&row.vx);
        velocityRow = keepLast(__builtin_convertvector(predicted - frame, Float4), velocityRow);

        const Double4 s = surface + (0.5*w.step)*turn;
        surface = s + (0.5*w.step)*turn;
        Float4& surfaceRow = *reinterpret_cast<Float4*>(&row.sx);
        surfaceRow = keepLast(__builtin_convertvector(s + w.step*turn, Float4), surfaceRow);

        sum += predicted;
        const Double4 inFrame = moved - shift;
        const Double4 squared = moved*moved, squaredInFrame = inFrame*inFrame;
        fastest = squared > fastest ? squared : fastest;
        fastestInFrame = squaredInFrame > fastestInFrame ? squaredInFrame : fastestInFrame;
    }
    const double perStep2 = 1/(w.step*w.step);
    w.fastest = (fastest[0] + fastest[1] + fastest[2])*perStep2;
    w.fastestInFrame = (fastestInFrame[0] + fastestInFrame[1] + fastestInFrame[2])*perStep2;
    w.sum[0] = sum[0], w.sum[1] = sum[1], w.sum[2] = sum[2];
}

void move(MoveWork& w)
{
    if (w.loads != nullptr) w.forcing != nullptr ? moveRange<true, true>(w) : moveRange<false, true>(w);
    else w.forcing != nullptr ? moveRange<true, false>(w) : moveRange<false, false>(w);
}

template<class... Laws>
constexpr Kernels kernelsOf(LawList<Laws...>)
{
    return {ELUTRIA_KERNELS_NAME, {pairForces<Laws>...}, move};
}

} // namespace

extern const Kernels ELUTRIA_KERNELS = kernelsOf(ContactLaws());

} // namespace elutria::dem

/* The reference of the benchmark: noisy swimmers near one sphere, as a C programmer would write it.
 *
 * The job is the engine's: forward Euler in the drift of an image dipole (Spagnolie et al., Soft Matter 11, 3396, 2015,
 * Appendix B, in the form without square roots), hard contact of spheres, an exact rotation of the director, and noise
 * from one call of Philox4x32-10 (Salmon et al., SC11), cut into six uniform variates of 21 bits. Swimmers thus follow
 * the paths of the engine, but for rounding. Nothing is recorded, searched or compensated.
 *
 * REAL (float or double) and LANES (swimmers to a block; 1: one swimmer at a time) are set by the compiler's -D.
 */
#include <math.h>
#include <stdint.h>

enum { WATCH = 32 }; /* steps between looks at who has passed */

typedef REAL real;

typedef struct {
    real time_step, radius, dipole_strength, bretherton;
    real kick; /* sqrt(2 D dt) */
    real turn; /* sqrt(2 D_r dt) */
    uint32_t key[2];
} rules;

typedef struct {
    real x, y, z;
} vec;

static inline vec scaled(real s, vec v) { return (vec){s * v.x, s * v.y, s * v.z}; }
static inline vec sum(vec v, vec w) { return (vec){v.x + w.x, v.y + w.y, v.z + w.z}; }
static inline real dot(vec v, vec w) { return v.x * w.x + v.y * w.y + v.z * w.z; }
static inline real root(real s) { return sizeof(real) == 4 ? (real)sqrtf((float)s) : (real)sqrt((double)s); }

typedef struct {
    vec flow, rate;
} motion;

/* Flow and rate of the director at offset x from a sphere of radius A: one division. */
static inline motion drift(vec x, vec e, real A, real alpha, real Gamma) {
    real rho = dot(x, x), s = dot(x, e), H = rho - A * A;
    real i = (real)1 / (rho * H), i_rho = i * H, i_H = i * rho;
    real a = A * A * i_rho, b = a * ((real)3 - a), q = s * s * i_rho;
    real k = (real)1.5 * alpha * A * i_H * i_H;
    real P = (((real)5 * a - (real)17) * a + (real)22) * a - (real)6;
    P += q * ((((real)29 - (real)9 * a) * a - (real)34) * a + (real)18);
    real w = k * rho * i_H * (b + (real)0.25 * Gamma * P);
    return (motion){sum(scaled(k * ((real)3 * q - (real)1 - b * q), x), scaled(k * b * s, e)),
                    sum(scaled(w * q, e), scaled(-w * s * i_rho, x))};
}

typedef struct {
    uint32_t w0, w1, w2, w3;
} block;

static inline block philox(block c, uint32_t k0, uint32_t k1) {
#pragma GCC unroll 10
    for (int round = 0; round < 10; round++) {
        uint64_t p0 = (uint64_t)0xD2511F53u * c.w0, p1 = (uint64_t)0xCD9E8D57u * c.w2;
        c = (block){(uint32_t)(p1 >> 32) ^ c.w1 ^ k0, (uint32_t)p1, (uint32_t)(p0 >> 32) ^ c.w3 ^ k1, (uint32_t)p0};
        k0 += 0x9E3779B9u, k1 += 0xBB67AE85u;
    }
    return c;
}

/* Uniform of mean 0 and variance 1 from 21 bits; by way of a signed integer, which converts in vectors. */
static inline real uniform(uint32_t i) {
    return (real)(((float)(int32_t)i - 1048575.5f) * (float)(3.4641016151377544 / 2097152));
}

typedef struct {
    vec x, e;
} swimmer;

static inline vec turned(vec e, vec spin) {
    vec d = sum(spin, scaled(-dot(spin, e), e)); /* e turns by |d| towards d */
    real q = dot(d, d);
    real sine = 1 - q * ((real)(1. / 6) - q * ((real)(1. / 120) - q * ((real)(1. / 5040) - q * (real)(1. / 362880))));
    real cosine = 1 - q * ((real)0.5 - q * ((real)(1. / 24) - q * ((real)(1. / 720) - q * (real)(1. / 40320))));
    vec n = sum(scaled(cosine, e), scaled(sine, d));
    return scaled((real)1 / root(dot(n, n)), n);
}

/* Inlined by force: two loops call it, and clang by itself would then make calls, which do not vectorise. */
__attribute__((always_inline)) static inline swimmer step(swimmer s, uint32_t id, uint64_t now, const rules *r) {
    motion m = drift(s.x, s.e, r->radius, r->dipole_strength, r->bretherton);
    block c = philox((block){(uint32_t)now, (uint32_t)(now >> 32), id, 0}, r->key[0], r->key[1]);
    vec shift = {uniform(c.w0 >> 11), uniform(c.w1 >> 11), uniform(c.w2 >> 11)};
    vec spin = {uniform(c.w3 >> 11), uniform((c.w0 & 0x7FF) << 10 | (c.w1 & 0x3FF)),
                uniform((c.w2 & 0x7FF) << 10 | (c.w3 & 0x3FF))};
    vec x = sum(s.x, sum(scaled(r->time_step, sum(s.e, m.flow)), scaled(r->kick, shift)));
    real R = root(dot(x, x)), least = r->radius + (real)1, out = least / R;
    vec e = sum(s.e, scaled(r->time_step, m.rate));
    e = scaled((real)1 / root(dot(e, e)), e);
    return (swimmer){scaled(out > 1 ? out : 1, x), turned(e, scaled(r->turn, spin))};
}

/* Move `count` swimmers, of which `begin` is the first, by `n_steps` after step `first`. Rows of `state` are `pitch`
 * apart: x, y, z, then the director. `begin` and `count` are multiples of LANES. */
void advance(real *state, int64_t pitch, int64_t begin, int64_t count, int64_t first, int64_t n_steps, const rules *r) {
    for (int64_t i = begin; i < begin + count; i += LANES) {
        _Alignas(64) real row[6][LANES]; /* whole cache lines: a third of the time otherwise, by chance of the stack */
        for (int k = 0; k < 6; k++)
            for (int j = 0; j < LANES; j++) row[k][j] = state[k * pitch + i + j];
        for (int64_t now = first; now < first + n_steps; now++) {
#if LANES > 1
#pragma omp simd
#endif
            for (int j = 0; j < LANES; j++) {
                swimmer s = {{row[0][j], row[1][j], row[2][j]}, {row[3][j], row[4][j], row[5][j]}};
                s = step(s, (uint32_t)(i + j), (uint64_t)now, r);
                row[0][j] = s.x.x, row[1][j] = s.x.y, row[2][j] = s.x.z;
                row[3][j] = s.e.x, row[4][j] = s.e.y, row[5][j] = s.e.z;
            }
        }
        for (int k = 0; k < 6; k++)
            for (int j = 0; j < LANES; j++) state[k * pitch + i + j] = row[k][j];
    }
}

/* For each of `count` swimmers, from number `begin` on, the first step at whose end the sine of the pitch exceeds `sine`.
 * All begin at `start` (x, y, z, director). A lane whose swimmer has passed takes the next one, at most WATCH steps later;
 * each has the path that it would have alone. */
void passages(const real *start, int64_t begin, int64_t count, real sine, int32_t *passage, const rules *r) {
    _Alignas(64) real row[6][LANES];
    _Alignas(64) int32_t id[LANES], now[LANES], first[LANES];
    int64_t next = 0, owner[LANES], left = count;
    for (int j = 0; j < LANES; j++) first[j] = 1, owner[j] = -1;
    while (left > 0) {
        for (int j = 0; j < LANES; j++) {
            if (first[j] == 0) continue;
            if (owner[j] >= 0) passage[owner[j]] = first[j], left--;
            owner[j] = next < count ? next++ : -1; /* none left: the lane swims on for nobody */
            id[j] = (int32_t)(begin + (owner[j] < 0 ? 0 : owner[j])), now[j] = first[j] = 0;
            for (int k = 0; k < 6; k++) row[k][j] = start[k];
        }
        for (int n = 0; n < WATCH; n++) {
#if LANES > 1
#pragma omp simd
#endif
            for (int j = 0; j < LANES; j++) {
                swimmer s = {{row[0][j], row[1][j], row[2][j]}, {row[3][j], row[4][j], row[5][j]}};
                s = step(s, (uint32_t)id[j], (uint64_t)(uint32_t)now[j], r);
                real rise = dot(s.x, s.e); /* R times the sine of the pitch */
                int passed = (rise > 0) & (rise * rise > sine * sine * dot(s.x, s.x)) & (first[j] == 0);
                row[0][j] = s.x.x, row[1][j] = s.x.y, row[2][j] = s.x.z;
                row[3][j] = s.e.x, row[4][j] = s.e.y, row[5][j] = s.e.z;
                now[j]++, first[j] = passed ? now[j] : first[j];
            }
        }
    }
}

/* The drift at n points (3 numbers each), for the tests. */
void drift_of(const real *x, const real *e, int64_t n, real A, real alpha, real Gamma, real *flow, real *rate) {
    for (int64_t i = 0; i < 3 * n; i += 3) {
        motion m = drift((vec){x[i], x[i + 1], x[i + 2]}, (vec){e[i], e[i + 1], e[i + 2]}, A, alpha, Gamma);
        flow[i] = m.flow.x, flow[i + 1] = m.flow.y, flow[i + 2] = m.flow.z;
        rate[i] = m.rate.x, rate[i + 1] = m.rate.y, rate[i + 2] = m.rate.z;
    }
}

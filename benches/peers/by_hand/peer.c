// What an expert writes by hand for one drive: two mirrored flanks of two stiffness levels each.
//
// Each flank is open or closed on one of its levels, so the drive is one of nine linear systems. Every system has its own
// eigenvectors: tables.py computes them. A motion is one complex amplitude per eigenvector, and time multiplies each by
// e^{λt}. Two amplitudes more hold the excitation: e^{iωt} and 1. With them all is linear: margins, and changes of the
// system, which are one dense product.
//
// A flank's margin is positive while the flank stays as it is. Each block of time gives both margins at eight nodes. A
// change of sign, or a dip of a parabola through three nodes, leads to the polynomial through all nodes. Newton's method
// on the amplitudes polishes its root. Nothing proves that no event is missed; the kernels of atlas do prove it.
//
// src/bin/by_hand.rs calls this, and refuses it where it computes another motion than `volterra`.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef __clang__
#error "compile this with clang: without AVX-512, GCC makes slow code of vectors of eight, and its times would say nothing"
#endif

typedef double v8 __attribute__((vector_size(64)));
typedef long m8 __attribute__((vector_size(64)));

#define INLINE static inline __attribute__((always_inline))

enum {
    NODES = 8,
    FLANKS = 2,
    SEGMENTS = 3, // most stretches of one level in a cycle
    STATES = 3,   // of a flank: open, or closed on one of its levels
    FREE = 0,
    MODAL = 9, // not a system, but the modes: what is a real part elsewhere is a displacement, what is imaginary a velocity
    SYSTEMS = 10,
    MOST = 5, // most vectors of eight real parts
#ifdef __AVX512F__
    SUMS = 20, // vectors of eight that registers hold as sums
#else
    SUMS = 6,
#endif
    LONG = 15,
    SHORT = 5, // terms of the series of e^w for |w| < 0.5 and for |w| < 1e-3
};

// A row over the amplitudes, or a column of them, has all real parts first, padded to V vectors of eight, then all
// imaginary parts. Functions are compiled for every V, and for one column, the motion, or two, motion and tangent.
typedef struct {
    const v8 *rates;                          // λ
    const v8 *turns;                          // e^{λ n step}, n = 0 ... NODES
    const v8 *margin[FLANKS], *slope[FLANKS]; // each flank's margin, and its rate of change, as a row
    const v8 *salt[FLANKS];                   // what a tangent gains at an event per unit of its own margin
    const v8 *nodes; // margins at the nodes: four vectors per amplitude, of its real part for both flanks, of its imaginary one
} System;

typedef struct {
    double vectors, slots, period, step, push; // push: acceleration of the rigid mode in free flight
    double end[FLANKS][SEGMENTS], level[FLANKS][SEGMENTS];
    double padding[7];
} Header;

typedef struct {
    v8 z[2][2 * MOST];    // amplitudes of the motion and of its tangent
    double time, limit;   // within the cycle; when a closed flank changes its level next, or the cycle ends
    double start[FLANKS]; // margins now
    int system, crossed;  // crossed: the flank that has just opened or closed, or -1
    int vectors, slots;
    Header head;
    System systems[MODAL];
    const v8 *changes;
    v8 *tables;
} Drive;

INLINE double sum(v8 x) {
    typedef double v4 __attribute__((vector_size(32)));
    typedef double v2 __attribute__((vector_size(16)));
    v4 y = __builtin_shufflevector(x, x, 0, 1, 2, 3) + __builtin_shufflevector(x, x, 4, 5, 6, 7);
    v2 z = __builtin_shufflevector(y, y, 0, 1) + __builtin_shufflevector(y, y, 2, 3);
    return z[0] + z[1];
}

INLINE double dot(const v8 *row, const v8 *z, const int V) {
    v8 re = {0}, im = {0};
    for (int i = 0; i < V; i++) {
        re += row[i] * z[i];
        im += row[V + i] * z[V + i];
    }
    return sum(re + im);
}

// 1/n!
static const double FACTOR[LONG] = {
    1,          1,          1. / 2,      1. / 6,        1. / 24,        1. / 120,        1. / 720,         1. / 5040,
    1. / 40320, 1. / 362880, 1. / 3628800, 1. / 39916800, 1. / 479001600, 1. / 6227020800, 1. / 87178291200,
};

// e^{λt} by its series. A polynomial p with real coefficients at a complex w takes two real products a term: divided by
// x² - 2 Re(w) x + |w|² it leaves a line, which has the value p(w) at w (Knuth, TAOCP 4.6.4).
INLINE void exponential(const v8 *rates, double t, const int terms, v8 *e, const int V) {
    for (int k = 0; k < V; k++) {
        v8 re = rates[k] * t, im = rates[V + k] * t, twice = re + re, square = re * re + im * im;
        v8 a = (v8){0} + FACTOR[terms - 1], b = (v8){0} + FACTOR[terms - 2];
#pragma unroll
        for (int n = terms - 3; n >= 0; n--) {
            v8 before = a;
            a = b + twice * a;
            b = FACTOR[n] - square * before;
        }
        e[k] = a * re + b;
        e[V + k] = a * im;
    }
}

INLINE void multiply(v8 *z, const v8 *e, const int V) {
    for (int k = 0; k < V; k++) {
        v8 re = z[k], im = z[V + k];
        z[k] = re * e[k] - im * e[V + k];
        z[V + k] = re * e[V + k] + im * e[k];
    }
}

// Moves motion and tangent by a time t with e = e^{λt}. In free flight the rigid mode, whose displacement and velocity are
// the first amplitude, is pushed; the tangent, whose last amplitude is 0 and not 1, is not.
INLINE void move(Drive *d, const v8 *e, double t, const int V, const int columns) {
    for (int c = 0; c < columns; c++) {
        double *re = (double *)d->z[c], *im = re + 8 * V, velocity = im[0], push = d->head.push * re[d->slots - 1];
        multiply(d->z[c], e, V);
        if (d->system == FREE) {
            re[0] += t * (velocity + 0.5 * push * t);
            im[0] += t * push;
        }
    }
    d->time += t;
}

// Moves by a number of nodes that need not be whole.
INLINE void move_by(Drive *d, double nodes, const int V, const int columns) {
    const System *s = &d->systems[d->system];
    int whole = (int)(nodes + 0.5);
    v8 e[2 * MOST];
    exponential(s->rates, (nodes - whole) * d->head.step, LONG, e, V);
    multiply(e, s->turns + 2 * V * whole, V);
    move(d, e, nodes * d->head.step, V, columns);
}

// Changes the system: one dense product, of motion and tangent at once, as many rows at a time as registers hold sums.
INLINE void change(Drive *d, int to, const int V, const int columns) {
    const v8 *table = d->changes + (size_t)(d->system * SYSTEMS + to) * (2 * d->slots - 1) * 2 * V;
    const int most = SUMS / columns;
    v8 out[2][2 * MOST];
#pragma unroll
    for (int first = 0; first < 2 * V; first += most) {
        const v8 *column = table + first;
        v8 sums[2][SUMS] = {0};
        for (int part = 0; part < 2; part++) {
            // The last amplitude is 1: it has no imaginary part.
            for (int k = 0; k < d->slots - part; k++, column += 2 * V) {
                for (int c = 0; c < columns; c++) {
                    double z = ((double *)d->z[c])[8 * V * part + k];
#pragma unroll
                    for (int i = 0; i < most && first + i < 2 * V; i++) sums[c][i] += column[i] * z;
                }
            }
        }
        for (int c = 0; c < columns; c++)
#pragma unroll
            for (int i = 0; i < most && first + i < 2 * V; i++) out[c][first + i] = sums[c][i];
    }
    for (int c = 0; c < columns; c++)
        for (int i = 0; i < 2 * V; i++) d->z[c][i] = out[c][i];
    d->system = to;
}

// State of a flank in a system: open, or closed on a level; and the system with another state.
static const int PLACE[FLANKS] = {3, 1};
INLINE int state(int system, int flank) { return system / PLACE[flank] % STATES; }
INLINE int with(int system, int flank, int to) { return system + PLACE[flank] * (to - state(system, flank)); }

INLINE int segment(const Drive *d, int flank) {
    int place = 0;
    while (place < SEGMENTS - 1 && d->head.end[flank][place] <= d->time) place++;
    return place;
}

INLINE void plan(Drive *d) {
    d->limit = d->head.period;
    for (int f = 0; f < FLANKS; f++)
        if (state(d->system, f)) d->limit = fmin(d->limit, d->head.end[f][segment(d, f)]);
}

// All numbers a place later, the first of another vector before them.
INLINE v8 behind(v8 first, v8 x) { return __builtin_shufflevector(first, x, 0, 8, 9, 10, 11, 12, 13, 14); }

// Nodes at which a margin is negative, or low between higher neighbours: before these it may pass zero. Behind the last
// node the parabola through three goes on.
INLINE m8 suspects(double start, v8 g) {
    v8 first = (v8){0} + start;
    v8 left = behind(first, g), farther = behind(first, left);
    v8 next = 3 * (g - left) + farther;
    v8 right = __builtin_shufflevector(g, next, 1, 2, 3, 4, 5, 6, 7, 15);
    return (g < 0) | ((g < 0.2 * (left - 2 * g + right)) & (g < left) & (g < right));
}

INLINE int any(m8 x) {
    x |= __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3);
    x |= __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5);
    return (x[0] | x[1]) != 0;
}

// Value and slope of a polynomial through the nodes in Newton's form; without its factor x where `first` is 1.
INLINE double polynomial(const double *d, int first, double x, double *slope) {
    double value = *slope = 0;
#pragma unroll
    for (int i = NODES; i >= first; i--) {
        *slope = *slope * (x - i) + value;
        value = value * (x - i) + d[i];
    }
    return value;
}

// The first root of the polynomial through a margin at the nodes 0, 1 ... NODES, in distances of nodes. The root at the
// start, where the flank has just `crossed`, is none.
static double first_root(double start, v8 margin, int crossed) {
    double g[NODES + 1] = {start}, d[NODES + 1] = {start}, slope;
    memcpy(g + 1, &margin, sizeof margin);
    v8 differences = margin - behind((v8){0} + start, margin);
#pragma unroll
    for (int order = 1; order <= NODES; order++) {
        d[order] = FACTOR[order] * differences[0];
        differences = __builtin_shufflevector(differences, differences, 1, 2, 3, 4, 5, 6, 7, 7) - differences;
    }
    for (int n = 0; n < NODES; n++) {
        int first = crossed && n == 0;
        double low = n, high = n + 1;
        if (g[n + 1] >= 0) {
            double bend = n + 2 > NODES ? 0 : g[n] - 2 * g[n + 1] + g[n + 2];
            if (!(g[n + 1] < 0.2 * bend && g[n + 1] < g[n] && g[n + 1] < g[n + 2])) continue;
            high += (g[n] - g[n + 2]) / (2 * bend);
            if (polynomial(d, first, high, &slope) >= 0) continue;
        }
        double x = low + (high - low) * g[n] / (g[n] - g[n + 1]);
        for (int i = 0; i < 60; i++) {
            if (!(x > low && x < high)) x = 0.5 * (low + high);
            double value = polynomial(d, first, x, &slope), by = -value / slope;
            *(value > 0 ? &low : &high) = x;
            x += by;
            if (fabs(by) < 1e-3) break; // leaves an error of its square
        }
        return x;
    }
    return INFINITY;
}

// The flank's margin is zero near here: goes there exactly, lets the flank open or close.
INLINE void meet(Drive *d, int flank, const int V, const int columns) {
    const System *s = &d->systems[d->system];
    double step = d->head.step, by;
    v8 e[2 * MOST];
    for (int i = 0; i < 5; i++) {
        by = -dot(s->margin[flank], d->z[0], V) / dot(s->slope[flank], d->z[0], V);
        if (!(fabs(by) < 0.4 * step)) break; // a touch without slope: it is as near as it gets
        if (fabs(by) < 1e-3 * step)
            exponential(s->rates, by, SHORT, e, V);
        else
            exponential(s->rates, by, LONG, e, V);
        move(d, e, by, V, columns);
        if (fabs(by) < 1e-5 * step) break;
    }
    if (columns > 1) {
        double off = dot(s->margin[flank], d->z[1], V);
        for (int i = 0; i < 2 * V; i++) d->z[1][i] += s->salt[flank][i] * off;
    }
    d->start[!flank] = dot(s->margin[!flank], d->z[0], V);
    d->start[flank] = 0;
    d->crossed = flank;
    int opens = state(d->system, flank) > 0;
    change(d, with(d->system, flank, opens ? 0 : (int)d->head.level[flank][segment(d, flank)]), V, columns);
    plan(d);
}

// A closed flank changes its level here, or the cycle ends. Says whether it does.
INLINE int stop(Drive *d, const int V, const int columns) {
    int ends = d->limit >= d->head.period, to = d->system;
    d->time = ends ? 0 : d->limit;
    if (ends) { // cos 0 and sin 0, so that no rounding adds up
        double *driven = (double *)d->z[0] + d->slots - 2;
        driven[0] = 1;
        driven[8 * V] = 0;
    }
    for (int f = 0; f < FLANKS; f++) {
        d->start[f] = dot(d->systems[d->system].margin[f], d->z[0], V);
        if (state(to, f)) to = with(to, f, (int)d->head.level[f][segment(d, f)]);
    }
    d->crossed = -1;
    if (to != d->system) change(d, to, V, columns);
    plan(d);
    return ends;
}

// Both margins at all nodes.
INLINE void look(const Drive *d, v8 g[FLANKS], const int V) {
    const v8 *table = d->systems[d->system].nodes;
    const double *re = (const double *)d->z[0], *im = re + 8 * V;
    v8 a[4] = {0};
    for (int k = 0; k < d->slots; k++, table += 4) {
        a[0] += table[0] * re[k];
        a[1] += table[1] * re[k];
        a[2] += table[2] * im[k];
        a[3] += table[3] * im[k];
    }
    g[0] = a[0] + a[2];
    g[1] = a[1] + a[3];
}

INLINE void run(Drive *d, long cycles, const int V, const int columns) {
    double step = d->head.step;
    while (cycles > 0) {
        double left = (d->limit - d->time) / step, event = INFINITY;
        int flank = 0;
        v8 g[FLANKS];
        look(d, g, V);
        m8 live = (v8){0, 1, 2, 3, 4, 5, 6, 7} < left; // of the nodes behind the limit only the first counts
        m8 found[FLANKS] = {suspects(d->start[0], g[0]) & live, suspects(d->start[1], g[1]) & live};
        m8 both = found[0] | found[1];
        if (any(both)) {
            for (int f = 0; f < FLANKS; f++) {
                double root = any(found[f]) ? first_root(d->start[f], g[f], d->crossed == f) : INFINITY;
                if (root < event) event = root, flank = f;
            }
        }
        if (event <= left && event <= NODES) {
            move_by(d, event, V, columns);
            meet(d, flank, V, columns);
        } else if (left <= NODES) {
            move_by(d, left, V, columns);
            cycles -= stop(d, V, columns);
        } else { // a dip at the last node is looked at again from the middle
            int whole = both[NODES - 1] ? NODES / 2 : NODES;
            move(d, d->systems[d->system].turns + 2 * V * whole, whole * step, V, columns);
            for (int f = 0; f < FLANKS; f++) d->start[f] = g[f][whole - 1];
            d->crossed = -1;
        }
    }
}

// Reads what tables.py wrote; NULL where that fails.
Drive *by_hand_load(const char *path) {
    FILE *file = fopen(path, "rb");
    Drive *d = aligned_alloc(64, (sizeof *d + 63) / 64 * 64);
    if (!file || !d || fread(&d->head, sizeof d->head, 1, file) != 1) return NULL;
    int V = d->vectors = (int)d->head.vectors, slots = d->slots = (int)d->head.slots;
    size_t system = 32 * V + 4 * slots, changes = (size_t)SYSTEMS * SYSTEMS * (2 * slots - 1) * 2 * V;
    size_t count = MODAL * system + changes;
    d->tables = aligned_alloc(64, count * sizeof(v8));
    if (V > MOST || !d->tables || fread(d->tables, sizeof(v8), count, file) != count) return NULL;
    fclose(file);
    for (int n = 0; n < MODAL; n++) {
        const v8 *t = d->tables + n * system;
        System *s = &d->systems[n];
        s->rates = t, s->turns = t + 2 * V;
        for (int f = 0; f < FLANKS; f++) {
            s->margin[f] = t + 2 * V * (10 + f);
            s->slope[f] = t + 2 * V * (12 + f);
            s->salt[f] = t + 2 * V * (14 + f);
        }
        s->nodes = t + 2 * V * 16;
    }
    d->changes = d->tables + MODAL * system;
    return d;
}

void by_hand_free(Drive *d) {
    free(d->tables);
    free(d);
}

// Motion and tangent at the start of a cycle, as displacements, then velocities, of the modes; which flanks are closed.
void by_hand_set(Drive *d, const double *motion, const double *tangent, const int *closed) {
    int V = d->vectors, modes = d->slots - 2, to = FREE;
    memset(d->z, 0, sizeof d->z);
    for (int c = 0; c < 2; c++) {
        double *re = (double *)d->z[c];
        memcpy(re, c ? tangent : motion, modes * sizeof(double));
        memcpy(re + 8 * V, (c ? tangent : motion) + modes, modes * sizeof(double));
        re[modes] = re[modes + 1] = !c; // e^{iωt} and 1
    }
    d->time = 0, d->crossed = -1, d->system = MODAL;
    for (int f = 0; f < FLANKS; f++)
        if (closed[f]) to = with(to, f, (int)d->head.level[f][0]);
    change(d, to, V, 2);
    plan(d);
    for (int f = 0; f < FLANKS; f++) d->start[f] = dot(d->systems[to].margin[f], d->z[0], V);
}

// Motion or tangent as by_hand_set takes them.
void by_hand_get(const Drive *d, int column, double *out) {
    Drive copy = *d;
    int modes = d->slots - 2;
    change(&copy, MODAL, d->vectors, 2);
    memcpy(out, copy.z[column], modes * sizeof(double));
    memcpy(out + modes, (double *)copy.z[column] + 8 * d->vectors, modes * sizeof(double));
}

#define CASE(V) case V: if (tangent) run(d, cycles, V, 2); else run(d, cycles, V, 1); break;

// Advances by whole cycles, without or with the tangent.
void by_hand_run(Drive *d, long cycles, int tangent) {
    switch (d->vectors) { CASE(1) CASE(2) CASE(3) CASE(4) CASE(5) }
}

// What an expert writes by hand for a plane of one oscillator against a one-sided stop.
//
//     x'' + c x' + (k + s [x > g]) x = F cos ωt + s g [x > g]
//
// Free or in contact the motion is a damped oscillation about a steady one. Time goes on in steps in which neither turns
// by more than half a radian; each step is one rotation of the oscillation and one of the drive. If the sign of x − g
// changes between two steps, or if x turns back beyond the stop, Newton's method finds the root. Nothing proves that no
// event is missed. A tangent gives the largest exponent. A point ends when its motion repeats after 1 to 16 cycles, or
// after all cycles.
//
// Usage: one_mode GAPS GAP_FROM GAP_TO STIFFNESSES FROM TO OMEGA C K F TRANSIENT CYCLES; prints a point per line:
// period (0: none), largest exponent per cycle, cycles, events.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LONGEST = 16 };

typedef struct {
    double mu, nu;            // e^{-mu t} cos/sin nu t
    double re, im, rest;      // steady motion re cos + im sin + rest
    double h, e, c, s, dc, ds; // a step: decay, turn of the oscillation, turn of the drive
} Phase;

static double omega;

static Phase phase(double damping, double stiffness, double force, double push) {
    Phase p;
    p.mu = 0.5 * damping;
    p.nu = sqrt(stiffness - p.mu * p.mu);
    double a = stiffness - omega * omega, b = damping * omega, d = a * a + b * b;
    p.re = force * a / d, p.im = force * b / d, p.rest = push / stiffness;
    double fastest = p.nu > omega ? p.nu : omega;
    p.h = 0.5 / fastest;
    p.e = exp(-p.mu * p.h);
    p.c = p.e * cos(p.nu * p.h), p.s = p.e * sin(p.nu * p.h);
    p.dc = cos(omega * p.h), p.ds = sin(omega * p.h);
    return p;
}

// An oscillation u = a, u' = -mu a + nu b, and the drive (cos, sin).
typedef struct {
    double a, b, c, s;
} State;

static inline State turned(State z, double c, double s, double dc, double ds) {
    return (State){c * z.a + s * z.b, c * z.b - s * z.a, dc * z.c - ds * z.s, dc * z.s + ds * z.c};
}

static inline State later(const Phase *p, State z, double t) {
    double e = exp(-p->mu * t);
    return turned(z, e * cos(p->nu * t), e * sin(p->nu * t), cos(omega * t), sin(omega * t));
}

static inline double place(const Phase *p, State z) { return z.a + p->re * z.c + p->im * z.s + p->rest; }

static inline double speed(const Phase *p, State z) {
    return p->nu * z.b - p->mu * z.a + omega * (p->im * z.c - p->re * z.s);
}

static inline double bend(const Phase *p, State z) {
    double v = p->nu * z.b - p->mu * z.a;
    return -2 * p->mu * v - (p->nu * p->nu + p->mu * p->mu) * z.a - omega * omega * (p->re * z.c + p->im * z.s);
}

static inline State of(const Phase *p, double x, double v, double c, double s) {
    double a = x - p->re * c - p->im * s - p->rest;
    double rate = v - omega * (p->im * c - p->re * s);
    return (State){a, (rate + p->mu * a) / p->nu, c, s};
}

int main(int count, char **given) {
    if (count != 13) return 2;
    double number[13];
    for (int i = 1; i < 13; i++) number[i] = atof(given[i]);
    int gaps = number[1], stiffnesses = number[4], transient = number[11], cycles = number[12];
    omega = number[7];
    double damping = number[8], stiffness = number[9], force = number[10];
    double period = 2 * M_PI / omega;
    for (int i = 0; i < gaps; i++)
        for (int j = 0; j < stiffnesses; j++) {
            double gap = number[2] + (number[3] - number[2]) * i / (gaps - 1);
            double stop = number[5] * pow(number[6] / number[5], (double)j / (stiffnesses - 1));
            Phase both[2] = {phase(damping, stiffness, force, 0), phase(damping, stiffness + stop, force, stop * gap)};
            int closed = gap < 0;
            double x = closed ? stop * gap / (stiffness + stop) : 0, v = 0, growth = 0;
            double u = 1, w = 0, last[LONGEST][2];
            int events = 0, found = 0, cycle = 0, measured = 0;
            for (; cycle < transient + cycles && !found; cycle++) {
                double left = period;
                const Phase *p = &both[closed];
                State z = of(p, x, v, 1, 0);
                double ta = u, tb = (w + p->mu * u) / p->nu;
                double here = x - gap;
                while (left > 0) {
                    int whole = left > p->h;
                    State next = whole ? turned(z, p->c, p->s, p->dc, p->ds) : later(p, z, left);
                    double there = place(p, next) - gap, t = whole ? p->h : left;
                    int crosses = closed ? there < 0 : there > 0;
                    double at = -1;
                    if (crosses) {
                        at = here == there ? 0 : t * here / (here - there);
                        if (!(at > 0) || here == 0) at = 0.5 * t;
                    } else {
                        // A turn near the stop: does the motion cross it and come back?
                        double a = speed(p, z), b = speed(p, next), side = closed ? -1 : 1;
                        if (side * a > 0 && side * b < 0 && fabs(there) < fabs(a) * t && here != 0) {
                            double top = t * a / (a - b);
                            for (int k = 0; k < 4; k++) {
                                State there = later(p, z, top);
                                top -= speed(p, there) / bend(p, there);
                            }
                            State highest = later(p, z, top);
                            if (top > 0 && top < t && side * (place(p, highest) - gap) > 0) at = top, t = top;
                        }
                    }
                    if (at < 0) {
                        if (whole) {
                            double a = ta;
                            ta = p->c * ta + p->s * tb, tb = p->c * tb - p->s * a;
                        } else {
                            double e = exp(-p->mu * t), c = e * cos(p->nu * t), s = e * sin(p->nu * t), a = ta;
                            ta = c * ta + s * tb, tb = c * tb - s * a;
                        }
                        z = next, here = there, left -= t;
                        continue;
                    }
                    // Newton's method within a bracket. Behind an event the root at the start does not count.
                    double low = here == 0 ? 1e-9 * t : 0, high = crosses ? t : at;
                    State event;
                    for (int k = 0; k < 60; k++) {
                        event = later(p, z, at);
                        double margin = (closed ? 1 : -1) * (place(p, event) - gap);
                        if (margin > 0) low = at; else high = at;
                        double next = at - (place(p, event) - gap) / speed(p, event);
                        if (!(next > low && next < high)) next = 0.5 * (low + high);
                        double step = fabs(next - at);
                        at = next;
                        if (step < 1e-14) break;
                    }
                    event = later(p, z, at);
                    double e = exp(-p->mu * at), c = e * cos(p->nu * at), s = e * sin(p->nu * at), a = ta;
                    ta = c * ta + s * tb, tb = c * tb - s * a;
                    double rate = speed(p, event), tangent = p->nu * tb - p->mu * ta;
                    left -= at;
                    closed = !closed, events++;
                    p = &both[closed];
                    z = of(p, gap, rate, event.c, event.s);
                    tb = (tangent + p->mu * ta) / p->nu;
                    here = 0;
                }
                x = place(p, z), v = speed(p, z);
                u = ta, w = p->nu * tb - p->mu * ta;
                if (cycle >= transient / 5) {
                    double size = sqrt(u * u + w * w);
                    u /= size, w /= size;
                    growth += log(size), measured++;
                    // A return settles a point. A spiral may return closest after several periods.
                    for (int q = LONGEST; q > 0 && cycle >= transient / 5 + LONGEST; q--) {
                        const double *old = last[(cycle + LONGEST - q) % LONGEST];
                        double away = hypot(x - old[0], v - old[1]);
                        if (away < 1e-12 || (found % q == 0 && found && away < 1e-10)) found = q;
                    }
                }
                last[cycle % LONGEST][0] = x, last[cycle % LONGEST][1] = v;
            }
            printf("%d %.6f %d %d\n", found, measured ? growth / measured : 0.0, cycle, events);
        }
    return 0;
}

/* Barrier (10)-(20) of one axis, region by region, as sums of non-negative terms: nothing cancels
 * and nothing is divided by A. */
#ifndef WMR_HAND_BARRIER_H
#define WMR_HAND_BARRIER_H

#include "hand.h"

#include <math.h>

typedef struct {
    double w, va, q; /* v - v_c1, V1/A, (v - v_c1)/A */
} barrier;

/* (-ln(1 - y) - y) / y^2 for small y */
static inline double psi_series(double y)
{
    return 1.0 / 2 + y * (1.0 / 3 + y * (1.0 / 4 + y * (1.0 / 5 + y * (1.0 / 6
         + y * (1.0 / 7 + y * (1.0 / 8 + y * (1.0 / 9 + y * (1.0 / 10))))))));
}

/* -ln(1 - y) - y without cancellation */
static inline double phi(double y)
{
    return fabs(y) < 0.015625 ? y * y * psi_series(y) : -log1p(-y) - y;
}

/* f (15) for |v| > u2 */
static inline double wall(const hand_axis *a, double speed)
{
    return -log1p((a->u2 - speed) * a->inv_delta);
}

/* Region 1, |v_c0| <= u2: the target is v_c0 itself. */
static inline barrier region1(const hand_axis *a, double v, double c)
{
    const double w = v - c, speed = fabs(v);
    if (speed <= a->u2)
        return (barrier){w, 0.5 * w, 1.0};
    const double gap = a->u1 - speed;
    const double inv = gap / (w * gap + (v > 0.0 ? 1.0 : -1.0));
    return (barrier){w, (0.5 * w * w + wall(a, speed)) * inv, w * inv};
}

/* The target is ahead: A = -(n + pull + wall's slope), V = level plus the wall, c > u2, v <= u2. */
static inline barrier below(const hand_axis *a, double v, double n, double pull, double level)
{
    double slope = n + pull;
    if (v < -a->u2) {
        slope += 1.0 / (a->u1 + v);
        level += wall(a, -v);
    }
    const double inv = 1.0 / slope;
    return (barrier){-n, -level * inv, n * inv};
}

/* Region 2, the dead zone: the target stays at u2. */
static inline barrier region2(const hand_axis *a, double v, double c)
{
    if (v <= a->u2) {
        const double n = a->u2 - v, pull = c - a->u2;
        return below(a, v, n, pull, n * (0.5 * n + pull));
    }
    const double w = v - a->u2, b = a->edge - c, dg = a->delta * (a->u1 - v);
    const double inv = dg / ((b + w) * dg + w);
    return (barrier){w, (w * (0.5 * w + b) + phi(w * a->inv_delta)) * inv, w * inv};
}

/* Region 3: the target is u1 - d with d from (18). */
static inline barrier region3(const hand_axis *a, double v, double c)
{
    const double t = c - a->u1, inv_d = 0.5 * (t + sqrt(t * t + 4.0)), d = 1.0 / inv_d;
    if (v <= a->u2) {
        const double p = a->delta - d, to_u2 = a->u2 - v, n = p + to_u2;
        return below(a, v, n, inv_d, 0.5 * n * n + to_u2 * inv_d + phi(-p * inv_d));
    }
    const double gap = a->u1 - v, w = d - gap, y = w * inv_d, dg = d * gap;
    const double q = dg / (dg + 1.0);
    const double rest = fabs(y) < 0.015625 ? w * psi_series(y) * inv_d * inv_d
                                           : (-log1p(-y) - y) / w;
    return (barrier){w, (0.5 * w + rest) * q, q};
}

static inline barrier barrier_of(const hand_axis *a, double v, double c)
{
    v = v > a->top ? a->top : v < -a->top ? -a->top : v;
    const double size = fabs(c);
    if (size <= a->u2)
        return region1(a, v, c);
    if (c < 0.0)
        v = -v;
    barrier b = size <= a->edge ? region2(a, v, size) : region3(a, v, size);
    if (c < 0.0) {
        b.w = -b.w;
        b.va = -b.va;
    }
    return b;
}

#endif

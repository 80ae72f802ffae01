/* Two control laws: reference, measured pose and velocity in, wheel torques out. */
#ifndef WMR_HAND_LAWS_H
#define WMR_HAND_LAWS_H

#include "barrier.h"
#include "network.h"

/* v_c0 (7) of the tracking error (8), and its exact rate by (33)-(35). */
static inline void auxiliary(const hand_law *p, const double *ref, const double *pose,
                             const double *v, double c[2], double c_dot[2])
{
    const double s = sin(pose[2]), co = cos(pose[2]);
    const double dx = ref[0] - pose[0], dy = ref[1] - pose[1], e3 = ref[2] - pose[2];
    const double e1 = co * dy - s * dx, e2 = -co * dx - s * dy;
    const double s3 = sin(e3), c3 = cos(e3);
    const double ahead = ref[3] * c3, aside = ref[3] * s3, gain2 = p->k[1] * ref[3];

    const double e1_dot = e2 * v[1] - v[0] + ahead;
    const double e2_dot = aside - e1 * v[1];
    const double e3_dot = ref[4] - v[1];

    c[0] = ahead + p->k[0] * e1;
    c[1] = ref[4] + gain2 * e2 + p->k[2] * s3;
    c_dot[0] = ref[5] * c3 - aside * e3_dot + p->k[0] * e1_dot;
    c_dot[1] = ref[6] + p->k[1] * ref[5] * e2 + gain2 * e2_dot + p->k[2] * c3 * e3_dot;
}

static inline void wheels(const hand_law *p, double force, double moment, double torque[2])
{
    const double mean = p->wheel_force * force, half = p->wheel_moment * moment;
    torque[0] = mean + half;
    torque[1] = mean - half;
}

/* Model-based law (9). */
static inline void mb_step(const hand_law *restrict p, const double *restrict ref,
                           const double *restrict pose, const double *restrict v,
                           double *restrict torque)
{
    double c[2], c_dot[2];
    auxiliary(p, ref, pose, v, c, c_dot);
    const barrier b1 = barrier_of(&p->axis[0], v[0], c[0]);
    const barrier b2 = barrier_of(&p->axis[1], v[1], c[1]);
    const double force = p->mass[0] * (b1.q * c_dot[0] - p->mb_rho[0] * b1.va)
                       + p->coulomb * tanh(v[0] * p->inv_v_s);
    const double moment = p->mass[1] * (b2.q * c_dot[1] - p->mb_rho[1] * b2.va);
    wheels(p, force, moment, torque);
}

static inline double capped_ratio(const hand_law *p, double q)
{
    return q > p->nn_inv_cap ? 1.0 / q : p->nn_ratio_cap;
}

/* Adaptive network law (57), (58). */
static inline void nn_step(const hand_law *restrict p, const double *restrict ref,
                           const double *restrict pose, const double *restrict v,
                           double *restrict W, double *restrict torque)
{
    double c[2], c_dot[2], learned[2];
    auxiliary(p, ref, pose, v, c, c_dot);
    const barrier b1 = barrier_of(&p->axis[0], v[0], c[0]);
    const barrier b2 = barrier_of(&p->axis[1], v[1], c[1]);
    const double z[6] = {c_dot[0], c_dot[1], capped_ratio(p, b1.q), capped_ratio(p, b2.q),
                         v[0], v[1]};
    const double w[2] = {b1.w, b2.w};
    network(p, z, w, W, learned);
    wheels(p, b1.q * learned[0] - p->nn_rho1[0] * b1.va,
           b2.q * learned[1] - p->nn_rho1[1] * b2.va, torque);
}

#endif

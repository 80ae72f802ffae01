/* The network W'S(Z) and its weights' step (58): 12 exponentials, then a tensor product. */
#ifndef WMR_HAND_NETWORK_H
#define WMR_HAND_NETWORK_H

#include "hand.h"

#include <math.h>

/* The 8 products of one factor of each of three inputs, first input slowest. */
static inline void corners(const double f[3][2], double out[8])
{
    const double m0 = f[1][0] * f[2][0], m1 = f[1][0] * f[2][1];
    const double m2 = f[1][1] * f[2][0], m3 = f[1][1] * f[2][1];
    out[0] = f[0][0] * m0;
    out[1] = f[0][0] * m1;
    out[2] = f[0][0] * m2;
    out[3] = f[0][0] * m3;
    out[4] = f[0][1] * m0;
    out[5] = f[0][1] * m1;
    out[6] = f[0][1] * m2;
    out[7] = f[0][1] * m3;
}

/* W'S with the old weights and W := keep W + learn S with S = outer(left, right), in one pass.
 * Two columns at a time: two partial sums fill a vector register without reordering an addition. */
static inline double recall_and_learn(const double *restrict left, const double *restrict right,
                                      double keep, double learn, double *restrict W)
{
    double even = 0.0, odd = 0.0;
    for (int j = 0; j < 8; j += 2) {
        const double r0 = right[j], r1 = right[j + 1], step0 = learn * r0, step1 = learn * r1;
        double sum0 = 0.0, sum1 = 0.0;
        for (int i = 0; i < 8; i++) {
            double *pair = W + 8 * i + j;
            const double w0 = pair[0], w1 = pair[1];
            sum0 += left[i] * w0;
            sum1 += left[i] * w1;
            pair[0] = keep * w0 + step0 * left[i];
            pair[1] = keep * w1 + step1 * left[i];
        }
        even += sum0 * r0;
        odd += sum1 * r1;
    }
    return even + odd;
}

static inline int out_of_reach(double far, const double z[6])
{
    for (int d = 0; d < 6; d++)
        if (fabs(z[d]) > far)
            return 1;
    return 0;
}

static inline void network(const hand_law *p, const double z[6], const double w[2], double *W,
                           double out[2])
{
    double factor[6][2], left[8], right[8];
    if (out_of_reach(p->nn_far, z)) {
        for (int j = 0; j < HAND_NODES; j++) {
            W[j] *= p->nn_keep[0];
            W[HAND_NODES + j] *= p->nn_keep[1];
        }
        out[0] = out[1] = 0.0;
        return;
    }
    for (int d = 0; d < 6; d++) {
        const double up = z[d] + 1.0, down = z[d] - 1.0;
        factor[d][0] = exp(-up * up * p->nn_inv_eta2);
        factor[d][1] = exp(-down * down * p->nn_inv_eta2);
    }
    corners((const double (*)[2])factor, left);
    corners((const double (*)[2])(factor + 3), right);
    for (int i = 0; i < 2; i++)
        out[i] = recall_and_learn(left, right, p->nn_keep[i], p->nn_learn[i] * w[i],
                                  W + HAND_NODES * i);
}

#endif

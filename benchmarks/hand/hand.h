/* Hand-written controllers, plant and closed loop: the floor for what is generated.
 *
 * Plain C99 and libm, doubles, SI units, no allocation, no globals. Numbers in brackets are the
 * equations of the paper. Vectors are ordered as everywhere in the project:
 *   reference [7]  x_d, y_d, theta_d, v1_d, v2_d, v1_d_dot, v2_d_dot
 *   pose      [3]  x, y, theta (0 along +Y, forward = (-sin theta, cos theta))
 *   velocity  [2]  v1, omega
 *   torque    [2]  right wheel, left wheel
 *   row      [12]  reference, pose, velocity
 *   state     [5]  pose, velocity
 */
#ifndef WMR_HAND_H
#define WMR_HAND_H

#include <stdint.h>

enum { HAND_MB, HAND_NN };

enum {
    HAND_ROW = 12,         /* inputs of one control step */
    HAND_NODES = 64,       /* corners of [-1, 1]^6 */
    HAND_LAW_STATE = 128   /* room for the largest state of a law: nn, W[2][64] */
};

/* What a person types in: the robot as the law believes it, limits, gains, control period. */
typedef struct {
    double m, inertia, mu, r, l, g, v_s;    /* kg, kg m2, 1, m, m, m/s2, m/s */
    double k[3], v_u1[2], v_u2[2], clip;    /* (7); limits in m/s, rad/s */
    double mb_rho[2];                       /* (9) */
    double nn_rho1[2], nn_gamma[2], nn_sigma[2], nn_eta, nn_ratio_cap; /* (57), (58) */
    double period;                          /* s */
} hand_setup;

/* One axis of the barrier: limits, their gap, and |v_c0| at which region 3 begins. */
typedef struct {
    double u1, u2, top, delta, inv_delta, edge;
} hand_axis;

/* The same after hand_prepare: everything that need not be computed at each step. */
typedef struct {
    hand_axis axis[2];
    double k[3], mass[2], coulomb, inv_v_s, wheel_force, wheel_moment;
    double mb_rho[2];
    double nn_rho1[2], nn_keep[2], nn_learn[2], nn_inv_eta2, nn_far, nn_ratio_cap, nn_inv_cap;
} hand_law;

/* One closed loop on the circle x_d = R sin(w t), y_d = R - R cos(w t). */
typedef struct {
    double initial[5];
    double radius, rate;                    /* m, rad/s */
    double control, plant;                  /* s; control = substeps * plant */
    int64_t samples, substeps;
    double noise_std;                       /* N m, per wheel */
    double t_change, m, inertia, mu;        /* s; the robot's parameters from then on */
    double m_first, inertia_first, mu_first; /* and until then */
    uint64_t key[2];                        /* of the noise */
} hand_case;

typedef struct {
    double state[5];                        /* at the end */
    double max_abs_v[2];                    /* over t = 0 and every plant step */
    int64_t violations, steps;              /* steps beyond a limit; plant steps made */
} hand_result;

/* The plant's constants for one plant step of h seconds. */
typedef struct {
    double h, inv_m, inv_inertia, mu_g, inv_v_s, inv_r, arm;
} hand_plant;

void hand_prepare(const hand_setup *setup, hand_law *law);
void hand_prepare_plant(const hand_setup *setup, double m, double inertia, double mu, double h,
                        hand_plant *plant);

/* One control step. The network's weights are W[2][64]; node j sits at the corner whose d-th
 * coordinate is +1 where bit 5-d of j is set, -1 elsewhere (d = 0..5). */
void hand_mb_step(const hand_law *law, const double reference[7], const double pose[3],
                  const double v[2], double torque[2]);
void hand_nn_step(const hand_law *law, const double reference[7], const double pose[3],
                  const double v[2], double W[128], double torque[2]);

/* One classical Runge-Kutta step with the wheel torques held. */
void hand_plant_step(const hand_plant *plant, const double torque[2], double state[5]);

/* law = HAND_MB or HAND_NN; law_state is zeroed here and left as the last step leaves it.
 * Returns 0, or 1 when the run ended early because |v| reached 1e3 or was not a number. */
int hand_loop(int law, const hand_setup *setup, const hand_case *run, double law_state[128],
              hand_result *result);

/* n steps over a ring of input rows; the sum of all torques keeps every step alive. */
double hand_mb_repeat(const hand_law *law, int64_t n, const double *rows, int64_t count);
double hand_nn_repeat(const hand_law *law, int64_t n, const double *rows, int64_t count,
                      double W[128]);
double hand_plant_repeat(const hand_plant *plant, int64_t n, const double *torques, int64_t count,
                         double state[5]);

/* Sizes in bytes of hand_setup, hand_law, hand_case, hand_result, hand_plant, hand_axis: callers in
 * other languages check their own layout against them. */
void hand_sizes(int64_t sizes[6]);

/* The same steps in the shape that drive.c calls; state = a hand_law, then W for nn. */
void hand_mb_driven(const double *row, double *state, double *torque);
void hand_nn_driven(const double *row, double *state, double *torque);

#endif

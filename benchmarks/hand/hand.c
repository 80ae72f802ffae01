/* See hand.h. One translation unit, so that the compiler may inline every part. */
#include "hand.h"

#include "laws.h"
#include "plant.h"

#include <string.h>

#define HALF_PI 1.5707963267948966192313216916398
#define DIVERGED 1e3 /* m/s, rad/s */

/* ---- preparation -------------------------------------------------------------------------- */

static void prepare_axis(double u1, double u2, double clip, hand_axis *axis)
{
    axis->u1 = u1;
    axis->u2 = u2;
    axis->top = u1 - clip;
    axis->delta = u1 - u2;
    axis->inv_delta = 1.0 / (u1 - u2);
    axis->edge = u2 + axis->inv_delta;
}

void hand_prepare(const hand_setup *s, hand_law *p)
{
    memset(p, 0, sizeof *p);
    memcpy(p->k, s->k, sizeof p->k);
    p->mass[0] = s->m;
    p->mass[1] = s->inertia;
    p->coulomb = s->mu * s->m * s->g;
    p->inv_v_s = 1.0 / s->v_s;
    p->wheel_force = 0.5 * s->r;
    p->wheel_moment = 0.5 * s->r / s->l;
    p->nn_inv_eta2 = 1.0 / (s->nn_eta * s->nn_eta);
    /* beyond this |z| both of an input's exponentials are exactly 0: exp(-746) underflows */
    p->nn_far = 1.0 + s->nn_eta * sqrt(746.0);
    p->nn_ratio_cap = s->nn_ratio_cap;
    p->nn_inv_cap = 1.0 / s->nn_ratio_cap;
    for (int i = 0; i < 2; i++) {
        prepare_axis(s->v_u1[i], s->v_u2[i], s->clip, &p->axis[i]);
        p->mb_rho[i] = s->mb_rho[i];
        p->nn_rho1[i] = s->nn_rho1[i];
        p->nn_keep[i] = 1.0 - s->period * s->nn_gamma[i] * s->nn_sigma[i];
        p->nn_learn[i] = -s->period * s->nn_gamma[i];
    }
}

void hand_prepare_plant(const hand_setup *s, double m, double inertia, double mu, double h,
                        hand_plant *p)
{
    p->h = h;
    p->inv_m = 1.0 / m;
    p->inv_inertia = 1.0 / inertia;
    p->mu_g = mu * s->g;
    p->inv_v_s = 1.0 / s->v_s;
    p->inv_r = 1.0 / s->r;
    p->arm = s->l / s->r;
}

void hand_sizes(int64_t sizes[6])
{
    sizes[0] = sizeof(hand_setup);
    sizes[1] = sizeof(hand_law);
    sizes[2] = sizeof(hand_case);
    sizes[3] = sizeof(hand_result);
    sizes[4] = sizeof(hand_plant);
    sizes[5] = sizeof(hand_axis);
}

/* ---- one step at a time -------------------------------------------------------------------- */

void hand_mb_step(const hand_law *law, const double reference[7], const double pose[3],
                  const double v[2], double torque[2])
{
    mb_step(law, reference, pose, v, torque);
}

void hand_nn_step(const hand_law *law, const double reference[7], const double pose[3],
                  const double v[2], double W[128], double torque[2])
{
    nn_step(law, reference, pose, v, W, torque);
}

void hand_plant_step(const hand_plant *plant, const double torque[2], double state[5])
{
    rk4(plant, (torque[0] + torque[1]) * plant->inv_r, (torque[0] - torque[1]) * plant->arm,
        state);
}

/* ---- closed loop -------------------------------------------------------------------------- */

static inline void circle(const hand_case *run, double t, double ref[7])
{
    const double angle = run->rate * t;
    ref[0] = run->radius * sin(angle);
    ref[1] = run->radius - run->radius * cos(angle);
    ref[2] = angle - HALF_PI;
    ref[3] = run->radius * run->rate;
    ref[4] = run->rate;
    ref[5] = ref[6] = 0.0;
}

static inline void control(int law, const hand_law *p, const double ref[7], const double *state,
                           double *law_state, double torque[2])
{
    if (law == HAND_MB)
        mb_step(p, ref, state, state + 3, torque);
    else
        nn_step(p, ref, state, state + 3, law_state, torque);
}

/* Returns whether the run may go on. */
static inline int watch(const hand_law *p, hand_result *r)
{
    const double a = fabs(r->state[3]), b = fabs(r->state[4]);
    r->max_abs_v[0] = a > r->max_abs_v[0] ? a : r->max_abs_v[0];
    r->max_abs_v[1] = b > r->max_abs_v[1] ? b : r->max_abs_v[1];
    r->violations += (a > p->axis[0].u1) | (b > p->axis[1].u1);
    return (a < DIVERGED) & (b < DIVERGED);
}

int hand_loop(int law, const hand_setup *setup, const hand_case *run, double law_state[128],
              hand_result *r)
{
    hand_law p;
    hand_plant plant, changed;
    hand_prepare(setup, &p);
    hand_prepare_plant(setup, run->m_first, run->inertia_first, run->mu_first, run->plant, &plant);
    hand_prepare_plant(setup, run->m, run->inertia, run->mu, run->plant, &changed);
    memset(law_state, 0, HAND_LAW_STATE * sizeof *law_state);
    memset(r, 0, sizeof *r);
    memcpy(r->state, run->initial, sizeof r->state);
    if (!watch(&p, r))
        return 1;

    /* the first plant step that starts at or after the change, up to rounding of the times */
    const double change = ceil(run->t_change / run->plant - 1e-6);
    for (int64_t k = 0; k < run->samples; k++) {
        double ref[7], torque[2], noise[2];
        circle(run, (double)k * run->control, ref);
        control(law, &p, ref, r->state, law_state, torque);
        torque_noise(run, k, noise);
        const double right = torque[0] + noise[0], left = torque[1] + noise[1];
        const double force = (right + left) * plant.inv_r, moment = (right - left) * plant.arm;
        for (int64_t i = 0; i < run->substeps; i++) {
            if ((double)r->steps == change)
                plant = changed;
            rk4(&plant, force, moment, r->state);
            r->steps++;
            if (!watch(&p, r))
                return 1;
        }
    }
    return 0;
}

/* ---- loops for timing --------------------------------------------------------------------- */

double hand_mb_repeat(const hand_law *law, int64_t n, const double *rows, int64_t count)
{
    double torque[2], sum = 0.0;
    for (int64_t i = 0, row = 0; i < n; i++) {
        const double *in = rows + HAND_ROW * row;
        mb_step(law, in, in + 7, in + 10, torque);
        sum += torque[0] + torque[1];
        row = row + 1 == count ? 0 : row + 1;
    }
    return sum;
}

double hand_nn_repeat(const hand_law *law, int64_t n, const double *rows, int64_t count,
                      double W[128])
{
    double torque[2], sum = 0.0;
    for (int64_t i = 0, row = 0; i < n; i++) {
        const double *in = rows + HAND_ROW * row;
        nn_step(law, in, in + 7, in + 10, W, torque);
        sum += torque[0] + torque[1];
        row = row + 1 == count ? 0 : row + 1;
    }
    return sum;
}

double hand_plant_repeat(const hand_plant *plant, int64_t n, const double *torques, int64_t count,
                         double state[5])
{
    for (int64_t i = 0, row = 0; i < n; i++) {
        hand_plant_step(plant, torques + 2 * row, state);
        row = row + 1 == count ? 0 : row + 1;
    }
    return state[0] + state[1] + state[2] + state[3] + state[4];
}

void hand_mb_driven(const double *row, double *state, double *torque)
{
    mb_step((const hand_law *)(const void *)state, row, row + 7, row + 10, torque);
}

void hand_nn_driven(const double *row, double *state, double *torque)
{
    hand_law *law = (hand_law *)(void *)state;
    nn_step(law, row, row + 7, row + 10, (double *)(law + 1), torque);
}

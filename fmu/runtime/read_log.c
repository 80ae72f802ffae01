/* One pass of an identification filter over a log: the likelihood, its gradient and the Fisher information of each
   block of time, with several directions of derivatives a lane.  Kernels are generated (kalman.py). */
#include "lanes.h"

#define TOGETHER (WMR_DIRECTIONS * WMR_LANES)
#define GROUPS ((WMR_NAMES + TOGETHER - 1) / TOGETHER)
#define PARAMETERS (WMR_NAMES + WMR_KNOWN)
#define RESULTS (1 + 2 * WMR_OUTPUTS)
#define COLUMN (WMR_OUTPUTS * (WMR_OUTPUTS + 3) / 2)

#define LONGEST 0.01   /* longest piece of time for one step [s] */
#define SHORTEST 1e-9  /* shorter pieces of time are skipped [s] */

enum { SKIPPED, COUNTED, WATCHED };

/* Parameters, values that depend on them alone, and directions, one after another within a group. */
typedef struct {
    wmr_v p[PARAMETERS], dp[GROUPS][WMR_DIRECTIONS * PARAMETERS];
    wmr_v predict[WMR_PREDICT_PREPARED + 1], predict_slopes[WMR_PREDICT_SLOPES_PREPARED + 1];
    wmr_v correct[WMR_CORRECT_PREPARED + 1], correct_slopes[WMR_CORRECT_SLOPES_PREPARED + 1];
    int slopes;
} model;

typedef struct {
    wmr_v x[WMR_PRIMAL], dx[GROUPS][WMR_DIRECTIONS * WMR_PRIMAL];
} filter;

static void spread(int count, const double *from, wmr_v *to)
{
    for (int i = 0; i < count; ++i) {
        to[i] = wmr_all(from[i]);
    }
}

static void prepare(const double *parameters, int slopes, model *m)
{
    memset(m, 0, sizeof *m);
    spread(PARAMETERS, parameters, m->p);
    wmr_predict_prepare(m->p, m->predict);
    wmr_predict_slopes_prepare(m->p, m->predict_slopes);
    wmr_correct_prepare(m->p, m->correct);
    wmr_correct_slopes_prepare(m->p, m->correct_slopes);
    for (int i = 0; i < WMR_NAMES; ++i) {
        m->dp[i / TOGETHER][i % TOGETHER / WMR_LANES * PARAMETERS + i][i % WMR_LANES] = 1.0;
    }
    m->slopes = slopes;
}

static void begin(const double *mean, const double *covariance, filter *f)
{
    spread(WMR_STATE, mean, f->x);
    spread(WMR_PRIMAL - WMR_STATE, covariance, f->x + WMR_STATE);
    memset(f->dx, 0, sizeof f->dx);
}

static void step(const wmr_v *u, const model *m, filter *f)
{
    wmr_v next[WMR_PRIMAL], along[WMR_DIRECTIONS * WMR_PRIMAL];
    if (!m->slopes) {
        wmr_predict(u, f->x, m->p, m->predict, next);
    }
    for (int g = 0; m->slopes && g < GROUPS; ++g) {
        wmr_predict_slopes(u, f->x, m->p, f->dx[g], m->dp[g], m->predict_slopes, next, along);
        memcpy(f->dx[g], along, sizeof along);
    }
    memcpy(f->x, next, sizeof next);
}

/* Adds a measurement's contributions to nll (1), and with slopes to gradient (NAMES), fisher (NAMES by NAMES). */
static void correct(const wmr_v *u, const model *m, filter *f, double *nll, double *gradient,
                    double *fisher, double *told)
{
    wmr_v next[WMR_PRIMAL], along[WMR_DIRECTIONS * WMR_PRIMAL], y[RESULTS];
    wmr_v dy[WMR_DIRECTIONS * (1 + COLUMN)];
    double rows[1 + COLUMN][GROUPS * TOGETHER];
    if (!m->slopes) {
        wmr_correct(u, f->x, m->p, m->correct, next, y);
    }
    for (int g = 0; m->slopes && g < GROUPS; ++g) {
        wmr_correct_slopes(u, f->x, m->p, f->dx[g], m->dp[g], m->correct_slopes, next, y, along, dy);
        memcpy(f->dx[g], along, sizeof along);
        for (int k = 0; k < WMR_DIRECTIONS * (1 + COLUMN); ++k) {
            double *row = rows[k % (1 + COLUMN)] + g * TOGETHER;
            memcpy(row + k / (1 + COLUMN) * WMR_LANES, &dy[k], sizeof(wmr_v));
        }
    }
    memcpy(f->x, next, sizeof next);
    for (int i = 0; i < 2 * WMR_OUTPUTS; ++i) {
        told[i] = y[1 + i][0];
    }
    if (nll) {
        *nll += y[0][0];
    }
    for (int i = 0; gradient && i < WMR_NAMES; ++i) {
        gradient[i] += rows[0][i];
        for (int k = 1; k <= COLUMN; ++k) {
            for (int j = 0; j < WMR_NAMES; ++j) {
                fisher[i * WMR_NAMES + j] += rows[k][i] * rows[k][j];
            }
        }
    }
}

/* From one event to the next: a command acts for h0 + h1 delay [s], in pieces. */
static void move(const double *command, double h0, double h1, double delay, const model *m,
                 filter *f)
{
    const double length = h0 + h1 * delay;
    const double parts = length > SHORTEST ? ceil(length / LONGEST) : 0.0;
    const double piece[] = {command[0], command[1], h0 / parts, h1 / parts};
    wmr_v u[WMR_INPUTS];
    spread(sizeof piece / sizeof *piece, piece, u);
    for (int64_t k = 0; k < (int64_t)parts; ++k) {
        step(u, m, f);
    }
}

/* `count` samples at times t with measurements (count, 2), and `sent` commands (sent, 2); each acts from command_t plus
   a delay until the next one.  At the samples `first` a stretch begins, with means from `start` (stretches, STATE) and a
   covariance.  Each sample is used as its kind says, in its block.  It writes its residuals, their sizes in standard
   deviations, and the mean after it to `told`.  Without `slopes` there are no derivatives. */
WMR_EXPORT void wmr_read_log(int64_t count, int64_t sent, int64_t stretches, int32_t of_speed,
                             int32_t slopes, const double *t, const double *seen,
                             const double *variance, const double *command_t,
                             const double *command, const double *start,
                             const double *parameters, const double *covariance,
                             const int64_t *first, const int32_t *kinds, const int32_t *blocks,
                             double *nll, double *gradient, double *fisher, double *told)
{
    const double delay = parameters[WMR_DELAY];
    double since = 0.0, late = 0.0;
    int64_t n = 0, begun = 0, stretch = 0;
    model m;
    filter f;
    memset(&f, 0, sizeof f);
    prepare(parameters, slopes, &m);
    while (n < count) {
        /* Commands that begin to act as something is seen come after it. */
        const int sample = begun == sent || t[n] <= command_t[begun] + delay;
        const double base = sample ? t[n] : command_t[begun], now_late = sample ? 0.0 : 1.0;
        const int begins = stretch < stretches && first[stretch] == n;
        if (n > 0 && !begins) {
            move(command + 2 * (begun > 0 ? begun - 1 : 0), base - since, now_late - late, delay,
                 &m, &f);
        }
        since = base;
        late = now_late;
        if (!sample) {
            ++begun;
            continue;
        }
        if (begins) {
            begin(start + WMR_STATE * stretch++, covariance, &f);
        }
        if (kinds[n] != WATCHED) {
            const double row[] = {seen[2 * n], seen[2 * n + 1], variance[0], variance[1], of_speed};
            const int counted = kinds[n] == COUNTED;
            const int64_t b = blocks[n];
            wmr_v u[WMR_INPUTS];
            spread(WMR_INPUTS, row, u);
            correct(u, &m, &f, counted ? nll + b : 0,
                    counted && slopes ? gradient + b * WMR_NAMES : 0,
                    counted && slopes ? fisher + b * WMR_NAMES * WMR_NAMES : 0, told);
        }
        for (int i = 0; i < WMR_STATE; ++i) {
            told[2 * WMR_OUTPUTS + i] = f.x[i][0];
        }
        told += 2 * WMR_OUTPUTS + WMR_STATE;
        ++n;
    }
}

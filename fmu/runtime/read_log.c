/* One pass of an identification filter over a log: the likelihood, its gradient and the Fisher information of each
   block of time, with several directions of derivatives a lane.  Kernels are generated (kalman.py). */
#include "lanes.h"

#define TOGETHER (WMR_DIRECTIONS * WMR_LANES)
#define GROUPS ((WMR_NAMES + TOGETHER - 1) / TOGETHER)
#define PARAMETERS (WMR_NAMES + WMR_KNOWN)
#define RESULTS (1 + 2 * WMR_OUTPUTS)
#define COLUMN (WMR_OUTPUTS * (WMR_OUTPUTS + 3) / 2)

enum { START, PIECE, SKIPPED, COUNTED, WATCHED };

/* Parameters, what the kernels take of them alone, and directions: of a group one after the other. */
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

/* Adds what a measurement tells: to nll (1), and with slopes to gradient (NAMES), fisher (NAMES by NAMES). */
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

/* Events are rows of WIDTH numbers with a kind and a block each; a measurement writes its residuals,
   their sizes in standard deviations, then the mean after it, to `told`.  Without `slopes` there
   are no derivatives. */
WMR_EXPORT void wmr_read_log(int64_t count, const double *rows, const int32_t *kinds,
                             const int32_t *blocks, const double *parameters,
                             const double *covariance, int32_t slopes, double *nll,
                             double *gradient, double *fisher, double *told)
{
    wmr_v u[WMR_WIDE];
    model m;
    filter f;
    memset(&f, 0, sizeof f);
    prepare(parameters, slopes, &m);
    for (int64_t n = 0; n < count; ++n) {
        const double *row = rows + n * WMR_WIDE;
        const int counted = kinds[n] == COUNTED;
        const int64_t b = counted ? blocks[n] : 0;
        spread(WMR_WIDE, row, u);
        if (kinds[n] == START) {
            begin(row, covariance, &f);
        } else if (kinds[n] == PIECE) {
            step(u, &m, &f);
        } else {
            if (kinds[n] != WATCHED) {
                correct(u, &m, &f, counted ? nll + b : 0,
                        counted && slopes ? gradient + b * WMR_NAMES : 0,
                        counted && slopes ? fisher + b * WMR_NAMES * WMR_NAMES : 0, told);
            }
            for (int i = 0; i < WMR_STATE; ++i) {
                told[2 * WMR_OUTPUTS + i] = f.x[i][0];
            }
            told += 2 * WMR_OUTPUTS + WMR_STATE;
        }
    }
}

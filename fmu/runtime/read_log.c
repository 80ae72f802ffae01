/* One pass of an identification filter over a log: the likelihood, its gradient and the Fisher information of each
   block of time, with one direction of derivatives a lane.  Kernels are generated (kalman.py). */
#include "lanes.h"

#define GROUPS ((WMR_NAMES + WMR_LANES - 1) / WMR_LANES)
#define PARAMETERS (WMR_NAMES + WMR_KNOWN)
#define RESULTS (1 + 2 * WMR_OUTPUTS)
#define COLUMN (WMR_OUTPUTS * (WMR_OUTPUTS + 3) / 2)

enum { START, PIECE, SKIPPED, COUNTED, WATCHED };

typedef struct {
    wmr_v x[WMR_PRIMAL], dx[GROUPS][WMR_PRIMAL];
} filter;

static void spread(int count, const double *from, wmr_v *to)
{
    for (int i = 0; i < count; ++i) {
        to[i] = wmr_all(from[i]);
    }
}

static void begin(const double *mean, const double *covariance, filter *f)
{
    spread(WMR_STATE, mean, f->x);
    spread(WMR_PRIMAL - WMR_STATE, covariance, f->x + WMR_STATE);
    memset(f->dx, 0, sizeof f->dx);
}

static void step(const wmr_v *u, const wmr_v *p, wmr_v dp[][PARAMETERS], int groups, filter *f)
{
    wmr_v next[WMR_PRIMAL], along[WMR_PRIMAL];
    for (int g = 0; g < groups; ++g) {
        wmr_predict(u, f->x, f->dx[g], p, dp[g], next, along);
        memcpy(f->dx[g], along, sizeof along);
    }
    memcpy(f->x, next, sizeof next);
}

/* Adds what a measurement tells: to nll (1), gradient (NAMES), fisher (NAMES by NAMES). */
static void correct(const wmr_v *u, const wmr_v *p, wmr_v dp[][PARAMETERS], int groups, filter *f,
                    double *nll, double *gradient, double *fisher, double *told)
{
    wmr_v next[WMR_PRIMAL], along[WMR_PRIMAL], y[RESULTS], dy[1 + COLUMN];
    double column[COLUMN][GROUPS * WMR_LANES];
    for (int g = 0; g < groups; ++g) {
        wmr_correct(u, f->x, f->dx[g], p, dp[g], next, along, y, dy);
        memcpy(f->dx[g], along, sizeof along);
        for (int i = 0; i < WMR_LANES && gradient && g * WMR_LANES + i < WMR_NAMES; ++i) {
            gradient[g * WMR_LANES + i] += dy[0][i];
        }
        for (int k = 0; k < COLUMN; ++k) {
            memcpy(column[k] + g * WMR_LANES, &dy[1 + k], sizeof(wmr_v));
        }
    }
    memcpy(f->x, next, sizeof next);
    for (int i = 0; i < 2 * WMR_OUTPUTS; ++i) {
        told[i] = y[1 + i][0];
    }
    if (nll) {
        *nll += y[0][0];
    }
    for (int i = 0; fisher && groups == GROUPS && i < WMR_NAMES; ++i) {
        for (int k = 0; k < COLUMN; ++k) {
            for (int j = 0; j < WMR_NAMES; ++j) {
                fisher[i * WMR_NAMES + j] += column[k][i] * column[k][j];
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
    const int groups = slopes ? GROUPS : 1;
    wmr_v u[WMR_WIDE], p[PARAMETERS], dp[GROUPS][PARAMETERS];
    filter f;
    memset(&f, 0, sizeof f);
    memset(dp, 0, sizeof dp);
    spread(PARAMETERS, parameters, p);
    for (int i = 0; i < WMR_NAMES; ++i) {
        dp[i / WMR_LANES][i][i % WMR_LANES] = slopes ? 1.0 : 0.0;
    }
    for (int64_t n = 0; n < count; ++n) {
        const double *row = rows + n * WMR_WIDE;
        const int counted = kinds[n] == COUNTED;
        const int64_t b = counted ? blocks[n] : 0;
        spread(WMR_WIDE, row, u);
        if (kinds[n] == START) {
            begin(row, covariance, &f);
        } else if (kinds[n] == PIECE) {
            step(u, p, dp, groups, &f);
        } else {
            if (kinds[n] == WATCHED) {
                memset(told, 0, 2 * WMR_OUTPUTS * sizeof(double));
            } else {
                correct(u, p, dp, groups, &f, counted ? nll + b : 0,
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

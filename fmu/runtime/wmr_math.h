/* Small helpers of the generated kernels.  Comparisons instead of fmin and fmax: one instruction
   each, and the second operand is returned where one is NaN. */
#ifndef WMR_MATH_H
#define WMR_MATH_H

#include <math.h>

#define WMR_INF ((double)INFINITY)
#define WMR_NAN ((double)NAN)

static inline double wmr_min(double a, double b) { return a < b ? a : b; }
static inline double wmr_max(double a, double b) { return a > b ? a : b; }
static inline double wmr_sign(double a) { return a > 0.0 ? 1.0 : (a < 0.0 ? -1.0 : a); }

#endif

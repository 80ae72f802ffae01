/* Exact partial derivatives of outputs and rates by inputs, parameters, states and time. */
#ifndef WMR_DERIVATIVES_H
#define WMR_DERIVATIVES_H

#include "values.h"

/* sensitivity (of the unknowns) = Jacobian times seed (of the knowns). */
wmr_status wmr_forward(wmr_instance *s, const uint32_t *unknowns, size_t nu, const uint32_t *knowns,
                       size_t nk, const double *seed, size_t ns, double *sensitivity, size_t nd);

/* sensitivity (of the knowns) = transposed Jacobian times seed (of the unknowns). */
wmr_status wmr_reverse(wmr_instance *s, const uint32_t *unknowns, size_t nu, const uint32_t *knowns,
                       size_t nk, const double *seed, size_t ns, double *sensitivity, size_t nd);

#endif

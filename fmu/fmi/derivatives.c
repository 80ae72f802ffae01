#include "derivatives.h"

#include <math.h>
#include <string.h>

#if !WMR_HAS_DERIVATIVES

wmr_status wmr_forward(wmr_instance *s, const uint32_t *unknowns, size_t nu, const uint32_t *knowns,
                       size_t nk, const double *seed, size_t ns, double *sensitivity, size_t nd)
{
    (void)unknowns, (void)nu, (void)knowns, (void)nk, (void)seed, (void)ns, (void)sensitivity,
        (void)nd;
    return wmr_say(s, WMR_ERROR, "this model has no partial derivatives.");
}

wmr_status wmr_reverse(wmr_instance *s, const uint32_t *unknowns, size_t nu, const uint32_t *knowns,
                       size_t nk, const double *seed, size_t ns, double *sensitivity, size_t nd)
{
    return wmr_forward(s, unknowns, nu, knowns, nk, seed, ns, sensitivity, nd);
}

#else
#include "jacobian.h"

/* Rows that may be seeded: time and inputs, parameters, states, which lie side by side. */
static int is_known(uint32_t ref)
{
    const int64_t row = ref;
    return row >= WMR_Z && row < WMR_Z + WMR_NZ;
}

/* Rates, outputs and diagnostics, and states that are published as outputs. */
static int is_unknown(uint32_t ref)
{
    const int64_t row = ref;
    return row >= WMR_X;
}

static wmr_status check_rows(wmr_instance *s, const uint32_t *refs, size_t count,
                             int (*fits)(uint32_t), const double *numbers, size_t length)
{
    const int64_t wanted = wmr_length(s, WMR_REAL, refs, count);
    if (wanted < 0) {
        return WMR_ERROR;
    }
    if ((uint64_t)wanted != length || (length && !numbers)) {
        return wmr_say(s, WMR_ERROR, "expected %u numbers but got %u (or no array).",
                       (unsigned)wanted, (unsigned)length);
    }
    for (size_t i = 0; i < count; ++i) {
        if (!fits(refs[i])) {
            return wmr_say(s, WMR_ERROR, "%s has no place in this derivative.",
                           wmr_variables[refs[i]].name);
        }
    }
    return WMR_OK;
}

/* Values at which the model is linearised: those of now, and of a model with inputs the memory that
   its last sample started from. */
static const double *point(wmr_instance *s)
{
    double *known = s->scratch.known;
    memcpy(known, s->state.values + WMR_Z, WMR_NZ * sizeof(double));
#if WMR_KIND == WMR_SAMPLED
    if (WMR_NU > 0 && s->state.memory.count > 0) {
        memcpy(known + (WMR_X - WMR_Z), s->state.memory.used, WMR_NX * sizeof(double));
    }
#endif
    return known;
}

static void scatter(const uint32_t *refs, size_t count, const double *from, double *rows)
{
    for (size_t i = 0; i < count; ++i) {
        for (uint32_t j = 0; j < wmr_variables[refs[i]].size; ++j) {
            rows[refs[i] + j] += *from++;
        }
    }
}

static void gather(const uint32_t *refs, size_t count, const double *rows, double *to)
{
    for (size_t i = 0; i < count; ++i) {
        for (uint32_t j = 0; j < wmr_variables[refs[i]].size; ++j) {
            *to++ = rows[refs[i] + j];
        }
    }
}

static wmr_status check_seed(wmr_instance *s, const double *seed, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(seed[i])) {
            return wmr_say(s, WMR_ERROR, "seed %u is not finite.", (unsigned)i + 1);
        }
    }
    return WMR_OK;
}

wmr_status wmr_forward(wmr_instance *s, const uint32_t *unknowns, size_t nu, const uint32_t *knowns,
                       size_t nk, const double *seed, size_t ns, double *sensitivity, size_t nd)
{
    double rows[WMR_ROWS] = {0.0};
    if (check_rows(s, unknowns, nu, is_unknown, sensitivity, nd) != WMR_OK
        || check_rows(s, knowns, nk, is_known, seed, ns) != WMR_OK
        || check_seed(s, seed, ns) != WMR_OK) {
        return WMR_ERROR;
    }
    scatter(knowns, nk, seed, rows);
    wmr_forward_rows(point(s), rows + WMR_Z, rows + WMR_W);
    gather(unknowns, nu, rows, sensitivity);
    return WMR_OK;
}

wmr_status wmr_reverse(wmr_instance *s, const uint32_t *unknowns, size_t nu, const uint32_t *knowns,
                       size_t nk, const double *seed, size_t ns, double *sensitivity, size_t nd)
{
    double rows[WMR_ROWS] = {0.0}, back[WMR_NZ] = {0.0};
    if (check_rows(s, unknowns, nu, is_unknown, seed, ns) != WMR_OK
        || check_rows(s, knowns, nk, is_known, sensitivity, nd) != WMR_OK
        || check_seed(s, seed, ns) != WMR_OK) {
        return WMR_ERROR;
    }
    scatter(unknowns, nu, seed, rows);
    wmr_reverse_rows(point(s), rows + WMR_W, back);
    for (int i = 0; i < WMR_NZ; ++i) {
        rows[WMR_Z + i] += back[i];
    }
    gather(knowns, nk, rows, sensitivity);
    return WMR_OK;
}

#endif

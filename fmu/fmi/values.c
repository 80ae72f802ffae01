#include "values.h"

#include <math.h>
#include <string.h>

#define BEFORE (WMR_IN_START | WMR_IN_INIT)
#define BETWEEN (WMR_IN_STEP | WMR_IN_EVENT)

/* States in which a variable of each role may be set. */
static const int SETTABLE[] = {
    0,                                    /* WMR_INDEPENDENT */
    BEFORE | BETWEEN | WMR_IN_CONTINUOUS, /* WMR_INPUT */
    BEFORE,                               /* WMR_FIXED */
    BEFORE | BETWEEN,                     /* WMR_TUNABLE */
    BEFORE,                               /* WMR_START */
    0                                     /* WMR_CALCULATED */
};

/* In model exchange solvers set states and tunable parameters with the inputs. */
static int settable(const wmr_instance *s, uint32_t ref)
{
    const int role = wmr_variables[ref].role;
    const int state = role == WMR_START && ref < WMR_X + WMR_CONTINUOUS_STATES;
    const int solved = s->state.interface == WMR_MODEL_EXCHANGE && (state || role == WMR_TUNABLE);
    return (SETTABLE[role] | (solved ? SETTABLE[WMR_INPUT] : 0)) & s->state.mode;
}

/* A value that cannot be set now: the one that is there already may be written again. */
static wmr_status check_same(wmr_instance *s, uint32_t ref, const double *values)
{
    const wmr_variable *v = &wmr_variables[ref];
    const double *now = s->state.values + ref;
    if (v->role != WMR_FIXED && v->role != WMR_TUNABLE && v->role != WMR_START) {
        return wmr_say(s, WMR_ERROR, "%s cannot be set now.", v->name);
    }
    for (uint32_t i = 0; i < v->size; ++i) {
        if (!(values[i] == now[i])) {
            return wmr_say(s, WMR_ERROR, "%s is fixed by now: it is %.17g and cannot become %.17g.",
                           v[i].name, now[i], values[i]);
        }
    }
    return wmr_say(s, WMR_WARNING, "%s is fixed by now, and was set to the value that it has.",
                   v->name);
}

int64_t wmr_length(wmr_instance *s, wmr_type type, const uint32_t *refs, size_t count)
{
    int64_t total = 0;
    if (count && !refs) {
        wmr_say(s, WMR_ERROR, "the list of value references is missing.");
        return -1;
    }
    for (size_t i = 0; i < count; ++i) {
        const int known = refs[i] < WMR_ROWS && wmr_variables[refs[i]].size > 0;
        if (!known || wmr_variables[refs[i]].type != type) {
            wmr_say(s, WMR_ERROR, "no variable of this type has the value reference %u.",
                    (unsigned)refs[i]);
            return -1;
        }
        total += wmr_variables[refs[i]].size;
    }
    return total;
}

static wmr_status check_length(wmr_instance *s, int64_t wanted, const double *values, size_t length)
{
    if (wanted < 0) {
        return WMR_ERROR;
    }
    if ((uint64_t)wanted != length) {
        return wmr_say(s, WMR_ERROR, "expected %u values but got %u.", (unsigned)wanted,
                       (unsigned)length);
    }
    if (length && !values) {
        return wmr_say(s, WMR_ERROR, "the array of values is missing.");
    }
    return WMR_OK;
}

wmr_status wmr_get(wmr_instance *s, wmr_type type, const uint32_t *refs, size_t count,
                   double *values, size_t length)
{
    const wmr_status status = check_length(s, wmr_length(s, type, refs, count), values, length);
    if (status != WMR_OK) {
        return status;
    }
    wmr_refresh(s);
    for (size_t i = 0; i < count; ++i) {
        const size_t size = wmr_variables[refs[i]].size;
        memcpy(values, s->state.values + refs[i], size * sizeof(double));
        values += size;
    }
    return WMR_OK;
}

static wmr_status check_value(wmr_instance *s, const wmr_variable *v, double value)
{
    if (!isfinite(value)) {
        return wmr_say(s, WMR_ERROR, "%s = %g is not finite.", v->name, value);
    }
    if (value < v->min || value > v->max) {
        return wmr_say(s, WMR_ERROR, "%s = %.17g is outside of %g to %g.", v->name, value, v->min,
                       v->max);
    }
    return WMR_OK;
}

/* One value reference with all its elements. */
static wmr_status check_variable(wmr_instance *s, uint32_t ref, const double *values)
{
    const wmr_variable *v = &wmr_variables[ref];
    wmr_status status = WMR_OK;
    if (!settable(s, ref)) {
        return check_same(s, ref, values);
    }
    for (uint32_t i = 0; i < v->size && status == WMR_OK; ++i) {
        status = check_value(s, v + i, values[i]);
    }
    return status;
}

wmr_status wmr_set(wmr_instance *s, wmr_type type, const uint32_t *refs, size_t count,
                   const double *values, size_t length)
{
    wmr_status status = check_length(s, wmr_length(s, type, refs, count), values, length);
    wmr_status worst = status;
    const double *value = values;
    for (size_t i = 0; i < count && status <= WMR_WARNING; ++i) {
        status = check_variable(s, refs[i], value);
        worst = status > worst ? status : worst;
        value += wmr_variables[refs[i]].size;
    }
    if (worst > WMR_WARNING) {
        return worst;
    }
    for (size_t i = 0; i < count; ++i) {
        const size_t size = wmr_variables[refs[i]].size;
        memcpy(s->state.values + refs[i], values, size * sizeof(double));
        values += size;
    }
    s->state.stale = 1;
    return worst;
}

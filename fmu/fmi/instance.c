#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ALIVE UINT64_C(0x574d525f494e5354)
#define TIME_TOLERANCE 1e-9

const char *const WMR_CATEGORIES[WMR_LOG_COUNT] = {"logStatusError", "logStatusDiscard",
                                                   "logEvents"};

static const int CATEGORY_OF[] = {WMR_LOG_EVENTS, WMR_LOG_EVENTS, WMR_LOG_DISCARD, WMR_LOG_ERROR};

/* Errors and refusals are always told; the rest only where logging is on. */
wmr_status wmr_say(wmr_instance *s, wmr_status status, const char *format, ...)
{
    char text[512];
    va_list arguments;
    if (!s->log || (status < WMR_DISCARD && !(s->logging & (1 << CATEGORY_OF[status])))) {
        return status;
    }
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    s->log(s, status, WMR_CATEGORIES[CATEGORY_OF[status]], text);
    return status;
}

static int category(const char *name)
{
    for (int i = 0; name && i < WMR_LOG_COUNT; ++i) {
        if (strcmp(name, WMR_CATEGORIES[i]) == 0) {
            return i;
        }
    }
    return -1;
}

wmr_status wmr_set_logging(wmr_instance *s, int on, size_t count, const char *const *categories)
{
    int wanted = 0;
    if (count > 0 && !categories) {
        return wmr_say(s, WMR_ERROR, "the list of log categories is missing.");
    }
    for (size_t i = 0; i < count; ++i) {
        if (category(categories[i]) < 0) {
            return wmr_say(s, WMR_ERROR, "one of the log categories is not known.");
        }
        wanted |= 1 << category(categories[i]);
    }
    wanted = count == 0 ? (1 << WMR_LOG_COUNT) - 1 : wanted;
    s->logging = on ? s->logging | wanted : s->logging & ~wanted;
    return WMR_OK;
}

static void start_values(wmr_state *state)
{
    const int32_t interface = state->interface;
    memset(state, 0, sizeof *state);
    state->interface = interface;
    state->mode = WMR_IN_START;
    state->stop_time = INFINITY;
    state->stale = 1;
    for (size_t i = 0; i < WMR_ROWS; ++i) {
        state->values[i] = wmr_variables[i].start;
    }
}

wmr_instance *wmr_create(const char *name, wmr_interface interface)
{
    wmr_instance *s = (wmr_instance *)calloc(1, sizeof *s);
    if (!s) {
        return NULL;
    }
    s->magic = ALIVE;
    s->state.interface = (int32_t)interface;
    strncpy(s->name, name ? name : "", sizeof s->name - 1);
    start_values(&s->state);
    return s;
}

void wmr_free(wmr_instance *s)
{
    if (wmr_is_instance(s)) {
        s->magic = 0;
        free(s);
    }
}

int wmr_is_instance(const wmr_instance *s)
{
    return s && s->magic == ALIVE;
}

void wmr_reset(wmr_instance *s)
{
    start_values(&s->state);
}

wmr_status wmr_setup(wmr_instance *s, double start, int has_stop, double stop, int has_tolerance,
                     double tolerance)
{
    if (!isfinite(start) || (has_stop && !(isfinite(stop) && stop >= start))) {
        return wmr_say(s, WMR_ERROR,
                       "start and stop time must be finite and in order (%g s, %g s).", start,
                       stop);
    }
    if (has_tolerance && !(isfinite(tolerance) && tolerance > 0.0)) {
        return wmr_say(s, WMR_ERROR, "the tolerance must be finite and positive, not %g.",
                       tolerance);
    }
    s->state.start_time = start;
    s->state.stop_time = has_stop ? stop : INFINITY;
    s->state.values[0] = start;
    s->state.experiment = 1;
    s->state.stale = 1;
    return WMR_OK;
}

static int finite_from(const wmr_instance *s, size_t first)
{
    for (size_t i = first; i < WMR_ROWS; ++i) {
        if (!isfinite(s->state.values[i])) {
            return 0;
        }
    }
    return 1;
}

/* Two parameters that are not in order; NULL if all are. */
static const wmr_order *contradiction(const wmr_instance *s)
{
    for (int i = 0; i < WMR_ORDERS; ++i) {
        const wmr_order *pair = &wmr_orders[i];
        const double low = s->state.values[pair->low], high = s->state.values[pair->high];
        if (pair->apart ? low >= high : low > high) {
            return pair;
        }
    }
    return NULL;
}

wmr_status wmr_leave_init(wmr_instance *s)
{
    const wmr_order *wrong = contradiction(s);
    if (wrong) {
        return wmr_say(s, WMR_ERROR, "the parameters contradict one another: %s = %g must %s %s = %g.",
                       wmr_variables[wrong->low].name, s->state.values[wrong->low],
                       wrong->apart ? "be below" : "not be above", wmr_variables[wrong->high].name,
                       s->state.values[wrong->high]);
    }
    if (!kind_start(s)) {
        return wmr_say(s, WMR_ERROR,
                       "the parameters contradict one another: the periods must be whole "
                       "multiples, and delays must fit.");
    }
    s->state.stale = 1;
    wmr_refresh(s);
    if (!finite_from(s, 0)) {
        return wmr_say(s, WMR_ERROR,
                       "the outputs at the start are not finite: start values and "
                       "parameters do not fit one another.");
    }
    s->state.mode = s->state.interface == WMR_CO_SIMULATION ? WMR_IN_STEP : WMR_IN_EVENT;
    return wmr_say(s, WMR_OK, "initialised at t = %g s.", s->state.values[0]);
}

void wmr_refresh(wmr_instance *s)
{
    if (s->state.stale) {
        kind_refresh(s);
        s->state.stale = 0;
    }
}

/* True if a step from t over h may be tried. */
static wmr_status check_step(wmr_instance *s, double t, double h)
{
    const double now = s->state.values[0], stop = s->state.stop_time;
    if (s->state.finished) {
        return wmr_say(s, WMR_ERROR, "the model has ended the simulation; reset or free it.");
    }
    if (!isfinite(h) || !(h > 0.0)) {
        return wmr_say(s, WMR_ERROR, "the step size must be finite and positive, not %g s.", h);
    }
    if (!isfinite(t) || fabs(t - now) > TIME_TOLERANCE * (fabs(now) + h)) {
        return wmr_say(s, WMR_ERROR,
                       "the communication point %.17g s is not the current time %.17g s.", t, now);
    }
    if (!(t + h > t)) {
        return wmr_say(s, WMR_ERROR, "a step of %g s is lost in rounding at t = %g s.", h, t);
    }
    if (t + h > stop + TIME_TOLERANCE * (fabs(stop) + h)) {
        return wmr_say(s, WMR_ERROR, "a step of %g s from %g s goes past the stop time %g s.", h, t,
                       stop);
    }
    if (!(kind_steps(s, t, h) <= WMR_MOST_STEPS)) {
        return wmr_say(s, WMR_DISCARD,
                       "a step of %g s takes more than %g internal steps; ask for a "
                       "shorter one.",
                       h, WMR_MOST_STEPS);
    }
    return WMR_OK;
}

/* States and the values computed from them are adjacent. */
enum { RESULTS = WMR_ROWS - WMR_X };

/* An importer may try again after Discard.  A closed loop has no input, and its samples are at
   fixed instants: each try would fail in the same way. */
#define NOT_FINITE (WMR_KIND == WMR_LOOP ? WMR_ERROR : WMR_DISCARD)

static wmr_status step_back(wmr_instance *s, const double *results)
{
    memcpy(s->state.values + WMR_X, results, RESULTS * sizeof(double));
    s->state.stale = 1;
    return wmr_say(s, NOT_FINITE,
                   "states or outputs are no longer finite; the step was taken back. Ask for a "
                   "shorter one, or for smaller values.");
}

wmr_status wmr_do_step(wmr_instance *s, double t, double h)
{
    double before[RESULTS + 1];
    const wmr_memory memory = s->state.memory;
    const wmr_status status = check_step(s, t, h);
    if (status != WMR_OK) {
        return status;
    }
    memcpy(before, s->state.values + WMR_X, RESULTS * sizeof(double));
    const double reached = kind_advance(s, t, h);
    if (!s->state.finished && !finite_from(s, WMR_X)) {
        s->state.memory = memory;
        return step_back(s, before);
    }
    s->state.values[0] = reached;
    s->state.stale = 1;
    if (s->state.finished) {
        return wmr_say(s, WMR_DISCARD, "the model ends the simulation at t = %g s.", reached);
    }
    return WMR_OK;
}

wmr_status wmr_set_time(wmr_instance *s, double t)
{
    if (!isfinite(t)) {
        return wmr_say(s, WMR_ERROR, "the time must be finite, not %g.", t);
    }
    s->state.values[0] = t;
    s->state.stale = 1;
    return WMR_OK;
}

static wmr_status check_vector(wmr_instance *s, const double *x, size_t nx)
{
    if (nx != WMR_CONTINUOUS_STATES || (!x && nx)) {
        return wmr_say(s, WMR_ERROR,
                       "the model has %d continuous states, not %u (or no array was given).",
                       WMR_CONTINUOUS_STATES, (unsigned)nx);
    }
    return WMR_OK;
}

wmr_status wmr_set_states(wmr_instance *s, const double *x, size_t nx)
{
    const wmr_status status = check_vector(s, x, nx);
    for (size_t i = 0; status == WMR_OK && i < nx; ++i) {
        if (!isfinite(x[i])) {
            return wmr_say(s, WMR_DISCARD, "state %u is not finite.", (unsigned)i + 1);
        }
    }
    if (status == WMR_OK && nx) {
        memcpy(s->state.values + WMR_X, x, nx * sizeof(double));
        s->state.stale = 1;
    }
    return status;
}

static wmr_status copied(wmr_instance *s, const double *from, double *to, size_t nx)
{
    const wmr_status status = check_vector(s, to, nx);
    if (status == WMR_OK && nx) {
        memcpy(to, from, nx * sizeof(double));
    }
    return status;
}

wmr_status wmr_get_states(wmr_instance *s, double *x, size_t nx)
{
    return copied(s, s->state.values + WMR_X, x, nx);
}

wmr_status wmr_get_rates(wmr_instance *s, double *rates, size_t nx)
{
    wmr_refresh(s);
    return copied(s, s->state.values + WMR_W, rates, nx);
}

wmr_status wmr_get_nominals(wmr_instance *s, double *nominals, size_t nx)
{
    const wmr_status status = check_vector(s, nominals, nx);
    for (size_t i = 0; status == WMR_OK && i < nx; ++i) {
        nominals[i] = 1.0;
    }
    return status;
}

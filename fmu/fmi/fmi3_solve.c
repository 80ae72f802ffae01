/* FMI 3.0: stepping, by the model itself (co-simulation) or by the importer (model exchange). */
#include "fmi3Functions.h"

#include "calls.h"

static const wmr_call ENTER_EVENT = {"fmi3EnterEventMode", WMR_IN_CONTINUOUS};
static const wmr_call UPDATE_DISCRETE = {"fmi3UpdateDiscreteStates", WMR_IN_EVENT};
static const wmr_call EVALUATE_DISCRETE = {"fmi3EvaluateDiscreteStates",
                                           WMR_IN_INIT | WMR_IN_EVENT};
static const wmr_call ENTER_CONTINUOUS = {"fmi3EnterContinuousTimeMode", WMR_IN_EVENT};
static const wmr_call COMPLETED = {"fmi3CompletedIntegratorStep", WMR_IN_CONTINUOUS};
static const wmr_call SET_TIME = {"fmi3SetTime", WMR_IN_EVENT | WMR_IN_CONTINUOUS};
static const wmr_call SET_STATES = {"fmi3SetContinuousStates", WMR_IN_CONTINUOUS};
static const wmr_call SOLVE = {"a function for model exchange", WMR_SOLVING_MODES};
static const wmr_call COUNT = {"a number of states or indicators", WMR_ANY_MODE};
static const wmr_call DO_STEP = {"fmi3DoStep", WMR_IN_STEP};

/* Functions of model exchange are not there for an instance of co-simulation. */
static wmr_instance *solving(fmi3Instance instance, const wmr_call *call)
{
    wmr_instance *s = wmr_legal(instance, call);
    if (s && s->state.interface != WMR_MODEL_EXCHANGE) {
        wmr_say(s, WMR_ERROR, "%s needs an instance for model exchange.", call->name);
        return NULL;
    }
    return s;
}

static fmi3Status missing(wmr_instance *s)
{
    return status_of(wmr_say(s, WMR_ERROR, "there is no place for the answers."));
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    wmr_instance *s = solving(instance, &ENTER_EVENT);
    if (s) {
        s->state.mode = WMR_IN_EVENT;
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    return solving(instance, &EVALUATE_DISCRETE) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *end,
                                    fmi3Boolean *nominals, fmi3Boolean *states,
                                    fmi3Boolean *has_next, fmi3Float64 *next)
{
    wmr_instance *s = solving(instance, &UPDATE_DISCRETE);
    if (s && !(again && end && nominals && states && has_next && next)) {
        return missing(s);
    }
    if (s) {
        *again = *end = *nominals = *states = *has_next = fmi3False;
        *next = 0.0;
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    wmr_instance *s = solving(instance, &ENTER_CONTINUOUS);
    if (s) {
        s->state.mode = WMR_IN_CONTINUOUS;
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean final,
                                       fmi3Boolean *enter_event, fmi3Boolean *end)
{
    wmr_instance *s = solving(instance, &COMPLETED);
    (void) final;
    if (s && !(enter_event && end)) {
        return missing(s);
    }
    if (s) {
        *enter_event = *end = fmi3False;
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    wmr_instance *s = solving(instance, &SET_TIME);
    return s ? status_of(wmr_set_time(s, time)) : fmi3Error;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t nx)
{
    wmr_instance *s = solving(instance, &SET_STATES);
    return s ? status_of(wmr_set_states(s, x, nx)) : fmi3Error;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 rates[], size_t nx)
{
    wmr_instance *s = solving(instance, &SOLVE);
    return s ? status_of(wmr_get_rates(s, rates, nx)) : fmi3Error;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t ni)
{
    wmr_instance *s = solving(instance, &SOLVE);
    (void)indicators;
    if (s && ni) {
        return status_of(wmr_say(s, WMR_ERROR, "this FMU has no event indicators."));
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t nx)
{
    wmr_instance *s = solving(instance, &SOLVE);
    return s ? status_of(wmr_get_states(s, x, nx)) : fmi3Error;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
                                             size_t nx)
{
    wmr_instance *s = solving(instance, &SOLVE);
    return s ? status_of(wmr_get_nominals(s, nominals, nx)) : fmi3Error;
}

static fmi3Status counted(fmi3Instance instance, size_t *to, size_t number)
{
    wmr_instance *s = wmr_legal(instance, &COUNT);
    if (s && !to) {
        return missing(s);
    }
    if (s) {
        *to = number;
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *ni)
{
    return counted(instance, ni, 0);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nx)
{
    return counted(instance, nx, WMR_CONTINUOUS_STATES);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_rollback,
                      fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last)
{
    wmr_instance *s = wmr_legal(instance, &DO_STEP);
    (void)no_rollback;
    if (!s) {
        return fmi3Error;
    }
    if (!(event && end && early && last)) {
        return missing(s);
    }
    const wmr_status status = wmr_do_step(s, t, h);
    *event = fmi3False;
    *end = s->state.finished;
    *last = s->state.values[0];
    *early = status == WMR_OK && *last < t + h;
    return s->state.finished && status == WMR_DISCARD ? fmi3OK : status_of(status);
}

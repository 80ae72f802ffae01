/* FMI 2.0: stepping, by the model itself (co-simulation) or by the importer (model exchange). */
#include "fmi2Functions.h"

#include "calls.h"

static const wmr_call ENTER_EVENT = {"fmi2EnterEventMode", WMR_IN_CONTINUOUS};
static const wmr_call NEW_DISCRETE = {"fmi2NewDiscreteStates", WMR_IN_EVENT};
static const wmr_call ENTER_CONTINUOUS = {"fmi2EnterContinuousTimeMode", WMR_IN_EVENT};
static const wmr_call COMPLETED = {"fmi2CompletedIntegratorStep", WMR_IN_CONTINUOUS};
static const wmr_call SET_TIME = {"fmi2SetTime", WMR_IN_EVENT | WMR_IN_CONTINUOUS};
static const wmr_call SET_STATES = {"fmi2SetContinuousStates", WMR_IN_CONTINUOUS};
static const wmr_call SOLVE = {"a function for model exchange", WMR_SOLVING_MODES};
static const wmr_call DO_STEP = {"fmi2DoStep", WMR_IN_STEP};
static const wmr_call STATUS = {"fmi2GetStatus", WMR_IN_STEP | WMR_IN_STOPPED};
static const wmr_call NEVER = {"this function", 0};

/* Functions of model exchange are not there for an instance of co-simulation. */
static wmr_instance *solving(fmi2Component c, const wmr_call *call)
{
    wmr_instance *s = wmr_legal(c, call);
    if (s && s->state.interface != WMR_MODEL_EXCHANGE) {
        wmr_say(s, WMR_ERROR, "%s needs an instance for model exchange.", call->name);
        return NULL;
    }
    return s;
}

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    wmr_instance *s = solving(c, &ENTER_EVENT);
    if (s) {
        s->state.mode = WMR_IN_EVENT;
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    static const fmi2EventInfo nothing_new = {0, 0, 0, 0, 0, 0.0};
    wmr_instance *s = solving(c, &NEW_DISCRETE);
    if (s && !info) {
        return status_of(wmr_say(s, WMR_ERROR, "there is no place for the event info."));
    }
    if (s) {
        *info = nothing_new;
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    wmr_instance *s = solving(c, &ENTER_CONTINUOUS);
    if (s) {
        s->state.mode = WMR_IN_CONTINUOUS;
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean final, fmi2Boolean *enter_event,
                                       fmi2Boolean *end)
{
    wmr_instance *s = solving(c, &COMPLETED);
    (void) final;
    if (s && (!enter_event || !end)) {
        return status_of(wmr_say(s, WMR_ERROR, "there is no place for the answers."));
    }
    if (s) {
        *enter_event = *end = fmi2False;
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    wmr_instance *s = solving(c, &SET_TIME);
    return s ? status_of(wmr_set_time(s, time)) : fmi2Error;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    wmr_instance *s = solving(c, &SET_STATES);
    return s ? status_of(wmr_set_states(s, x, nx)) : fmi2Error;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t nx)
{
    wmr_instance *s = solving(c, &SOLVE);
    return s ? status_of(wmr_get_rates(s, rates, nx)) : fmi2Error;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t ni)
{
    wmr_instance *s = solving(c, &SOLVE);
    (void)indicators;
    if (s && ni) {
        return status_of(wmr_say(s, WMR_ERROR, "this FMU has no event indicators."));
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    wmr_instance *s = solving(c, &SOLVE);
    return s ? status_of(wmr_get_states(s, x, nx)) : fmi2Error;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t nx)
{
    wmr_instance *s = solving(c, &SOLVE);
    return s ? status_of(wmr_get_nominals(s, nominals, nx)) : fmi2Error;
}

/* Inputs are held over a step, so derivatives of inputs and outputs are not offered. */
static fmi2Status not_offered(fmi2Component c)
{
    wmr_legal(c, &NEVER);
    return fmi2Error;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return not_offered(c);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return not_offered(c);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback)
{
    wmr_instance *s = wmr_legal(c, &DO_STEP);
    (void)no_rollback;
    return s ? status_of(wmr_do_step(s, time, step)) : fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return not_offered(c);
}

/* Steps are never pending, so most questions about them have no answer. */
static fmi2Status no_answer(fmi2Component c)
{
    wmr_instance *s = wmr_legal(c, &STATUS);
    return s ? status_of(wmr_say(s, WMR_DISCARD, "there is no such status: no step is pending."))
             : fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return no_answer(c);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    wmr_instance *s = wmr_legal(c, &STATUS);
    if (!s || kind != fmi2LastSuccessfulTime || !value) {
        return no_answer(c);
    }
    *value = s->state.values[0];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return no_answer(c);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    wmr_instance *s = wmr_legal(c, &STATUS);
    if (!s || kind != fmi2Terminated || !value) {
        return no_answer(c);
    }
    *value = s->state.finished;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return no_answer(c);
}

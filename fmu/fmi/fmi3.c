/* FMI 3.0: each function checks whether it may be called and hands over to the instance. */
#include "fmi3Functions.h"

#include <string.h>

#include "calls.h"
#include "derivatives.h"
#include "snapshot.h"

static const wmr_call SET_DEBUG_LOGGING = {"fmi3SetDebugLogging", WMR_ANY_MODE | WMR_IN_UPDATE};
static const wmr_call ENTER_INIT = {"fmi3EnterInitializationMode", WMR_IN_START};
static const wmr_call EXIT_INIT = {"fmi3ExitInitializationMode", WMR_IN_INIT};
static const wmr_call TERMINATE = {"fmi3Terminate", WMR_RUNNING_MODES};
static const wmr_call RESET = {"fmi3Reset", WMR_ANY_MODE};
static const wmr_call STATE = {"a function for FMU states", WMR_ANY_MODE};
static const wmr_call DERIVE = {"a partial derivative", WMR_RUNNING_MODES | WMR_SOLVING_MODES};

static void log_message(wmr_instance *s, wmr_status status, const char *category, const char *text)
{
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)s->callback;
    if (logger) {
        logger(s->environment, (fmi3Status)status, category, text);
    }
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count,
                               const fmi3String categories[])
{
    wmr_instance *s = wmr_legal(instance, &SET_DEBUG_LOGGING);
    return s ? status_of(wmr_set_logging(s, on, count, categories)) : fmi3Error;
}

/* An instance; NULL if name or token are wrong, with a message. */
static wmr_instance *made(fmi3String name, fmi3String token, wmr_interface interface,
                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                          fmi3LogMessageCallback logger)
{
    wmr_instance *s = wmr_create(name, interface);
    if (!s) {
        return NULL;
    }
    s->log = log_message;
    s->callback = (void (*)(void))logger;
    s->environment = environment;
    wmr_set_logging(s, logging, 0, NULL);
    if (name && *name && token && strcmp(token, WMR_TOKEN) == 0) {
        return s;
    }
    wmr_say(s, WMR_ERROR, "the instance needs a name and the token of this FMU (" WMR_TOKEN ").");
    wmr_free(s);
    return NULL;
}

static wmr_instance *refused(wmr_instance *s, const char *why)
{
    if (s) {
        wmr_say(s, WMR_ERROR, "%s", why);
        wmr_free(s);
    }
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger)
{
    wmr_instance *s = made(name, token, WMR_MODEL_EXCHANGE, logging, environment, logger);
    (void)resources, (void)visible;
    return WMR_HAS_ME ? s : refused(s, "this FMU has no model exchange.");
}

/* The importer's look at the model after an internal step; it may ask for an early return. */
static int update(wmr_instance *s, double time)
{
    const fmi3IntermediateUpdateCallback callback = (fmi3IntermediateUpdateCallback)s->update;
    fmi3Boolean requested = fmi3False;
    fmi3Float64 until = time;
    const double now = s->state.values[0];
    s->state.values[0] = time;
    s->state.stale = 1;
    s->state.mode = WMR_IN_UPDATE;
    callback(s->environment, time, fmi3False, fmi3True, fmi3True, s->early_return != 0, &requested,
             &until);
    s->state.mode = WMR_IN_STEP;
    s->state.values[0] = now;
    return s->early_return && requested && !(until > time);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t count,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback callback)
{
    wmr_instance *s = made(name, token, WMR_CO_SIMULATION, logging, environment, logger);
    (void)resources, (void)visible, (void)required, (void)count;
    if (s && event_mode) {
        return refused(s, "this FMU has no event mode in co-simulation.");
    }
    if (s && callback) {
        s->update = (void (*)(void))callback;
        s->pause = update;
        s->early_return = early_return;
    }
    return s;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3ClockUpdateCallback clock_update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)resources, (void)visible, (void)clock_update, (void)lock, (void)unlock;
    return refused(made(name, token, WMR_CO_SIMULATION, logging, environment, logger),
                   "this FMU has no scheduled execution.");
}

void fmi3FreeInstance(fmi3Instance instance)
{
    wmr_free((wmr_instance *)instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop)
{
    wmr_instance *s = wmr_legal(instance, &ENTER_INIT);
    if (!s || wmr_setup(s, start, has_stop, stop, has_tolerance, tolerance) != WMR_OK) {
        return fmi3Error;
    }
    s->state.mode = WMR_IN_INIT;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    wmr_instance *s = wmr_legal(instance, &EXIT_INIT);
    return s ? status_of(wmr_leave_init(s)) : fmi3Error;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    wmr_instance *s = wmr_legal(instance, &TERMINATE);
    if (s) {
        s->state.mode = WMR_IN_STOPPED;
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    wmr_instance *s = wmr_legal(instance, &RESET);
    if (s) {
        wmr_reset(s);
    }
    return s ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    wmr_instance *s = wmr_legal(instance, &STATE);
    return s ? status_of(wmr_snapshot_take(s, state)) : fmi3Error;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    wmr_instance *s = wmr_legal(instance, &STATE);
    return s ? status_of(wmr_snapshot_put(s, state)) : fmi3Error;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    wmr_instance *s = wmr_legal(instance, &STATE);
    return s ? status_of(wmr_snapshot_free(s, state)) : fmi3Error;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    wmr_instance *s = wmr_legal(instance, &STATE);
    return s ? status_of(wmr_snapshot_size(s, state, size)) : fmi3Error;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size)
{
    wmr_instance *s = wmr_legal(instance, &STATE);
    return s ? status_of(wmr_snapshot_write(s, state, bytes, size)) : fmi3Error;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state)
{
    wmr_instance *s = wmr_legal(instance, &STATE);
    return s ? status_of(wmr_snapshot_read(s, bytes, size, state)) : fmi3Error;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t nu, const fmi3ValueReference knowns[], size_t nk,
                                        const fmi3Float64 seed[], size_t ns,
                                        fmi3Float64 sensitivity[], size_t nd)
{
    wmr_instance *s = wmr_legal(instance, &DERIVE);
    return s ? status_of(wmr_forward(s, unknowns, nu, knowns, nk, seed, ns, sensitivity, nd))
             : fmi3Error;
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t nu, const fmi3ValueReference knowns[], size_t nk,
                                    const fmi3Float64 seed[], size_t ns, fmi3Float64 sensitivity[],
                                    size_t nd)
{
    wmr_instance *s = wmr_legal(instance, &DERIVE);
    return s ? status_of(wmr_reverse(s, unknowns, nu, knowns, nk, seed, ns, sensitivity, nd))
             : fmi3Error;
}

/* FMI 2.0: each function checks whether it may be called and hands over to the instance. */
#include "fmi2Functions.h"

#include <string.h>

#include "calls.h"
#include "derivatives.h"
#include "snapshot.h"
#include "values.h"

static const wmr_call SET_DEBUG_LOGGING = {"fmi2SetDebugLogging", WMR_ANY_MODE};
static const wmr_call SETUP_EXPERIMENT = {"fmi2SetupExperiment", WMR_IN_START};
static const wmr_call ENTER_INIT = {"fmi2EnterInitializationMode", WMR_IN_START};
static const wmr_call EXIT_INIT = {"fmi2ExitInitializationMode", WMR_IN_INIT};
static const wmr_call TERMINATE = {"fmi2Terminate", WMR_RUNNING_MODES};
static const wmr_call RESET = {"fmi2Reset", WMR_ANY_MODE};
static const wmr_call GET = {"fmi2Get", WMR_ANY_MODE};
static const wmr_call SET = {"fmi2Set", WMR_ANY_MODE & ~WMR_IN_STOPPED};
static const wmr_call STATE = {"a function for FMU states", WMR_ANY_MODE};
static const wmr_call DERIVE = {"fmi2GetDirectionalDerivative",
                                WMR_RUNNING_MODES | WMR_SOLVING_MODES};

static void log_message(wmr_instance *s, wmr_status status, const char *category, const char *text)
{
    const fmi2CallbackLogger logger = (fmi2CallbackLogger)s->callback;
    if (logger) {
        logger(s->environment, s->name, (fmi2Status)status, category, text);
    }
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String categories[])
{
    wmr_instance *s = wmr_legal(c, &SET_DEBUG_LOGGING);
    return s ? status_of(wmr_set_logging(s, on, count, categories)) : fmi2Error;
}

static int acceptable(wmr_instance *s, fmi2String guid, fmi2Type type)
{
    if (!guid || strcmp(guid, WMR_TOKEN) != 0) {
        wmr_say(s, WMR_ERROR, "the GUID is not that of this FMU (" WMR_TOKEN ").");
        return 0;
    }
    if (type != fmi2CoSimulation && !(WMR_HAS_ME && type == fmi2ModelExchange)) {
        wmr_say(s, WMR_ERROR, "this FMU has no such interface.");
        return 0;
    }
    return 1;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)resources, (void)visible;
    wmr_instance *s =
        wmr_create(name, type == fmi2ModelExchange ? WMR_MODEL_EXCHANGE : WMR_CO_SIMULATION);
    if (!s) {
        return NULL;
    }
    s->log = log_message;
    s->callback = functions ? (void (*)(void))functions->logger : NULL;
    s->environment = functions ? functions->componentEnvironment : NULL;
    wmr_set_logging(s, logging, 0, NULL);
    if (!name || !*name) {
        wmr_say(s, WMR_ERROR, "the instance needs a name.");
    }
    if (!name || !*name || !acceptable(s, guid, type)) {
        wmr_free(s);
        return NULL;
    }
    return s;
}

void fmi2FreeInstance(fmi2Component c)
{
    wmr_free((wmr_instance *)c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    wmr_instance *s = wmr_legal(c, &SETUP_EXPERIMENT);
    return s ? status_of(wmr_setup(s, start, has_stop, stop, has_tolerance, tolerance)) : fmi2Error;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    wmr_instance *s = wmr_legal(c, &ENTER_INIT);
    if (!s) {
        return fmi2Error;
    }
    if (!s->state.experiment) {
        return status_of(wmr_say(s, WMR_ERROR, "fmi2SetupExperiment must come first."));
    }
    s->state.mode = WMR_IN_INIT;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    wmr_instance *s = wmr_legal(c, &EXIT_INIT);
    return s ? status_of(wmr_leave_init(s)) : fmi2Error;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    wmr_instance *s = wmr_legal(c, &TERMINATE);
    if (s) {
        s->state.mode = WMR_IN_STOPPED;
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    wmr_instance *s = wmr_legal(c, &RESET);
    if (s) {
        wmr_reset(s);
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    wmr_instance *s = wmr_legal(c, &GET);
    return s ? status_of(wmr_get(s, WMR_REAL, vr, nvr, value, nvr)) : fmi2Error;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[])
{
    wmr_instance *s = wmr_legal(c, &SET);
    return s ? status_of(wmr_set(s, WMR_REAL, vr, nvr, value, nvr)) : fmi2Error;
}

/* Integers are kept as doubles, which hold every 32-bit integer. */
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Integer value[])
{
    wmr_instance *s = wmr_legal(c, &GET);
    wmr_status status = s ? WMR_OK : WMR_ERROR;
    if (s && nvr && !value) {
        return status_of(wmr_say(s, WMR_ERROR, "the array of values is missing."));
    }
    for (size_t i = 0; i < nvr && status == WMR_OK; ++i) {
        double number = 0.0;
        status = wmr_get(s, WMR_INTEGER, vr ? vr + i : NULL, 1, &number, 1);
        value[i] = number < 2147483647.0 ? (fmi2Integer)number : 2147483647;
    }
    return status_of(status);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[])
{
    wmr_instance *s = wmr_legal(c, &SET);
    wmr_status status = s ? WMR_OK : WMR_ERROR;
    if (s && nvr && !value) {
        return status_of(wmr_say(s, WMR_ERROR, "the array of values is missing."));
    }
    wmr_status worst = status;
    for (size_t i = 0; i < nvr && status <= WMR_WARNING; ++i) {
        const double number = value[i];
        status = wmr_set(s, WMR_INTEGER, vr ? vr + i : NULL, 1, &number, 1);
        worst = status > worst ? status : worst;
    }
    return status_of(worst);
}

/* No variable is a Boolean or a string. */
static fmi2Status none_of_them(fmi2Component c, const wmr_call *call, size_t nvr)
{
    wmr_instance *s = wmr_legal(c, call);
    if (s && nvr) {
        return status_of(wmr_say(s, WMR_ERROR, "this FMU has no variable of this type."));
    }
    return s ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Boolean value[])
{
    (void)vr, (void)value;
    return none_of_them(c, &GET, nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[])
{
    (void)vr, (void)value;
    return none_of_them(c, &GET, nvr);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[])
{
    (void)vr, (void)value;
    return none_of_them(c, &SET, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[])
{
    (void)vr, (void)value;
    return none_of_them(c, &SET, nvr);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    wmr_instance *s = wmr_legal(c, &STATE);
    return s ? status_of(wmr_snapshot_take(s, state)) : fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    wmr_instance *s = wmr_legal(c, &STATE);
    return s ? status_of(wmr_snapshot_put(s, state)) : fmi2Error;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    wmr_instance *s = wmr_legal(c, &STATE);
    return s ? status_of(wmr_snapshot_free(s, state)) : fmi2Error;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    wmr_instance *s = wmr_legal(c, &STATE);
    return s ? status_of(wmr_snapshot_size(s, state, size)) : fmi2Error;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    wmr_instance *s = wmr_legal(c, &STATE);
    return s ? status_of(wmr_snapshot_write(s, state, bytes, size)) : fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    wmr_instance *s = wmr_legal(c, &STATE);
    return s ? status_of(wmr_snapshot_read(s, bytes, size, state)) : fmi2Error;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t nu, const fmi2ValueReference known[], size_t nk,
                                        const fmi2Real seed[], fmi2Real sensitivity[])
{
    wmr_instance *s = wmr_legal(c, &DERIVE);
    return s ? status_of(wmr_forward(s, unknown, nu, known, nk, seed, nk, sensitivity, nu))
             : fmi2Error;
}

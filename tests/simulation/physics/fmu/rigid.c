/* The rigid body of an MJCF text as an FMI 2 co-simulation FMU around MuJoCo's library.

   resources/robot.xml is the body, resources/start.txt what a run starts from: r, l [m], theta at the
   start, theta, the number of MuJoCo's state and that state.  Formulas of the outputs are those of
   wmr_ctrl/simulation/physics/rigid.py, written a second time; a communication step is a whole number of
   MuJoCo's steps.  Parameters cannot be changed, states not be taken back. */
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { MOTOR_RIGHT, MOTOR_LEFT, FORCE, MOMENT, INPUTS,
       X = INPUTS, Y, YAW, FORWARD, TURNING, ROLLED, TURNED, WHEEL_RIGHT, WHEEL_LEFT, SLIP_RIGHT,
       SLIP_LEFT, TILT, VALUES };

typedef struct {
    mjModel *model;
    mjData *data;
    int chassis;
    double r, l, theta0, theta, t, value[VALUES];
    const fmi2CallbackFunctions *tell;
} body;

static fmi2Status wrong(const body *b, const char *why)
{
    if (b->tell && b->tell->logger)
        b->tell->logger(b->tell->componentEnvironment, "rigid", fmi2Error, "error", "%s", why);
    return fmi2Error;
}

static void look(body *b)
{
    const double *q = b->data->qpos, *v = b->data->qvel;
    const double w = q[3], qx = q[4], qy = q[5], qz = q[6], right = v[6], left = v[7];
    const double ahead0 = 2 * (qx * qy - w * qz), ahead1 = 1 - 2 * (qx * qx + qz * qz);
    const double up0 = 2 * (qx * qz - w * qy), up1 = 2 * (qy * qz + w * qx);
    const double up2 = 1 - 2 * (qx * qx + qy * qy);
    const double turn = 2 * 3.141592653589793;
    double *o = b->value, v1, omega;
    b->theta += remainder(atan2(-ahead0, ahead1) - b->theta, turn);
    v1 = cos(b->theta) * v[1] - sin(b->theta) * v[0];
    omega = up0 * v[3] + up1 * v[4] + up2 * v[5];
    o[X] = q[0], o[Y] = q[1], o[YAW] = b->theta, o[FORWARD] = v1, o[TURNING] = omega;
    o[ROLLED] = b->r * (q[7] + q[8]) / 2;
    o[TURNED] = b->theta0 + b->r * (q[7] - q[8]) / (2 * b->l);
    o[WHEEL_RIGHT] = right, o[WHEEL_LEFT] = left;
    o[SLIP_RIGHT] = b->r * right - v1 - b->l * omega;
    o[SLIP_LEFT] = b->r * left - v1 + b->l * omega;
    o[TILT] = acos(fmax(-1.0, fmin(1.0, up2)));
}

static FILE *resource(const char *location, const char *name, char path[4096])
{
    const char *folder = strncmp(location, "file:", 5) ? location : location + 5;
    while (folder[0] == '/' && folder[1] == '/')
        folder++;
    snprintf(path, 4096, "%s/%s", folder, name);
    return fopen(path, "r");
}

static int start(body *b, FILE *file)
{
    int n, i, ok = fscanf(file, "%lf %lf %lf %lf %d", &b->r, &b->l, &b->theta0, &b->theta, &n) == 5;
    double *state = ok ? malloc((size_t)n * sizeof *state) : NULL;
    ok = ok && state && n == mj_stateSize(b->model, mjSTATE_INTEGRATION);
    for (i = 0; ok && i < n; i++)
        ok = fscanf(file, "%lf", state + i) == 1;
    if (ok) {
        mj_setState(b->model, b->data, state, mjSTATE_INTEGRATION);
        mj_forward(b->model, b->data);
        mj_setState(b->model, b->data, state, mjSTATE_INTEGRATION);
        look(b);
    }
    free(state);
    return ok;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c)
{
    body *b = c;
    if (b && b->data)
        mj_deleteData(b->data);
    if (b && b->model)
        mj_deleteModel(b->model);
    free(b);
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
    fmi2String location, const fmi2CallbackFunctions *tell, fmi2Boolean visible, fmi2Boolean logging)
{
    char path[4096], why[500] = "resources/robot.xml or start.txt is missing or does not fit";
    body *b = calloc(1, sizeof *b);
    FILE *file;
    (void)name, (void)type, (void)guid, (void)visible, (void)logging;
    if (!b)
        return NULL;
    b->tell = tell;
    if ((file = resource(location, "robot.xml", path))) {
        fclose(file);
        b->model = mj_loadXML(path, NULL, why, sizeof why);
    }
    if (b->model && (b->data = mj_makeData(b->model)) && (file = resource(location, "start.txt", path))) {
        const int ok = start(b, file);
        fclose(file);
        b->chassis = mj_name2id(b->model, mjOBJ_BODY, "chassis");
        if (ok)
            return b;
    }
    wrong(b, why);
    fmi2FreeInstance(b);
    return NULL;
}

FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean keep)
{
    body *b = c;
    const double dt = b->model->opt.timestep, *u = b->value;
    const long n = lround(h / dt);
    long i;
    (void)keep;
    if (n < 1 || fabs((double)n * dt - h) > 1e-9 || fabs(t - b->t) > 1e-6)
        return wrong(b, "a step must begin at the time reached, and be whole steps of MuJoCo");
    for (i = 0; i < n; i++) {
        double *push = b->data->xfrc_applied + 6 * b->chassis;
        b->data->ctrl[0] = u[MOTOR_RIGHT], b->data->ctrl[1] = u[MOTOR_LEFT];
        push[0] = -sin(b->theta) * u[FORCE], push[1] = cos(b->theta) * u[FORCE], push[5] = u[MOMENT];
        mj_step(b->model, b->data);
        look(b);
    }
    b->t = t + h;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    size_t i;
    for (i = 0; i < n; i++)
        if (r[i] >= VALUES)
            return wrong(c, "no such variable");
        else
            v[i] = ((body *)c)->value[r[i]];
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[])
{
    size_t i;
    for (i = 0; i < n; i++)
        if (r[i] >= INPUTS || !isfinite(v[i]))
            return wrong(c, "only inputs can be set, to finite numbers");
        else
            ((body *)c)->value[r[i]] = v[i];
    return fmi2OK;
}

FMI2_Export const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2_Export const char *fmi2GetVersion(void) { return "2.0"; }

/* What has nothing to do here, and what is not offered: the standard's prototypes name the rest. */
#define PLAIN(name, status, ...) \
    FMI2_Export fmi2Status name(__VA_ARGS__) { return status; }
#define ONE fmi2Component c
#define REFS fmi2Component c, const fmi2ValueReference r[], size_t n
PLAIN(fmi2SetDebugLogging, fmi2OK, ONE, fmi2Boolean on, size_t n, const fmi2String s[])
PLAIN(fmi2SetupExperiment, fmi2OK, ONE, fmi2Boolean b, fmi2Real e, fmi2Real t, fmi2Boolean d, fmi2Real s)
PLAIN(fmi2EnterInitializationMode, fmi2OK, ONE)
PLAIN(fmi2ExitInitializationMode, fmi2OK, ONE)
PLAIN(fmi2Terminate, fmi2OK, ONE)
PLAIN(fmi2Reset, fmi2Error, ONE)
PLAIN(fmi2GetInteger, n ? fmi2Error : fmi2OK, REFS, fmi2Integer v[])
PLAIN(fmi2GetBoolean, n ? fmi2Error : fmi2OK, REFS, fmi2Boolean v[])
PLAIN(fmi2GetString, n ? fmi2Error : fmi2OK, REFS, fmi2String v[])
PLAIN(fmi2SetInteger, n ? fmi2Error : fmi2OK, REFS, const fmi2Integer v[])
PLAIN(fmi2SetBoolean, n ? fmi2Error : fmi2OK, REFS, const fmi2Boolean v[])
PLAIN(fmi2SetString, n ? fmi2Error : fmi2OK, REFS, const fmi2String v[])
PLAIN(fmi2GetFMUstate, fmi2Error, ONE, fmi2FMUstate *s)
PLAIN(fmi2SetFMUstate, fmi2Error, ONE, fmi2FMUstate s)
PLAIN(fmi2FreeFMUstate, fmi2Error, ONE, fmi2FMUstate *s)
PLAIN(fmi2SerializedFMUstateSize, fmi2Error, ONE, fmi2FMUstate s, size_t *n)
PLAIN(fmi2SerializeFMUstate, fmi2Error, ONE, fmi2FMUstate s, fmi2Byte b[], size_t n)
PLAIN(fmi2DeSerializeFMUstate, fmi2Error, ONE, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
PLAIN(fmi2GetDirectionalDerivative, fmi2Error, ONE, const fmi2ValueReference z[], size_t m,
      const fmi2ValueReference v[], size_t n, const fmi2Real d[], fmi2Real out[])
PLAIN(fmi2SetRealInputDerivatives, fmi2Error, REFS, const fmi2Integer o[], const fmi2Real v[])
PLAIN(fmi2GetRealOutputDerivatives, fmi2Error, REFS, const fmi2Integer o[], fmi2Real v[])
PLAIN(fmi2CancelStep, fmi2Error, ONE)
PLAIN(fmi2GetStatus, fmi2Discard, ONE, const fmi2StatusKind k, fmi2Status *s)
PLAIN(fmi2GetRealStatus, fmi2Discard, ONE, const fmi2StatusKind k, fmi2Real *v)
PLAIN(fmi2GetIntegerStatus, fmi2Discard, ONE, const fmi2StatusKind k, fmi2Integer *v)
PLAIN(fmi2GetBooleanStatus, fmi2Discard, ONE, const fmi2StatusKind k, fmi2Boolean *v)
PLAIN(fmi2GetStringStatus, fmi2Discard, ONE, const fmi2StatusKind k, fmi2String *v)

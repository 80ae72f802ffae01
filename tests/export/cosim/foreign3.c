/* Somebody else's plant by FMI 3.0: a differential drive whose mass is in g, with numbers of several
   types and an array.  From 0.5 s on it can tell a time that it did not reach (mode 1), warn (2), or
   print (3).  With a clock in its description it wants event mode. */
#include "fmi3Functions.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RIGHT, LEFT, X, Y, YAW, V, W, GRAMS, FIXED, MODE, COUNT, ENABLE = 20, STEPS, SHARE, TWIST,
       PUSH, NAME };
typedef struct {
    double v[COUNT], push[2];
    fmi3Boolean enable;
    fmi3Int8 steps;
    fmi3Float32 share;
    char name[16];
    fmi3InstanceEnvironment owner;
    fmi3LogMessageCallback tell;
} Robot;

const char *fmi3GetVersion(void) { return "3.0"; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
    fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
    const fmi3ValueReference needed[], size_t count, fmi3InstanceEnvironment owner,
    fmi3LogMessageCallback tell, fmi3IntermediateUpdateCallback update) {
    if (strcmp(token, "clocked") == 0 && !events) {
        tell(owner, fmi3Error, "logStatusError", "only with event mode");
        return 0;
    }
    Robot *robot = calloc(1, sizeof *robot);
    robot->owner = owner, robot->tell = tell;
    robot->v[X] = robot->v[Y] = -0.5, robot->v[YAW] = -0.7 + acos(0), robot->v[GRAMS] = 50e3;
    robot->enable = 1, robot->steps = 1, robot->share = 1;
    return robot;
}
void fmi3FreeInstance(fmi3Instance instance) { free(instance); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean known,
    fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean ends, fmi3Float64 stop) { return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance instance) { return fmi3OK; }
static double *numbers(Robot *robot, fmi3ValueReference ref) {
    return ref == TWIST ? robot->v + V : ref == PUSH ? robot->push : robot->v + ref;
}
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
    fmi3Float64 values[], size_t size) {
    for (size_t i = 0; i < count; values += refs[i] < COUNT ? 1 : 2, i++)
        memcpy(values, numbers(instance, refs[i]), (refs[i] < COUNT ? 1 : 2) * sizeof *values);
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
    const fmi3Float64 values[], size_t size) {
    for (size_t i = 0; i < count; values += refs[i] < COUNT ? 1 : 2, i++)
        memcpy(numbers(instance, refs[i]), values, (refs[i] < COUNT ? 1 : 2) * sizeof *values);
    return fmi3OK;
}
#define ONE(type, field)                                                                          \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,    \
        fmi3##type values[], size_t size) { return *values = ((Robot *)instance)->field, fmi3OK; } \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,    \
        const fmi3##type values[], size_t size) { return ((Robot *)instance)->field = *values, fmi3OK; }
ONE(Boolean, enable)
ONE(Int8, steps)
ONE(Float32, share)
fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
    const fmi3String values[], size_t size) {
    strncpy(((Robot *)instance)->name, *values, 15);
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep,
    fmi3Boolean *event, fmi3Boolean *stop, fmi3Boolean *early, fmi3Float64 *reached) {
    Robot *robot = instance;
    double *v = robot->v, m = v[GRAMS] / 1000, h = 1e-5 * robot->steps;
    double scale = strcmp(robot->name, "still") && robot->enable ? robot->share : 0;
    int mode = time > 0.495 ? (int)v[MODE] : 0;
    *event = *stop = *early = 0;
    for (int n = (int)(step / h + 0.5); n > 0; n--) {
        double force = scale * (v[RIGHT] + v[LEFT]) / 0.1 + robot->push[1];
        v[X] += h * v[V] * cos(v[YAW]), v[Y] += h * v[V] * sin(v[YAW]), v[YAW] += h * v[W];
        v[V] += h * (force - 0.08 * m * 9.81 * tanh(v[V] / 0.01)) / m;
        v[W] += h * scale * 2.5 * (v[RIGHT] - v[LEFT]) / 5.4;
    }
    *reached = mode == 1 ? time + step / 2 : time + step;
    if (mode == 3) printf("still driving\n");
    if (mode != 2) return fmi3OK;
    robot->tell(robot->owner, fmi3Warning, "logStatusWarning", "beyond the range of the tyres");
    return fmi3Warning;
}

/* Somebody else's plant by FMI 3.0: a differential drive whose mass is in g.
   It can tell a time that it did not reach (mode 1), or warn (mode 2), from 0.5 s on. */
#include "fmi3Functions.h"
#include <math.h>
#include <stdlib.h>

enum { RIGHT, LEFT, X, Y, YAW, V, W, GRAMS, FIXED, MODE, COUNT };
typedef struct {
    double v[COUNT];
    fmi3InstanceEnvironment owner;
    fmi3LogMessageCallback tell;
} Robot;

const char *fmi3GetVersion(void) { return "3.0"; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
    fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
    const fmi3ValueReference needed[], size_t count, fmi3InstanceEnvironment owner,
    fmi3LogMessageCallback tell, fmi3IntermediateUpdateCallback update) {
    Robot *robot = calloc(1, sizeof *robot);
    robot->owner = owner, robot->tell = tell;
    robot->v[X] = robot->v[Y] = -0.5, robot->v[YAW] = -0.7 + acos(0), robot->v[GRAMS] = 50e3;
    return robot;
}
void fmi3FreeInstance(fmi3Instance instance) { free(instance); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean known,
    fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean ends, fmi3Float64 stop) { return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance instance) { return fmi3OK; }
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
    fmi3Float64 values[], size_t size) {
    for (size_t i = 0; i < count; i++) values[i] = ((Robot *)instance)->v[refs[i]];
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
    const fmi3Float64 values[], size_t size) {
    for (size_t i = 0; i < count; i++) ((Robot *)instance)->v[refs[i]] = values[i];
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean keep,
    fmi3Boolean *event, fmi3Boolean *stop, fmi3Boolean *early, fmi3Float64 *reached) {
    Robot *robot = instance;
    double *v = robot->v, m = v[GRAMS] / 1000, h = 1e-5;
    int mode = time > 0.495 ? (int)v[MODE] : 0;
    *event = *stop = *early = 0;
    if (mode == 1) step /= 2;
    for (int n = (int)(step / h + 0.5); n > 0; n--) {
        double push = (v[RIGHT] + v[LEFT]) / 0.1 - 0.08 * m * 9.81 * tanh(v[V] / 0.01);
        v[X] += h * v[V] * cos(v[YAW]), v[Y] += h * v[V] * sin(v[YAW]), v[YAW] += h * v[W];
        v[V] += h * push / m, v[W] += h * 2.5 * (v[RIGHT] - v[LEFT]) / 5.4;
    }
    *reached = time + step;
    if (mode != 2) return fmi3OK;
    robot->tell(robot->owner, fmi3Warning, "logStatusWarning", "beyond the range of the tyres");
    return fmi3Warning;
}

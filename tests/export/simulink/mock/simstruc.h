/* Text of this project, no header of The MathWorks: it mimics the macros that generated S-functions
   use, so that they can be compiled and called without Simulink.  What the real ones do beyond that
   (data types, contiguity, sample-time tables) is not here. */
#ifndef MOCK_SIMSTRUC_H
#define MOCK_SIMSTRUC_H

#include <stddef.h>

typedef double real_T;
typedef int int_T;

#define MOCK_PORTS 64
#define MOCK_NUMBERS 512
#define SS_DOUBLE 0
#define SS_OPTION_EXCEPTION_FREE_CODE 1
#define SS_OPTION_WORKS_WITH_CODE_REUSE 2
#define SS_DWORK_USED_AS_DWORK 0
#define SS_DWORK_USED_AS_DSTATE 1
#define USE_DEFAULT_SIM_STATE 1
#define USE_DEFAULT_OPERATING_POINT 1

typedef struct {
    const real_T *numbers;
    size_t count;
    int complex, text;
} mxArray;

#define mxIsDouble(a) (!(a)->text)
#define mxIsComplex(a) ((a)->complex)
#define mxIsSparse(a) ((void)(a), 0)
#define mxGetNumberOfElements(a) ((a)->count)
#define mxGetPr(a) ((a)->numbers)

typedef struct {
    int_T parameters, given, inputs, outputs, works, times, options, compliance, many;
    int_T input_width[MOCK_PORTS], output_width[MOCK_PORTS], feeds[MOCK_PORTS];
    int_T work_width[MOCK_PORTS], work_use[MOCK_PORTS], tunable[MOCK_PORTS];
    const char *work_name[MOCK_PORTS];
    mxArray parameter[MOCK_PORTS];
    real_T input[MOCK_PORTS][16], output[MOCK_PORTS][16], work[MOCK_PORTS][MOCK_NUMBERS];
    real_T period, offset;
    const char *error;
} SimStruct;

#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) ((S)->given)
#define ssGetSFcnParam(S, i) (&(S)->parameter[i])
#define ssSetSFcnParamTunable(S, i, yes) ((S)->tunable[i] = (yes))
#define ssSetNumContStates(S, n) ((void)(n))
#define ssSetNumDiscStates(S, n) ((void)(n))
#define ssSetNumInputPorts(S, n) ((n) <= MOCK_PORTS && ((S)->inputs = (n), 1))
#define ssSetNumOutputPorts(S, n) ((n) <= MOCK_PORTS && ((S)->outputs = (n), 1))
#define ssSetInputPortWidth(S, i, n) ((S)->input_width[i] = (n))
#define ssSetOutputPortWidth(S, i, n) ((S)->output_width[i] = (n))
#define ssSetInputPortRequiredContiguous(S, i, yes) ((void)(yes))
#define ssSetInputPortDirectFeedThrough(S, i, yes) ((S)->feeds[i] = (yes))
#define ssSetNumSampleTimes(S, n) ((S)->times = (n))
#define ssSetNumDWork(S, n) ((S)->works = (n))
#define ssSetDWorkWidth(S, i, n) ((S)->work_width[i] = (n))
#define ssSetDWorkDataType(S, i, type) ((void)(type))
#define ssSetDWorkName(S, i, name) ((S)->work_name[i] = (name))
#define ssSetDWorkUsageType(S, i, use) ((S)->work_use[i] = (use))
#ifdef MOCK_OLD
#define ssSetSimStateCompliance(S, how) ((S)->compliance = (how))
#else
#define ssSetOperatingPointCompliance(S, how) ((S)->compliance = (how))
#endif
#define ssSupportsMultipleExecInstances(S, yes) ((S)->many = (yes))
#define ssSetOptions(S, flags) ((S)->options = (flags))
#define ssSetSampleTime(S, i, period_) ((S)->period = (period_))
#define ssSetOffsetTime(S, i, offset_) ((S)->offset = (offset_))
#define ssGetDWork(S, i) ((void *)(S)->work[i])
#define ssGetInputPortSignal(S, i) ((const void *)(S)->input[i])
#define ssGetOutputPortSignal(S, i) ((void *)(S)->output[i])
#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssGetErrorStatus(S) ((S)->error)

#endif

/* States of an instance in which each function of the standard may be called, as data. */
#ifndef WMR_CALLS_H
#define WMR_CALLS_H

#include "instance.h"

#define WMR_ANY_MODE \
    (WMR_IN_START | WMR_IN_INIT | WMR_IN_STEP | WMR_IN_EVENT | WMR_IN_CONTINUOUS | WMR_IN_STOPPED)
#define WMR_RUNNING_MODES (WMR_IN_STEP | WMR_IN_EVENT | WMR_IN_CONTINUOUS)
#define WMR_SOLVING_MODES (WMR_IN_INIT | WMR_IN_EVENT | WMR_IN_CONTINUOUS | WMR_IN_STOPPED)

/* A function, and the modes in which it is legal. */
typedef struct {
    const char *name;
    int modes;
} wmr_call;

/* The instance behind a handle if `call` is legal now; else NULL, and the importer was told. */
static inline wmr_instance *wmr_legal(void *handle, const wmr_call *call)
{
    wmr_instance *s = (wmr_instance *)handle;
    if (!wmr_is_instance(s)) {
        return NULL;
    }
    if (!(call->modes & s->state.mode)) {
        wmr_say(s, WMR_ERROR, "%s is not allowed in this state.", call->name);
        return NULL;
    }
    return s;
}

/* Our status as the status of the included standard; the values are the same. */
#ifdef fmi2Functions_h
static inline fmi2Status status_of(wmr_status status) { return (fmi2Status)status; }
#else
static inline fmi3Status status_of(wmr_status status) { return (fmi3Status)status; }
#endif

#endif

/* One instance of the model in this FMU, whichever FMI version speaks to it.  All that a
   simulation changes is plain data in wmr_state; pointers and handles live outside of it, so that
   a state can be copied, saved and given to another process. */
#ifndef WMR_INSTANCE_H
#define WMR_INSTANCE_H

#include <stddef.h>
#include <stdint.h>

#include "kind.h"
#include "variables.h"

/* The numbers are those of fmi2Status and fmi3Status. */
typedef enum { WMR_OK, WMR_WARNING, WMR_DISCARD, WMR_ERROR } wmr_status;

typedef enum { WMR_CO_SIMULATION = 1, WMR_MODEL_EXCHANGE } wmr_interface;

/* States of the standards' state machines, as bits. */
enum {
    WMR_IN_START = 1,       /* instantiated */
    WMR_IN_INIT = 2,        /* initialization mode */
    WMR_IN_STEP = 4,        /* co-simulation, between steps */
    WMR_IN_EVENT = 8,       /* model exchange, event mode */
    WMR_IN_CONTINUOUS = 16, /* model exchange, continuous-time mode */
    WMR_IN_STOPPED = 32,    /* terminated */
    WMR_IN_UPDATE = 64      /* inside the importer's intermediate update */
};

/* Plain data: everything that a simulation changes. */
typedef struct {
    double values[WMR_ROWS];
    double start_time, stop_time; /* stop_time: INFINITY where none was given */
    int32_t mode, interface;
    int32_t experiment; /* 1 once start and stop time are known */
    int32_t stale;      /* 1: outputs do not fit the other values */
    int32_t finished;   /* 1: the model asks for the end of the simulation */
    int32_t unused;
    wmr_memory memory;
} wmr_state;

typedef struct wmr_instance wmr_instance;

/* Hands a message to the importer; set by fmi2.c or fmi3.c. */
typedef void wmr_logger(wmr_instance *s, wmr_status status, const char *category, const char *text);

/* Called after each internal step at `time`; returns 1 to end the step there. */
typedef int wmr_pause(wmr_instance *s, double time);

struct wmr_instance {
    uint64_t magic;
    wmr_state state;
    wmr_scratch scratch; /* of the model's kind; rebuilt from the state */
    char name[128];
    void *environment; /* the importer's */
    void (*callback)(void);
    void (*update)(void); /* FMI 3: intermediate update */
    wmr_logger *log;
    wmr_pause *pause; /* NULL: steps are not interrupted */
    int logging, early_return;
};

enum { WMR_LOG_ERROR, WMR_LOG_DISCARD, WMR_LOG_EVENTS, WMR_LOG_COUNT };
extern const char *const WMR_CATEGORIES[WMR_LOG_COUNT];

/* Life of an instance.  wmr_create returns NULL without memory. */
wmr_instance *wmr_create(const char *name, wmr_interface interface);
void wmr_free(wmr_instance *s);
int wmr_is_instance(const wmr_instance *s);
void wmr_reset(wmr_instance *s);
wmr_status wmr_setup(wmr_instance *s, double start, int has_stop, double stop, int has_tolerance,
                     double tolerance);
wmr_status wmr_leave_init(wmr_instance *s);

/* Simulating. */
wmr_status wmr_do_step(wmr_instance *s, double t, double h);
wmr_status wmr_set_time(wmr_instance *s, double t);
wmr_status wmr_set_states(wmr_instance *s, const double *x, size_t nx);
wmr_status wmr_get_states(wmr_instance *s, double *x, size_t nx);
wmr_status wmr_get_rates(wmr_instance *s, double *rates, size_t nx);
wmr_status wmr_get_nominals(wmr_instance *s, double *nominals, size_t nx);
void wmr_refresh(wmr_instance *s);

/* Log a sentence and return `status`. */
wmr_status wmr_say(wmr_instance *s, wmr_status status, const char *format, ...);
wmr_status wmr_set_logging(wmr_instance *s, int on, size_t count, const char *const *categories);

#endif

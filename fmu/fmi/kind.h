/* What a kind of model provides to the instance: continuous (the plant), sampled (laws,
   references), loop (everything in one).  WMR_KIND, generated, picks one of them. */
#ifndef WMR_KIND_H
#define WMR_KIND_H

#include <stdint.h>

#include "kernels.h"
#include "model.h"

#define WMR_CONTINUOUS 1
#define WMR_SAMPLED 2
#define WMR_LOOP 3

#if WMR_KIND == WMR_LOOP
#include "loop.h"

typedef struct {
    int64_t count;       /* control samples taken */
    wmr_loop loop;       /* plain, see loop.h */
    double row[WMR_ROW]; /* the last sample's log */
    double queue[2 * WMR_DELAY_MAX + 1];
} wmr_memory;

typedef struct {
    wmr_settings settings;
    double parameters[(WMR_CHANGES + 1) * WMR_PARAMETERS], start[WMR_STATE + 1];
    int64_t phase_start[WMR_CHANGES + 1];
    uint64_t key[2];
    int32_t cancelled;
} wmr_scratch;

#else
typedef struct {
    int64_t count;            /* samples taken */
    double used[WMR_NX + 1];  /* memory that the last sample started from */
    double first[WMR_NU + 1]; /* inputs of initialisation */
} wmr_memory;

typedef struct {
    double known[WMR_NZ]; /* where the model is linearised */
} wmr_scratch;
#endif

struct wmr_instance;

/* Most internal steps of one communication step. */
#define WMR_MOST_STEPS 1e6

/* Prepare the memory from the values at the start; 0 where they contradict one another. */
int kind_start(struct wmr_instance *s);

/* Rebuild the scratch after a state was put in place. */
void kind_restore(struct wmr_instance *s);

/* Internal steps that a communication step of h from t takes, as a number. */
double kind_steps(const struct wmr_instance *s, double t, double h);

/* Move from t to t + h; returns the time that was reached. */
double kind_advance(struct wmr_instance *s, double t, double h);

/* Make outputs (and rates) fit the other values. */
void kind_refresh(struct wmr_instance *s);

#endif

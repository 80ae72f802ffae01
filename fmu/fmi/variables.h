/* The table of variables: one row per scalar, the same rows for FMI 2 and FMI 3.  The table itself
   is generated (model.c); a value reference is the index of a row. */
#ifndef WMR_VARIABLES_H
#define WMR_VARIABLES_H

#include <stdint.h>

#include "model.h"

typedef enum { WMR_REAL, WMR_INTEGER } wmr_type;

/* What may be done with a variable, and when; see SETTABLE in values.c. */
typedef enum {
    WMR_INDEPENDENT, /* time */
    WMR_INPUT,
    WMR_FIXED,     /* parameter, until initialisation ends */
    WMR_TUNABLE,   /* parameter, between steps too */
    WMR_START,     /* start value, until initialisation ends; moved by the model afterwards */
    WMR_CALCULATED /* read only */
} wmr_role;

typedef struct {
    const char *name;
    unsigned char type, role;
    uint32_t size; /* elements behind this value reference; 0: the row has none of its own */
    double start, min, max;
} wmr_variable;

extern const wmr_variable wmr_variables[WMR_ROWS];

/* Rows of two parameters, the first below the second or, unless they must be apart, equal to it. */
typedef struct {
    int low, high, apart;
} wmr_order;

extern const wmr_order wmr_orders[WMR_ORDERS + 1];

#endif

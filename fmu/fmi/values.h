/* Reading and writing variables by value reference. */
#ifndef WMR_VALUES_H
#define WMR_VALUES_H

#include "instance.h"

/* Numbers behind `count` value references, all of type `type`, into or from `values`, whose
   length must be `length`.  A write happens whole or not at all. */
wmr_status wmr_get(wmr_instance *s, wmr_type type, const uint32_t *refs, size_t count,
                   double *values, size_t length);
wmr_status wmr_set(wmr_instance *s, wmr_type type, const uint32_t *refs, size_t count,
                   const double *values, size_t length);

/* Number of values behind the references, or -1 (told) where one is unknown. */
int64_t wmr_length(wmr_instance *s, wmr_type type, const uint32_t *refs, size_t count);

#endif

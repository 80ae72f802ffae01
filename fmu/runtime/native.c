/* The loop for one robot, with the same entries as dispatch.c has for vectors of them; and the
   kernels themselves, one at a time. */
#define WMR_SET native
#define WMR_LANES 0

#include "library.c"

#include "exports.h"

WMR_EXPORT const char *wmr_set_name(int32_t k)
{
    return k == 0 ? "native" : 0;
}

WMR_EXPORT void wmr_sizes(int32_t k, int64_t sizes[7])
{
    (void)k;
    wmr_set_sizes_native(sizes);
}

WMR_EXPORT int32_t wmr_run(int32_t k, const void *settings, void *findings, void *state)
{
    (void)k;
    return wmr_run_set_native(settings, findings, state);
}

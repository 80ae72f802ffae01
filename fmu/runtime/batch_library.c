/* One translation unit for many runs at once: kernels written for lanes and their loop together. */
#if defined(_WIN32)
#define WMR_EXPORT __declspec(dllexport)
#else
#define WMR_EXPORT __attribute__((visibility("default")))
#endif
#define WMR_KERNEL static

#include "lanes.h"

#include "kernels.c"
#include "noise.c"
#include "batch.c"

WMR_EXPORT int32_t wmr_run_batch(const wmr_batch_settings *s)
{
    return wmr_batch_run(s);
}

/* Lanes, bytes of the settings, findings and sums of each lane, columns of the log: what the caller
   lays its memory out by. */
WMR_EXPORT void wmr_batch_sizes(int64_t sizes[5])
{
    sizes[0] = WMR_LANES;
    sizes[1] = (int64_t)sizeof(wmr_batch_settings);
    sizes[2] = WMR_FINDINGS;
    sizes[3] = WMR_SUMS;
    sizes[4] = WMR_ROW;
}

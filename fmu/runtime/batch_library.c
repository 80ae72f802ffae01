/* One unit for each set of vector instructions: kernels written for lanes and their loop together.
   WMR_SET is the set's name and WMR_LANES its width; batch_dispatch.c chooses between the sets. */
#define WMR_KERNEL static

#define WMR_JOIN_(a, b) a##_##b
#define WMR_JOIN(a, b) WMR_JOIN_(a, b)
#define WMR_OWN(name) WMR_JOIN(name, WMR_SET)

/* All sets stand in one library, each under names of its own. */
#define wmr_philox WMR_OWN(wmr_philox)
#define wmr_uniform_pair WMR_OWN(wmr_uniform_pair)
#define wmr_torque_noise WMR_OWN(wmr_torque_noise)
#define wmr_batch_run WMR_OWN(wmr_batch_run)

#include "arithmetic.h"

#include "kernels.c"
#include "noise.c"
#include "batch.c"

int WMR_OWN(wmr_run_set)(const void *settings)
{
    return wmr_batch_run(settings);
}

void WMR_OWN(wmr_set_sizes)(int64_t sizes[5])
{
    sizes[0] = WMR_LANES;
    sizes[1] = (int64_t)sizeof(wmr_batch_settings);
    sizes[2] = WMR_FINDINGS;
    sizes[3] = WMR_SUMS;
    sizes[4] = WMR_ROW;
}

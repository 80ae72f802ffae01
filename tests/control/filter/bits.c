/* 4000 samples of the command filter, odd ones among them: all that it sends and remembers. */
#include "out.h"
#include "wmr_filter.h"

#include <math.h>
#include <stdint.h>

static uint64_t seed = 1;

static double draw(double size)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return size * ((double)(seed >> 33) / 1073741824.0 - 1.0);
}

static double odd(double usual, int k)
{
    return k == 0 ? (double)NAN : k == 1 ? (double)INFINITY : k == 2 ? -1e30 : usual;
}

int main(void)
{
    static wmr_filter_parameters parameters;
    static wmr_filter_state memory;
    wmr_filter_inputs in;
    wmr_filter_outputs out;
    begin();
    wmr_filter_defaults(&parameters);
    wmr_filter_start(&memory);
    for (int k = 0; k < 4000; ++k) {
        if (k % 5 == 0) {
            in.v_asked[0] = (wmr_real)draw(3.0);
            in.v_asked[1] = (wmr_real)draw(3.0);
        }
        if (k % 97 < 3) in.v_asked[k % 2] = (wmr_real)odd(0.0, k % 97);
#ifdef GOVERNS
        in.v_odometry[0] = (wmr_real)odd(draw(0.3), k % 89);
        in.v_odometry[1] = (wmr_real)draw(0.3);
        in.odometry_age = (wmr_real)odd(k % 7 ? 0.0 : -1.0, k % 83);
#endif
        /* not told at first; then in time, late, early, or back in time */
        in.elapsed = k < 2000 ? 0 : (wmr_real)odd(k % 61 ? (double)parameters.clock_control : draw(0.2), k % 79);
        if (wmr_filter_step(&parameters, &memory, &in, &out)) return 1;
        if (!put(&out, sizeof out) || !put(&memory, sizeof memory)) return 1;
    }
    return !end();
}

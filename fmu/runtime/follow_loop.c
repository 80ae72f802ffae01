/* Speeds of one axis' loop that follow from its commands, for several sets of its parameters, one set a lane.
   The kernel is generated (speed_loop.py). */
#include "lanes.h"

/* Steps of one length (count), each with a command; numbers (NUMBERS, sets). Speed (count, sets) after each step, from
   rest. */
WMR_EXPORT void wmr_follow_loop(int64_t count, int64_t sets, double length, const double *commands,
                                const double *numbers, double *speed)
{
    const wmr_v h = wmr_all(length);
    for (int64_t first = 0; first < sets; first += WMR_LANES) {
        wmr_v x[WMR_STATE], next[WMR_STATE], p[WMR_NUMBERS];
        for (int i = 0; i < WMR_LANES; ++i) {
            const int64_t own = first + i < sets ? first + i : sets - 1;
            for (int j = 0; j < WMR_NUMBERS; ++j) {
                p[j][i] = numbers[j * sets + own];
            }
        }
        for (int j = 0; j < WMR_STATE; ++j) {
            x[j] = wmr_all(0.0);
        }
        for (int64_t n = 0; n < count; ++n) {
            const wmr_v sent = wmr_all(commands[n]);
            wmr_step(x, &sent, &h, p, next);
            memcpy(x, next, sizeof x);
            for (int i = 0; i < WMR_LANES && first + i < sets; ++i) {
                speed[n * sets + first + i] = x[WMR_SPEED][i];
            }
        }
    }
}

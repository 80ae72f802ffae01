/* Speeds of one axis' loop that follow from its commands, for several sets of its parameters, one set a lane.
   The kernel is generated (speed_loop.py). */
#include "lanes.h"

/* Speeds (samples, sets) at times t of which the path (count + 1, sets) of one set is behind by its delay; of_way: means
   since the sample before, the first of which is 0. */
static void sample(int64_t count, int64_t sets, int64_t samples, int of_way, double length,
                   double begin, double delay, const double *t, double *path, double *speed)
{
    double sum = 0.0, before = 0.0;
    for (int64_t n = 0; of_way && n <= count; ++n) {
        sum += path[n * sets];
        path[n * sets] = sum * length;
    }
    for (int64_t k = 0; k < samples; ++k) {
        const double place = (t[k] - delay - begin) / length;
        const int64_t row = (int64_t)place < count - 1 ? (int64_t)place : count - 1;
        const double now = path[row * sets], next = path[(row + 1) * sets];
        const double seen = now + (place - (double)row) * (next - now);
        speed[k * sets] = !of_way ? seen : k ? (seen - before) / (t[k] - t[k - 1]) : 0.0;
        before = seen;
    }
}

/* `count` steps of one length from `begin` on, from rest, each with a command; numbers (NUMBERS, sets), delays (sets).
   `path` (count + 1, sets) holds the speeds after each step, its first row is 0. */
WMR_EXPORT void wmr_follow_loop(int64_t count, int64_t sets, int64_t samples, int32_t of_way,
                                double length, double begin, const double *commands,
                                const double *numbers, const double *delays, const double *t,
                                double *path, double *speed)
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
                path[(n + 1) * sets + first + i] = x[WMR_SPEED][i];
            }
        }
    }
    for (int64_t i = 0; i < sets; ++i) {
        sample(count, sets, samples, of_way, length, begin, delays[i], t, path + i, speed + i);
    }
}

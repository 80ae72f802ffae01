/* Speeds of one axis' loop that follow from its commands, for several sets of its parameters, one set a lane.
   The kernel is generated (speed_loop.py). */
#include "lanes.h"

/* Pieces of `length` (count); commands (count, SENT, delays), of which set k takes column late[k];
   numbers (NUMBERS, sets); state (STATE, sets), before and after; speed (count, sets) after each piece. */
WMR_EXPORT void wmr_follow_loop(int64_t count, int64_t sets, int64_t delays, const double *length,
                                const double *commands, const int32_t *late, const double *numbers,
                                double *state, double *speed)
{
    for (int64_t first = 0; first < sets; first += WMR_LANES) {
        wmr_v x[WMR_STATE], next[WMR_STATE], p[WMR_NUMBERS], u[WMR_SENT];
        int64_t own[WMR_LANES];
        for (int i = 0; i < WMR_LANES; ++i) {
            own[i] = first + i < sets ? first + i : sets - 1;
            for (int j = 0; j < WMR_NUMBERS; ++j) {
                p[j][i] = numbers[j * sets + own[i]];
            }
            for (int j = 0; j < WMR_STATE; ++j) {
                x[j][i] = state[j * sets + own[i]];
            }
        }
        for (int64_t n = 0; n < count; ++n) {
            const double *sent = commands + n * WMR_SENT * delays;
            const wmr_v h = wmr_all(length[n]);
            for (int i = 0; i < WMR_LANES; ++i) {
                for (int j = 0; j < WMR_SENT; ++j) {
                    u[j][i] = sent[j * delays + late[own[i]]];
                }
            }
            wmr_step(x, u, &h, p, next);
            memcpy(x, next, sizeof x);
            for (int i = 0; i < WMR_LANES; ++i) {
                speed[n * sets + own[i]] = x[WMR_SPEED][i];
            }
        }
        for (int i = 0; i < WMR_LANES; ++i) {
            for (int j = 0; j < WMR_STATE; ++j) {
                state[j * sets + own[i]] = x[j][i];
            }
        }
    }
}

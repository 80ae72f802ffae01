/* One case on any platform: a run with a log, then one without; the bits of all that they leave go
   to the standard output.  numbers.h holds the case, library.c the loop.  With lanes the last one
   is shown; the others have seeds of their own, so that branches are mixed. */
#include "numbers.h"
#include "out.h"

#include "library.c"

#define LANE (WMR_WIDTH - 1)

static struct {
    wmr_v parameters[PHASES * WMR_PARAMETERS], start[WMR_STATE], queue[2 * DELAY + 2];
    wmr_v sums[WINDOWS * WMR_WINDOW];
    uint64_t key[2 * WMR_WIDTH];
    double rows[SAMPLES * WMR_ROW];
} memory;

static int show(const double *numbers, size_t count)
{
    return put(numbers, sizeof *numbers * count);
}

static int show_lane(const wmr_v *numbers, size_t count)
{
    int shown = 1;
    for (size_t k = 0; k < count; ++k) {
        const double number = WMR_AT(numbers[k], LANE);
        shown &= show(&number, 1);
    }
    return shown;
}

static void fill(wmr_v *to, const double *from, size_t count)
{
    for (size_t k = 0; k < count; ++k) {
        to[k] = wmr_all(from[k]);
    }
}

int WMR_OWN(wmr_case)(void)
{
    static const volatile int32_t never = 0;
    double *log[WMR_WIDTH] = {0};
    wmr_v findings[WMR_FINDINGS], state[WMR_STATE];
    wmr_settings s = {SAMPLES, PHASES, WINDOWS, PHASE_START, WINDOW, memory.key, &never,
                      memory.parameters, memory.start, memory.queue, memory.sums, log};
    fill(memory.parameters, PARAMETERS, PHASES * WMR_PARAMETERS);
    fill(memory.start, START, WMR_STATE);
    for (int i = 0; i < WMR_WIDTH; ++i) {
        memcpy(memory.key + 2 * (LANE - i), KEYS[i], sizeof KEYS[i]);
    }
    log[LANE] = memory.rows;
    WMR_OWN(wmr_run_set)(&s, findings, state);
    int shown = show(memory.rows, (size_t)WMR_AT(findings[WMR_FOUND_SAMPLES], LANE) * WMR_ROW);
    shown &= show_lane(findings, WMR_FINDINGS) & show_lane(state, WMR_STATE);
    s.log = 0;
    WMR_OWN(wmr_run_set)(&s, findings, state);
    shown &= show_lane(findings, WMR_FINDINGS) & show_lane(state, WMR_STATE);
    return shown & show_lane(memory.sums, WINDOWS * WMR_WINDOW);
}

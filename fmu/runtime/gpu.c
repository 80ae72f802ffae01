/* The loop on a graphics processor: a thread is a robot, from its start to its end.  Compiled at run
   time as CUDA (NVRTC, which has no C library and no headers; gpu_types.h stands for them), without
   fused multiply-add, from the text that is compiled for lanes on a processor.  What a thread
   changes is its own, in memory that the compiler interleaves; what all read is shared.

   WMR_PHASES, WMR_WINDOWS and WMR_QUEUE are those of the batch, WMR_BLOCK is the threads of a block;
   runs have logs with WMR_LOGS. */
#define WMR_LANES 0
#define WMR_KERNEL static
#define WMR_ONE_STATE

/* Blocks that a multiprocessor holds at least: the compiler takes no more registers than leave
   room for them.  Of 1 to 4 blocks of 128 threads, 4 were fastest for prox on an H200, 2 for
   the network.  */
#define WMR_BLOCKS 3

#include "gpu_types.h"
#include "kernels.c"
#include "noise.c"
#include "seed.c"
#include "loop.c"

/* Data that all robots of a launch share.  Rows of parameters (WMR_PHASES times WMR_PARAMETERS) and of
   starts (WMR_STATE) belong to cases; a robot's case is case_of[robot]. */
typedef struct {
    int64_t robots, samples;
    const int64_t *phase_start, *window;
    const volatile int32_t *cancelled;
    const double *parameters, *starts;
    const int32_t *case_of;
    const uint64_t *seeds;
    const double *own_starts; /* or NULL: the first WMR_OWN numbers of each robot's state */
    double *findings, *state, *sums; /* a row a number, a column a robot */
    double *logs; /* with WMR_LOGS: a robot after the other, WMR_ROW numbers a sample */
} wmr_batch;

static void spread(double *to, int64_t robots, int64_t robot, const double *from, int count)
{
    for (int k = 0; k < count; ++k) {
        to[k * robots + robot] = from[k];
    }
}

static void wmr_one_run(const wmr_batch *b, int64_t robot)
{
    const double *row = b->parameters + (int64_t)b->case_of[robot] * (WMR_PHASES * WMR_PARAMETERS);
    double start[WMR_STATE], queue[2 * WMR_QUEUE + 1], sums[WMR_WINDOWS * WMR_WINDOW + 1];
#ifdef WMR_LOGS
    double *log = b->logs + robot * b->samples * WMR_ROW;
#endif
    uint64_t key[2];
    wmr_settings s;
    wmr_loop w;
#ifdef WMR_OWN_PARAMETERS
    double own[WMR_PHASES * WMR_PARAMETERS];
    copy(own, row, WMR_PHASES * WMR_PARAMETERS);
    row = own;
#endif
    copy(start, b->starts + (int64_t)b->case_of[robot] * WMR_STATE, WMR_STATE);
    for (int k = 0; b->own_starts && k < WMR_OWN; ++k) {
        start[k] = b->own_starts[k * b->robots + robot];
    }
    wmr_seed_key(b->seeds[robot], key);
    s.samples = b->samples;
    s.phases = WMR_PHASES;
    s.windows = WMR_WINDOWS;
    s.phase_start = b->phase_start;
    s.window = b->window;
    s.key = key;
    s.cancelled = b->cancelled;
    s.parameters = row;
    s.start = start;
    s.queue = queue;
    s.sums = sums;
#ifdef WMR_LOGS
    s.log = &log;
#else
    s.log = 0;
#endif
    wmr_loop_run(&s, &w);
    spread(b->findings, b->robots, robot, w.findings, WMR_FINDINGS);
    spread(b->state, b->robots, robot, wmr_loop_state(&w), WMR_STATE);
    spread(b->sums, b->robots, robot, sums, WMR_WINDOWS * WMR_WINDOW);
}

extern "C" __global__ void __launch_bounds__(WMR_BLOCK, WMR_BLOCKS) wmr_runs(const wmr_batch *b)
{
    const int64_t robot = (int64_t)blockIdx.x * WMR_BLOCK + threadIdx.x;
    if (robot < b->robots) {
        wmr_one_run(b, robot);
    }
}

/* What a loop over sets or directions of its own has before it: as many lanes as this processor takes at once, and
   the generated kernels, which nothing else calls. */
#ifndef WMR_LANES
#if defined(__AVX512F__)
#define WMR_LANES 8
#elif defined(__AVX__)
#define WMR_LANES 4
#else
#define WMR_LANES 2
#endif
#endif
#define WMR_KERNEL static

#include "export.h"
#include "kernels.inc"

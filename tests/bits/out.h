/* Where the bits go: the standard output; in WebAssembly, which is linked as the page's module is,
   without a C library, a function of the one who runs it. */
#ifndef WMR_OUT_H
#define WMR_OUT_H

#include <stddef.h>

#ifdef __wasm__
#define main __attribute__((export_name("run"))) wmr_run_cases
__attribute__((import_name("put"))) int put(const void *bytes, size_t size);
static inline void begin(void) {}
static inline int end(void) { return 1; }
#else
#include <stdio.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
static inline void begin(void) { _setmode(_fileno(stdout), _O_BINARY); }
#else
static inline void begin(void) {}
#endif
static inline int put(const void *bytes, size_t size)
{
    return fwrite(bytes, 1, size, stdout) == size;
}
static inline int end(void) { return fflush(stdout) == 0; }
#endif

#endif

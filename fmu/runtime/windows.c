/* All that a library for Windows needs of a C library's own objects, so that none is linked: zig
   would compile that of MinGW for a minute. The rest comes from Windows' own C library, which
   starts itself. Compiled only by who links without a C library; it is not among an FMU's sources. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

enum { STANDARD = 2 }; /* what did not fit is counted, and the text always ends */

int DllMain(void *library, unsigned long reason, void *reserved);
int __fpclassify(double value);
int vsnprintf(char *text, size_t size, const char *format, va_list arguments);
int __stdio_common_vsprintf(uint64_t options, char *text, size_t size, const char *format,
                            void *locale, va_list arguments);

unsigned int _tls_index; /* asked for by zig 0.13; no thread has data of its own here */

int DllMain(void *library, unsigned long reason, void *reserved)
{
    (void)library;
    (void)reason;
    (void)reserved;
    return 1;
}

int __fpclassify(double value)
{
    return __builtin_fpclassify(FP_NAN, FP_INFINITE, FP_NORMAL, FP_SUBNORMAL, FP_ZERO, value);
}

int vsnprintf(char *text, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(STANDARD, text, size, format, NULL, arguments);
}

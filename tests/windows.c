/* How a program for Windows starts and prints without the objects of a compiler's C library. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

int main(int count, char **words);
int _configure_narrow_argv(int mode);
int *__p___argc(void);
char ***__p___argv(void);

void __main(void) {} /* called by main(), for constructors of C++ */

void mainCRTStartup(void)
{
    _configure_narrow_argv(1);
    exit(main(*__p___argc(), *__p___argv()));
}

int vfprintf(FILE *stream, const char *format, va_list given)
{
    return __stdio_common_vfprintf(0, stream, format, NULL, given);
}

int fprintf(FILE *stream, const char *format, ...)
{
    va_list given;
    va_start(given, format);
    const int count = vfprintf(stream, format, given);
    va_end(given);
    return count;
}

int printf(const char *format, ...)
{
    va_list given;
    va_start(given, format);
    const int count = vfprintf(stdout, format, given);
    va_end(given);
    return count;
}

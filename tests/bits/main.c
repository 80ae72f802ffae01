/* All cases of a law, one after the other; cases.h lists them. */
#include <stdio.h>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#endif

#include "cases.h"

#define DECLARED(name) int wmr_case_##name(void);
#define SHOWN(name) && wmr_case_##name()
CASES(DECLARED)

int main(void)
{
#if defined(_WIN32)
    _setmode(_fileno(stdout), _O_BINARY);
#endif
    return !(1 CASES(SHOWN) && fflush(stdout) == 0);
}

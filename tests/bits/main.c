/* All cases of a law, one after the other; cases.h lists them. */
#include "cases.h"
#include "out.h"

#define DECLARED(name) int wmr_case_##name(void);
#define SHOWN(name) && wmr_case_##name()
CASES(DECLARED)

int main(void)
{
    begin();
    return !(1 CASES(SHOWN) && end());
}

/* Load the library of an FMI 2.0 FMU, step it, print one variable after each step, exactly.

   cc -I../fmi/headers fmi2_step.c -o fmi2_step -ldl
   ./fmi2_step binaries/linux64/wmr_plant.so "{guid}" input output steps

   `input` is the value reference of an input that is held at 6.0; `output` that of what is shown.
   What the FMU has to say of an error goes to the standard error.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

#if defined(_WIN32)
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

static void *library;

static void *function(const char *name)
{
    void *found = FIND(library, name);
    if (!found) {
        fprintf(stderr, "%s is missing\n", name);
        exit(1);
    }
    return found;
}

static void tell(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                 fmi2String category, fmi2String message, ...)
{
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s, status %d, %s: ", instance, (int)status, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fprintf(stderr, "\n");
}

static int step(fmi2Component c, unsigned int output, int count)
{
    fmi2DoStepTYPE *do_step = (fmi2DoStepTYPE *)function("fmi2DoStep");
    fmi2GetRealTYPE *get = (fmi2GetRealTYPE *)function("fmi2GetReal");
    for (int k = 0; k < count; ++k) {
        double value;
        if (do_step(c, 0.01 * k, 0.01, 1) != fmi2OK || get(c, &output, 1, &value) != fmi2OK) {
            return 1;
        }
        printf("%a\n", value);
    }
    return 0;
}

int main(int count, char **words)
{
    const double held = 6.0;
    const fmi2CallbackFunctions callbacks = {tell, NULL, NULL, NULL, NULL};
    const unsigned int input = count > 3 ? (unsigned int)atoi(words[3]) : 0;
    if (count != 6 || !(library = OPEN(words[1]))) {
        fprintf(stderr, "cannot load the library\n");
        return 1;
    }
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)function("fmi2Instantiate");
    fmi2Component c = instantiate("example", fmi2CoSimulation, words[2], NULL, &callbacks, 0, 0);
    if (!c
        || ((fmi2SetupExperimentTYPE *)function("fmi2SetupExperiment"))(c, 0, 0, 0, 0, 0) != fmi2OK
        || ((fmi2EnterInitializationModeTYPE *)function("fmi2EnterInitializationMode"))(c) != fmi2OK
        || ((fmi2SetRealTYPE *)function("fmi2SetReal"))(c, &input, 1, &held) != fmi2OK
        || ((fmi2ExitInitializationModeTYPE *)function("fmi2ExitInitializationMode"))(c)
               != fmi2OK) {
        return 1;
    }
    const int status = step(c, (unsigned int)atoi(words[4]), atoi(words[5]));
    ((fmi2FreeInstanceTYPE *)function("fmi2FreeInstance"))(c);
    return status;
}

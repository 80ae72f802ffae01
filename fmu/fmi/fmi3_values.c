/* FMI 3.0: reading and writing variables.  They are Float64 and Int64; each other type has its
   functions, which refuse every value reference. */
#include "fmi3Functions.h"

#include "calls.h"
#include "values.h"

static const wmr_call GET = {"fmi3Get", WMR_ANY_MODE | WMR_IN_UPDATE};
static const wmr_call SET = {"fmi3Set", WMR_ANY_MODE & ~WMR_IN_STOPPED};

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                          fmi3Float64 values[], size_t length)
{
    wmr_instance *s = wmr_legal(instance, &GET);
    return s ? status_of(wmr_get(s, WMR_REAL, refs, count, values, length)) : fmi3Error;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                          const fmi3Float64 values[], size_t length)
{
    wmr_instance *s = wmr_legal(instance, &SET);
    return s ? status_of(wmr_set(s, WMR_REAL, refs, count, values, length)) : fmi3Error;
}

/* Integers are kept as doubles: their ranges end below 2^53. */
static wmr_status check_integers(wmr_instance *s, size_t count, const void *values, size_t length)
{
    if (count != length || (count && !values)) {
        return wmr_say(s, WMR_ERROR, "expected %u values but got %u (or no array).",
                       (unsigned)count, (unsigned)length);
    }
    return WMR_OK;
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                        fmi3Int64 values[], size_t length)
{
    wmr_instance *s = wmr_legal(instance, &GET);
    wmr_status status = s ? check_integers(s, count, values, length) : WMR_ERROR;
    for (size_t i = 0; i < count && status == WMR_OK; ++i) {
        double number = 0.0;
        status = wmr_get(s, WMR_INTEGER, refs ? refs + i : NULL, 1, &number, 1);
        values[i] = (fmi3Int64)number;
    }
    return status_of(status);
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                        const fmi3Int64 values[], size_t length)
{
    wmr_instance *s = wmr_legal(instance, &SET);
    wmr_status status = s ? check_integers(s, count, values, length) : WMR_ERROR;
    wmr_status worst = status;
    for (size_t i = 0; i < count && status <= WMR_WARNING; ++i) {
        const double number = (double)values[i];
        status = wmr_set(s, WMR_INTEGER, refs ? refs + i : NULL, 1, &number, 1);
        worst = status > worst ? status : worst;
    }
    return status_of(worst);
}

static fmi3Status none_of_them(fmi3Instance instance, const wmr_call *call, size_t count)
{
    wmr_instance *s = wmr_legal(instance, call);
    if (s && count) {
        return status_of(wmr_say(s, WMR_ERROR, "this FMU has no variable of this type."));
    }
    return s ? fmi3OK : fmi3Error;
}

#define NO_VARIABLES(type)                                                                         \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference refs[], size_t count, \
                             fmi3##type values[], size_t length)                                   \
    {                                                                                              \
        (void)refs, (void)values, (void)length;                                                    \
        return none_of_them(instance, &GET, count);                                                \
    }                                                                                              \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference refs[], size_t count, \
                             const fmi3##type values[], size_t length)                             \
    {                                                                                              \
        (void)refs, (void)values, (void)length;                                                    \
        return none_of_them(instance, &SET, count);                                                \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                         size_t sizes[], fmi3Binary values[], size_t length)
{
    (void)refs, (void)sizes, (void)values, (void)length;
    return none_of_them(instance, &GET, count);
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                         const size_t sizes[], const fmi3Binary values[], size_t length)
{
    (void)refs, (void)sizes, (void)values, (void)length;
    return none_of_them(instance, &SET, count);
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                        fmi3Clock values[])
{
    (void)refs, (void)values;
    return none_of_them(instance, &GET, count);
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                        const fmi3Clock values[])
{
    (void)refs, (void)values;
    return none_of_them(instance, &SET, count);
}

/* FMI 3.0: functions of capabilities that these FMUs do not declare.  They are exported, as the
   standard asks, and refuse. */
#include "fmi3Functions.h"

#include "calls.h"

static const wmr_call NEVER = {"a function of a capability that this FMU does not have", 0};

static fmi3Status refuse(fmi3Instance instance)
{
    wmr_legal(instance, &NEVER);
    return fmi3Error;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return refuse(instance);
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return refuse(instance);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    return refuse(instance);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference ref,
                                               size_t *count)
{
    (void)ref, (void)count;
    return refuse(instance);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elements[], fmi3ValueReference independents[],
                                       size_t of_independents[], fmi3DependencyKind kinds[],
                                       size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)of_independents, (void)kinds,
        (void)count;
    return refuse(instance);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference refs[],
                                  size_t count, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[])
{
    (void)refs, (void)count, (void)intervals, (void)qualifiers;
    return refuse(instance);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference refs[],
                                   size_t count, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[])
{
    (void)refs, (void)count, (void)counters, (void)resolutions, (void)qualifiers;
    return refuse(instance);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                               fmi3Float64 shifts[])
{
    (void)refs, (void)count, (void)shifts;
    return refuse(instance);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference refs[],
                                size_t count, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)refs, (void)count, (void)counters, (void)resolutions;
    return refuse(instance);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference refs[],
                                  size_t count, const fmi3Float64 intervals[])
{
    (void)refs, (void)count, (void)intervals;
    return refuse(instance);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference refs[],
                                   size_t count, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[])
{
    (void)refs, (void)count, (void)counters, (void)resolutions;
    return refuse(instance);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference refs[], size_t count,
                               const fmi3Float64 shifts[])
{
    (void)refs, (void)count, (void)shifts;
    return refuse(instance);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference refs[],
                                size_t count, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[])
{
    (void)refs, (void)count, (void)counters, (void)resolutions;
    return refuse(instance);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference refs[],
                                    size_t count, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t length)
{
    (void)refs, (void)count, (void)orders, (void)values, (void)length;
    return refuse(instance);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock,
                                      fmi3Float64 time)
{
    (void)clock, (void)time;
    return refuse(instance);
}

/* Runs the test vectors; ends with 0 if every torque is right. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vectors.h"

int main(void)
{
    wmr_mb_parameters parameters;
    wmr_mb_state memory;
    wmr_mb_inputs in;
    wmr_mb_outputs out;
    double worst = 0.0;

    wmr_mb_defaults(&parameters);
    for (int k = 0; k < WMR_VECTORS; ++k) {
        if (k % WMR_SAMPLES == 0) {
            wmr_mb_start(&memory);
        }
        memcpy(&in, wmr_inputs[k], sizeof wmr_inputs[k]);
        if (wmr_mb_step(&parameters, &memory, &in, &out)) {
            printf("sample %d: refused\n", k);
            return 1;
        }
        for (int i = 0; i < 2; ++i) {
            const double found = (double)((const wmr_real *)&out)[i];
            const double error = fabs(found - wmr_torques[k][i]) / (1.0 + fabs(wmr_torques[k][i]));
            worst = error > worst ? error : worst;
        }
    }
    printf("%d samples, largest error %.3g (at most %.3g)\n", WMR_VECTORS, worst, (double)WMR_TOLERANCE);
    return worst <= WMR_TOLERANCE ? 0 : 1;
}

/* Plays the test vectors of the law's package through the S-function as Simulink would call it:
   outputs twice in each step, then the update.  Prints the period, and the largest error. */
#include <math.h>
#include <stdio.h>

#include "vectors.h"

static SimStruct block;

int main(void)
{
    double worst = 0.0;
    mdlInitializeSizes(&block);
    mdlInitializeSampleTimes(&block);
    for (int k = 0; k < WMR_VECTORS; ++k) {
        const wmr_real *number = wmr_inputs[k];
        if (k % WMR_SAMPLES == 0) {
            mdlInitializeConditions(&block);
        }
        for (int i = 0; i < block.inputs; ++i) {
            for (int j = 0; j < block.input_width[i]; ++j) {
                block.input[i][j] = *number++;
            }
        }
        mdlOutputs(&block, 0);
        mdlOutputs(&block, 0);
        for (int i = 0; i < 2; ++i) {
            const double error = fabs(block.output[i][0] - wmr_torques[k][i]);
            worst = fmax(worst, error / (1.0 + fabs(wmr_torques[k][i])));
        }
        mdlUpdate(&block, 0);
        if (block.error || !block.feeds[0] || block.work_width[0] > MOCK_NUMBERS) {
            return 1;
        }
    }
    printf("%.17g %.17g %d\n", block.period, worst, WMR_VECTORS);
    block.input[0][0] = NAN;
    mdlOutputs(&block, 0);
    mdlTerminate(&block);
    return block.error ? 0 : 2;
}

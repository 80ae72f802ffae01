/* Plays the test vectors of a law's package through the S-function as Simulink would call it: outputs
   twice in each step, then the update.  In the middle of each path the run is saved and gone on with
   by what operating points hold.  dialog.h has the numbers of the dialog.  Prints the period, the
   largest error and how many vectors there were; then what the dialog refuses. */
#include <math.h>
#include <stdio.h>

#include "dialog.h"
#include "vectors.h"

static SimStruct block, saved;

static void take_dialog(SimStruct *S)
{
    const real_T *number = mock_dialog;
    S->given = MOCK_DIALOG;
    for (int i = 0; i < MOCK_DIALOG; ++i) {
        S->parameter[i].numbers = number;
        S->parameter[i].count = mock_sizes[i];
        number += mock_sizes[i];
    }
}

/* The same run in another block, whose memory alone comes from the first. */
static void go_on(void)
{
    saved = block;
    memset(&block, 0, sizeof block);
    take_dialog(&block);
    mdlInitializeSizes(&block);
    mdlInitializeSampleTimes(&block);
    mdlInitializeConditions(&block);
    for (int i = 0; i < block.works; ++i) {
        if (block.work_use[i] == SS_DWORK_USED_AS_DSTATE) {
            memcpy(block.work[i], saved.work[i], sizeof saved.work[i]);
        }
    }
}

static void refuse(int place, mxArray wrong)
{
    const mxArray right = block.parameter[place];
    block.parameter[place] = wrong;
    block.error = NULL;
    mdlCheckParameters(&block);
    printf("%s\n", block.error ? block.error : "taken");
    block.parameter[place] = right;
    block.error = NULL;
}

int main(void)
{
    static const real_T not_a_number[MOCK_NUMBERS] = {NAN};
    double worst = 0.0;
    block.given = MOCK_DIALOG + 1;
    mdlInitializeSizes(&block);
    if (block.inputs != 0) {
        return 3;
    }
    take_dialog(&block);
    mdlInitializeSizes(&block);
    if (block.error) {
        puts(block.error);
        return 5;
    }
    mdlInitializeSampleTimes(&block);
    mdlSetWorkWidths(&block);
    if (!block.many) {
        return 6;
    }
    for (int k = 0; k < WMR_VECTORS; ++k) {
        const wmr_real *number = wmr_inputs[k];
        if (k % WMR_SAMPLES == 0) {
            mdlInitializeConditions(&block);
        }
        if (k % WMR_SAMPLES == WMR_SAMPLES / 2) {
            go_on();
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
    for (int i = 0; i < block.works; ++i) {
        printf("%s %d %d\n", block.work_name[i], block.work_use[i], block.compliance);
    }
    for (int i = 0; i < block.parameters; ++i) {
        const mxArray right = block.parameter[i];
        mxArray wrong = right;
        if (!block.tunable[i]) {
            return 4;
        }
        wrong.numbers = not_a_number;
        refuse(i, wrong);
        wrong = right;
        wrong.count += 1;
        refuse(i, wrong);
        wrong = right;
        wrong.text = 1;
        refuse(i, wrong);
        refuse(i, right);
    }
    block.input[0][0] = NAN;
    mdlOutputs(&block, 0);
    mdlTerminate(&block);
    return block.error ? 0 : 2;
}

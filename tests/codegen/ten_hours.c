/* A robot on a circle for hours, driven by its encoders alone at 100 Hz; the counters begin near their end.

   Arguments: hours, counts a turn, bits of the counters, first counts.  Prints samples that were
   refused, the largest distance from the desired position [m] and error of the speed [m/s] after
   30 s, counts that each wheel turned, and how many of them the steps of its counter miss. */
#include "wmr_kanayama.c"

#include <stdio.h>
#include <stdlib.h>

#define TURN 6.283185307179586

/* What a counter of so many bits shows, as an unsigned timer does where it has 16. */
static int32_t shown(int64_t counts, int bits)
{
    return bits == 16 ? (int32_t)(uint16_t)counts : (int32_t)(uint32_t)counts;
}

int main(int argc, char **argv)
{
    const double hours = argc > 4 ? atof(argv[1]) : 0, per_turn = argc > 4 ? atof(argv[2]) : 1;
    const int bits = argc > 4 ? atoi(argv[3]) : 32;
    const int64_t first = argc > 4 ? atoll(argv[4]) : 0;
    const double T = 0.01, radius = 2.0, rate = TURN / 60.0;
    double x = radius, y = 0, theta = 0, v = 0, omega = 0, way[2] = {0, 0}, far = 0, wrong = 0;
    wmr_kanayama_parameters p;
    wmr_kanayama_state memory, counter;
    wmr_kanayama_inputs in;
    wmr_kanayama_outputs tau = {0, 0};
    int64_t turned[2] = {0, 0}, told[2] = {0, 0};
    long refused = 0;

    wmr_kanayama_defaults(&p);
    wmr_kanayama_start(&memory);
    wmr_kanayama_start(&counter);
    memset(&in, 0, sizeof in);
    const double m = (double)p.model_m, I = (double)p.model_I, r = (double)p.robot_r, l = (double)p.robot_l;
    for (long k = 0; k < (long)(hours * 360000.0 + 0.5); ++k) {
        const double angle = rate * T * (double)k, c = cos(angle), s = sin(angle);
        wmr_real steps[2];
        in.x_d = (wmr_real)(radius * c), in.y_d = (wmr_real)(radius * s), in.theta_d = (wmr_real)angle;
        in.v1_d = (wmr_real)(radius * rate), in.v2_d = (wmr_real)rate;
        in.x = (wmr_real)x, in.y = (wmr_real)y, in.theta = (wmr_real)theta;
        for (int i = 0; i < 2; ++i) {
            turned[i] = (int64_t)floor(way[i] / (TURN * r) * per_turn);
            in.wheel_counts[i] = shown(first + turned[i], bits);
        }
        refused += wmr_kanayama_step(&p, &memory, &in, &tau) != 0 || !count_steps(&counter, in.wheel_counts, steps);
        told[0] += (int64_t)steps[0], told[1] += (int64_t)steps[1];
        if (k > 3000) {
            far = fmax(far, hypot(x - radius * c, y - radius * s));
            wrong = fmax(wrong, fabs(v - radius * rate));
        }
        for (int j = 0; j < 2; ++j) {
            const double h = T / 2, mean = v, turning = omega;
            v += h * ((double)tau.tau_right + (double)tau.tau_left) / (r * m);
            omega += h * l * ((double)tau.tau_right - (double)tau.tau_left) / (r * I);
            x -= h * mean * sin(theta + h * turning / 2), y += h * mean * cos(theta + h * turning / 2);
            theta += h * turning;
            way[0] += h * (mean + l * turning), way[1] += h * (mean - l * turning);
        }
    }
    printf("%ld %.9g %.9g %lld %lld %lld %lld\n", refused, far, wrong, (long long)turned[0],
           (long long)turned[1], (long long)(turned[0] - told[0]), (long long)(turned[1] - told[1]));
    return 0;
}

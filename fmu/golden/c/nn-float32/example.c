/* The law drives a rough model of the scenario's robot on a circle of 2 m for 20 s. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "wmr_nn.h"

int main(void)
{
    wmr_nn_parameters parameters;
    wmr_nn_state memory;
    wmr_nn_inputs in;
    wmr_nn_outputs torque;
    const double T = 0.01, radius = 2.0, rate = 0.1;
    const double mass = 50.0, inertia = 5.4, mu = 0.08, g = 9.81;
    const double wheel = 0.1, half_track = 0.25;
    double x = -0.5, y = -0.5, theta = -0.7;
    double v = 0.0, omega = 0.0;

    memset(&in, 0, sizeof in);
    wmr_nn_defaults(&parameters);
    wmr_nn_start(&memory);
    for (int k = 0; k < (int)(20.0 / T + 0.5); ++k) {
        const double angle = rate * k * T;
        in.x_d = (wmr_real)(radius * sin(angle));
        in.y_d = (wmr_real)(radius - radius * cos(angle));
        in.theta_d = (wmr_real)(angle - 1.5707963267948966);
        in.v1_d = (wmr_real)(radius * rate);
        in.v2_d = (wmr_real)rate;
        in.x = (wmr_real)x, in.y = (wmr_real)y, in.theta = (wmr_real)theta;
        in.v1 = (wmr_real)v;
        in.omega = (wmr_real)omega;
        if (wmr_nn_step(&parameters, &memory, &in, &torque)) {
            return 1;
        }
        for (int i = 0; i < 10; ++i) {
            const double h = T / 10.0, force = (torque.tau_right + torque.tau_left) / wheel;
            const double moment = half_track * (torque.tau_right - torque.tau_left) / wheel;
            x -= h * v * sin(theta), y += h * v * cos(theta), theta += h * omega;
            v += h * (force / mass - mu * g * tanh(v / 0.01)), omega += h * moment / inertia;
        }
    }
    printf("distance %.4f m, v1 %.4f m/s\n", hypot(x - in.x_d, y - in.y_d), v);
    return 0;
}

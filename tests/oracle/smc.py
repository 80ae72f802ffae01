"""Adaptive sliding-mode law: a stand-in for the paper's reference [32], whose law it omits."""

import math

from tests.oracle.barrier import clip


class Smc:
    """s = v_c0 - v and F = m^ v_c0' + F^ tanh(v/v_s) + K s + eta sat(s/boundary), per axis."""

    def __init__(self, gains, scenario):
        self.gains = gains
        self.T = scenario.clock.control
        self.m_hat = [0.0, 0.0]
        self.F_hat = [0.0, 0.0]

    def act(self, sight):
        """Generalised force (thrust [N], moment [N m]); the estimates follow by explicit Euler."""
        return self._axis(0, sight), self._axis(1, sight)

    def _axis(self, i, sight):
        g = self.gains
        s = sight.v_c0[i] - sight.v[i]
        direction = math.tanh(sight.v[i] / g["v_s"])
        reach = g["K"][i] * s + g["eta"][i] * clip(s / g["boundary"], 1.0)
        force = self.m_hat[i] * sight.v_c0_dot[i] + self.F_hat[i] * direction + reach
        self.m_hat[i] += self.T * g["g_m"] * g["axis_scale"][i] * sight.v_c0_dot[i] * s
        self.F_hat[i] += self.T * g["g_F"] * g["axis_scale"][i] * direction * s
        return float(force)

    def memory(self):
        """Estimated inertia and friction of both axes, after the update."""
        return {"m_hat": tuple(self.m_hat), "F_hat": tuple(self.F_hat)}

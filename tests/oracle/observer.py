"""Momentum observer of the force that the model does not explain, from its definition."""

import math


class ForceObserver:
    """f_k = f_(k-1) + (1 - exp(-wo T)) (F_applied - M dv/T - F1(middle) - f_(k-1))."""

    def __init__(self, wo, scenario):
        self.T, self.bot = scenario.clock.control, scenario.believed
        self.share = -math.expm1(-wo * self.T)
        self.f_hat = (0.0, 0.0)
        self.v_before = None

    def friction(self, v1):
        """Believed friction [N] at the speed ``v1`` [m/s]."""
        return self.bot.mu * self.bot.m * self.bot.g * math.tanh(v1 / self.bot.v_s)

    def look(self, sight):
        """The force and moment that compensate the disturbance, updated from the second sample
        on.
        """
        old, self.v_before = self.v_before, sight.v
        if old is not None:
            self._renew(sight, old)
        return self.f_hat

    def _renew(self, sight, old):
        right, left = sight.applied
        force = ((right + left) / self.bot.r, self.bot.l * (right - left) / self.bot.r)
        drag = (self.friction((sight.v[0] + old[0]) / 2.0), 0.0)
        first, second = (
            f + self.share * (force[i] - mass * (sight.v[i] - old[i]) / self.T - drag[i] - f)
            for i, (f, mass) in enumerate(zip(self.f_hat, (self.bot.m, self.bot.I), strict=True))
        )
        self.f_hat = (first, second)

    def memory(self):
        """The compensated disturbance."""
        return {"d_hat": (-self.f_hat[0], -self.f_hat[1])}

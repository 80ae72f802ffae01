"""Model-based barrier law, Eq. (9), with V1/A and q where the paper has the pseudo-inverse of A."""

import math


class ModelBased:
    """F = M1 (-rho V1/A + q v_c0') + F1, with the robot as the law believes it to be."""

    def __init__(self, gains, scenario):
        self.rho = [_rate(rho, gains, scenario.clock.control) for rho in gains["rho"]]
        self.believed = scenario.believed

    def act(self, sight):
        """Generalised force (thrust [N], moment [N m])."""
        bot = self.believed
        friction = bot.mu * bot.m * bot.g * math.tanh(sight.v[0] / bot.v_s)
        return (
            bot.m * self._acceleration(0, sight) + friction,
            bot.I * self._acceleration(1, sight),
        )

    def _acceleration(self, i, sight):
        b = sight.barrier[i]
        return float(-self.rho[i] * b.V1_by_A + b.q * sight.v_c0_dot[i])

    def memory(self):
        """Nothing to log."""
        return {}


def _rate(rho, gains, T):
    """rho, or the rate of one Newton step towards exp(-rho T) V1."""
    exact = gains.get("decay") == "exact"
    return -math.expm1(-rho * T) / T if exact else rho

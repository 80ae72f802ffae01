"""The paper's PID baseline: it gives no integral gain, so a PD law on z = v - v_c0, Eq. (13)."""


class Pid:
    """F = -Kp z - Kd dz/dt, dz/dt by the backward difference, 0 at the first sample."""

    def __init__(self, gains, scenario):
        self.Kp, self.Kd = gains["Kp"], gains["Kd"]
        self.T = scenario.clock.control
        self.z_before = None

    def act(self, sight):
        """Generalised force (thrust [N], moment [N m])."""
        z = (sight.v[0] - sight.v_c0[0], sight.v[1] - sight.v_c0[1])
        old = z if self.z_before is None else self.z_before
        z_dot = ((z[0] - old[0]) / self.T, (z[1] - old[1]) / self.T)
        self.z_before = z
        return (
            -self.Kp[0] * z[0] - self.Kd[0] * z_dot[0],
            -self.Kp[1] * z[1] - self.Kd[1] * z_dot[1],
        )

    def memory(self):
        """Nothing to log."""
        return {}

"""Cores of the nodes with a test's messages, on clocks that the test moves."""

from wmr_ctrl.ros2.clocks import Moment

MS = 1_000_000


class Clocked:
    """A core that restarts at a moment, and the time faults that it reported."""

    def __init__(self, core, ros=10**15, simulated=False):
        self.core, self.ros, self.steady, self.simulated = core, ros, 7 * 10**9, simulated
        self.told = []
        core.start()

    def now(self):
        now = Moment(self.ros, self.steady, self.simulated)
        self.told += self.core.see(now)
        return now

    def wait(self, ros, steady=None):
        """Let times pass [ns], by default the same on both clocks."""
        self.ros, self.steady = self.ros + ros, self.steady + (ros if steady is None else steady)

    @property
    def flags(self):
        return set(self.core.last.flags)


class World(Clocked):
    """The filter with a sender of commands, and of free distances if there is a distance ``ahead``
    [m].

    Limits, which otherwise stay in force after a restart, are forgotten.
    """

    def __init__(self, core, ahead=None, **how):
        super().__init__(core, **how)
        self.ahead = ahead
        for topic in range(4):
            core._core.limited[topic] = 0

    def go(self, count=40, v=0.5, omega=0.0, *, sends=True, stamped=True, passes=True, periods=1):
        """Speeds sent at ticks, after a command and free distances before each."""
        speeds, time = [], round(periods * self.core.period * 1e9)
        for _ in range(count):
            self.wait(time if passes else 0, time)
            if self.ahead is not None:
                ways = self.ahead, float("inf"), 0.5, 0.5
                assert self.core.hear_free(ways, self.now()) == ""
            if sends:
                self.command(self.ros if stamped else 0, v, omega)
            speeds.append(self.core.tick(self.now()).command[0])
        return speeds

    def command(self, stamp, v=0.5, omega=0.0):
        """Send a command; return the reason of its refusal, else ""."""
        return self.core.command((v, omega), stamp, "", self.now())[0]

    def limit(self, topic, *numbers):
        self.core.limit(topic, numbers, self.now())

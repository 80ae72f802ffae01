"""What a filter hears, and whether it came in time: odometry, samples and free ways."""

from functools import cached_property, reduce

import casadi as ca

from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.model.system import Parameters, Port
from wmr_ctrl.world.scenario import Scenario

from .channels import AXES, is_number, punctual, within
from .governor import NEAR, Schedule


class Heard:
    """Of a filter with memory: young odometry, samples in time, commands sent in time.

    ``plans``: times of v and of omega; ``oldest``: number of commands that it remembers.
    """

    scenario: Scenario
    p: Parameters
    plans: tuple[Schedule, Schedule]
    T: ca.SX
    oldest: int
    odometry: Port
    age: Port
    elapsed: Port
    counted: tuple[Port, ...]

    @cached_property
    def seen(self) -> ca.SX:
        """1 if there is odometry, young enough and a number."""
        if self.scenario.filter.odometry is None:
            return ca.SX(0)
        age = 0.5 * self.plans[0].age * self.T
        young = within(self.age.sym - age, age + NEAR * self.T)
        return reduce(ca.logic_and, [young, *(within(self.odometry.sym[i], LARGEST) for i in AXES)])

    @cached_property
    def came(self) -> ca.SX:
        """1 if the sample came within its jitter."""
        return punctual(self.elapsed.sym, self.T, self.plans[0].jitter)

    @cached_property
    def in_time(self) -> list[ca.SX]:
        """Number of punctual samples since the last late one; empty if only one command may act."""
        most = self.oldest
        return [ca.if_else(self.came, ca.fmin(n.sym + 1, most), 0) for n in self.counted]

    @cached_property
    def punctual(self) -> ca.SX:
        """1 if all commands that may still act were sent on time."""
        return self.in_time[0] >= self.oldest if self.counted else self.came


class Watching(Heard):
    """Of a filter that is told free ways, too."""

    free: Port
    free_age: Port

    @cached_property
    def is_fresh(self) -> ca.SX:
        """1 where the free ways are told, and not too old."""
        half = 0.5 * self.p.take("filter.free_age")
        return within(self.free_age.sym - half, half + NEAR * self.T)

    def hears(self, number: int) -> ca.SX:
        """1 where this one of the free ways is fresh."""
        return ca.logic_and(self.is_fresh, is_number(self.free.sym[number]))

"""Laws as other packages would supply them: one that uses Eq. (7), one that knows nothing."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.control.laws import registry
from wmr_ctrl.control.laws.law import Law, Traits
from wmr_ctrl.core.fields.section import Section, quantity


class ToyGains(Section, key="gains.toy"):
    """One gain an axis."""

    k: tuple[float, float] = quantity((200.0, 20.0), unit="N.s/m, N.m.s/rad", doc="gain on z")


def build_toy(context):
    """F = F1 - k (v - v_c1)."""
    pull = context.gain("k") * (context.v - context.per_axis("v_c1"))
    return context.system("toy", context.friction - pull)


TOY = Law(
    "toy",
    gains=ToyGains,
    build=build_toy,
    traits=Traits(auxiliary=True, barrier=True, model=True),
    doc="Toy law.",
)


class PlainGains(Section, key="gains.plain"):
    """Gains on the errors of position, heading and velocity."""

    ahead: float = quantity(0.5, unit="1/s", doc="gain on e_1", minimum=0.0)
    aside: float = quantity(0.5, unit="rad/(m.s)", doc="gain on e_2", minimum=0.0)
    turned: float = quantity(1.0, unit="1/s", doc="gain on e_3", minimum=0.0)
    k: tuple[float, float] = quantity((1000.0, 100.0), unit="N.s/m, N.m.s/rad", doc="gain on v")


def build_plain(context):
    """F = k (v_d + gains times errors - v): no Eq. (7), no barrier, no model, no memory."""
    steer = context.gain("aside") * context.e[1] + context.gain("turned") * context.e[2]
    wanted = context.v_d + ca.vertcat(context.gain("ahead") * context.e[0], steer)
    return context.system("plain", context.gain("k") * (wanted - context.v))


PLAIN = Law(
    "plain",
    gains=PlainGains,
    build=build_plain,
    traits=Traits(),
    doc="Plain law.",
)


class Entry:
    """Stands for the entry point of another package."""

    def __init__(self, law):
        self.name, self.value, self._law = law.name, "elsewhere:LAW", law

    def load(self):
        """The law."""
        return self._law


def install(monkeypatch, *laws):
    """Register laws for one test, as if their packages were installed."""
    monkeypatch.setattr(registry, "entry_points", lambda group: [Entry(law) for law in laws])
    monkeypatch.setitem(vars(registry.LAWS), "plugins", registry.LawRegistry().plugins)


def forget(monkeypatch):
    """Context that forgets the laws that one test supplies."""
    monkeypatch.setattr(registry.LAWS, "given", {})
    monkeypatch.setattr(registry.LAWS, "files", {})

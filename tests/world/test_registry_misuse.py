"""Invalid effects and references of other packages: an error that names them, or no harm."""

from __future__ import annotations

import math
from dataclasses import replace

import casadi as ca
import pytest

from tests.world import toys
from wmr_ctrl.api import export_fmu
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import REFERENCE, TORQUE, Signal
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.world.effect import Bound, EffectRole, Rate
from wmr_ctrl.world.model.system import Output, draw, port
from wmr_ctrl.world.references.registry import REFERENCES
from wmr_ctrl.world.registry import EFFECTS

pytestmark = pytest.mark.usefixtures("toy_world")
SHORT = {"clock.duration": 0.3, "disturbance.truncate": 3.0}


@pytest.fixture
def register(monkeypatch):
    """The toy slope with other fields is the only effect of another package."""

    def register(**changed):
        monkeypatch.setitem(EFFECTS.__dict__, "plugins", (replace(toys.SLOPE, **changed),))

    return register


def sloping(guard=False):
    return scenario_of("paper-simulation", {**SHORT, "toy_slope.angle": 0.1}, guard=guard)


# -- what an effect is --------------------------------------------------------------------


@pytest.mark.parametrize(
    "field, value",
    [("role", EffectRole.SENSOR), ("rate", "step"), ("switches", ("size",))],
)
def test_an_effect_that_could_never_act_is_refused(field, value):
    with pytest.raises(ArgumentError, match=r"toy slope .*(rate = |is no field)"):
        replace(toys.SLOPE, **{field: value})
    with pytest.raises(ArgumentError, match="STEP for a drive"):
        replace(toys.RAMP, rate=Rate.SAMPLE)


@pytest.mark.parametrize(
    "bound",
    [
        {"dbar": (math.nan, 0.0)}, {"dbar": (-5.0, 0.0)}, {"dbar": (1.0, 2.0, 3.0)}, {"dbar": 3.0},
        {"nbar": (math.inf, 0.0)}, {"mass": ("1", "2")}, {"delay": -0.01}, {"jitter": math.nan},
        {"lag": (0.05, 0.01)}, {"age": (0.0, -1.0)},
    ],
)  # fmt: skip
def test_an_impossible_bound_names_its_effect(register, bound):
    register(bound=lambda scenario: Bound(**bound))
    with pytest.raises(ArgumentError, match=rf"toy slope .*{next(iter(bound))} = "):
        runnable(sloping(guard=True), "mb")


@pytest.mark.parametrize("field", ["build", "acts", "bound", "check"])
def test_an_error_in_an_effect_names_it(register, field):
    register(**{field: lambda scenario: 1 / 0})
    said = rf"the effect toy slope \(\[toy_slope\]\) fails in its {field}: ZeroDivisionError"
    with pytest.raises(ArgumentError, match=said):
        runnable(sloping(guard=True), "mb")


# -- what a role has a place for ----------------------------------------------------------


PAIR = Signal("pair", "1", "numbers", 2)


@pytest.mark.parametrize(
    "part, more, words",
    [
        ("outputs", Output(TORQUE[0], ca.SX(0)), r"writes 'tau_right'.*thrust"),
        ("draws", draw(PAIR, "poisson", ca.SX(1)), "draws 'poisson' numbers"),
        *(
            ("inputs", port(signal), f"reads '{signal.name}'")
            for signal in (TORQUE[0], REFERENCE[0], Signal("foo", "1", "nothing"))
        ),
    ],
)
def test_an_effect_is_limited_to_the_signals_of_its_role(register, part, more, words):
    def build(scenario):
        system = toys.slope(scenario)
        return replace(system, **{part: (*getattr(system, part), more)})

    register(build=build)
    with pytest.raises(ArgumentError, match=f"toy slope .*{words}"):
        runnable(sloping(), "mb")


@pytest.mark.parametrize("name", ["x", "V1", "tau_right", "twice"])
def test_a_diagnostic_has_a_name_of_its_own(register, name):
    named = [Output(Signal(item, "1", "something"), ca.SX(0)) for item in (name, "twice")]
    register(
        build=lambda scenario: replace(toys.slope(scenario), diagnostics=(*named,)),
        rate=Rate.SAMPLE,
    )
    with pytest.raises(ArgumentError, match=f"diagnostic '{name}'"):
        runnable(sloping(), "mb")


# -- registries ---------------------------------------------------------------------------


def table(key):
    return type("Own", (Section,), {"KEY": key})


@pytest.mark.parametrize("changed", [{"name": "slope"}, {"section": table("slope")}])
def test_a_name_and_a_table_of_ours_are_nobody_elses(monkeypatch, changed):
    effects = (replace(toys.SLOPE, **changed),)
    monkeypatch.setattr("wmr_ctrl.world.registry.loaded", lambda *_: effects)
    with pytest.raises(ArgumentError, match="name or the table"):
        tuple(type(EFFECTS)())


@pytest.mark.parametrize("key", ["robot", "clock", "reference", "changes"])
def test_no_effect_takes_a_table_of_the_scenario(register, key):
    register(section=table(key))
    with pytest.raises(ArgumentError, match=f"table '{key}'"):
        scenario_of("paper-simulation", {"robot.m": 61.0})


@pytest.mark.parametrize(
    "changed",
    [
        lambda system: {"outputs": system.outputs[::-1]},
        lambda system: {"outputs": system.outputs[:6]},
        lambda system: {"inputs": (*system.inputs, port(TORQUE[0]))},
    ],
    ids=["other order", "six", "reads a torque"],
)
def test_a_reference_gives_the_seven_signals_in_order(monkeypatch, changed):
    def build(scenario):
        system = toys.clothoid(scenario)
        return replace(system, **changed(system))

    kind = replace(toys.CLOTHOID, build=build)
    monkeypatch.setitem(REFERENCES.__dict__, "plugins", (kind,))
    with pytest.raises(ArgumentError, match=r"toy-clothoid.*x_d, y_d, theta_d"):
        runnable(scenario_of("paper-simulation", {"reference.kind": "toy-clothoid"}), "mb")


def test_an_unknown_unit_is_reported_with_its_field(register, tmp_path):
    class Furlongs(Section, key="toy_slope"):
        angle: float = quantity(0.0, unit="furlong", doc="how far", minimum=0)

    register(section=Furlongs, acts=lambda scenario: True, bound=None)
    with pytest.raises(ArgumentError, match=r"toy_slope\.angle: unit 'furlong'"):
        export_fmu("closed-loop", law="mb", scenario=sloping(), out=tmp_path)

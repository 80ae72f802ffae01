"""Effects and references of other packages that are wrong: an error that names them, or no harm."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import casadi as ca
import pytest
from click.testing import CliRunner

from tests.world import toys
from wmr_ctrl.api import export_fmu
from wmr_ctrl.cli import root
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields import plugins
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import BODY_FORCE, REFERENCE, TORQUE, TORQUE_NOISE, Signal
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.world.effect import Bound, Effect, EffectRole, Rate
from wmr_ctrl.world.model.system import NORMAL, Output, Parameters, System, draw, port
from wmr_ctrl.world.references.registry import REFERENCES
from wmr_ctrl.world.registry import EFFECTS

pytestmark = pytest.mark.usefixtures("toy_world")
SHORT = {"clock.duration": 0.3, "disturbance.truncate": 3.0}


class Shake(Section, key="shake"):
    """How hard."""

    force: float = quantity(0.0, unit="N", doc="mean force backwards", minimum=0)


def shaken(scenario, signals=BODY_FORCE):
    """A force with a mean, and random numbers around it, without state."""
    p = Parameters(scenario)
    force = p.take("shake.force")
    number = draw(Signal("shake", "1", "normal numbers", 2), NORMAL, force > 0, 3.0)
    made = -force * (1 + 0.1 * number.port.sym)
    return System(
        "shake",
        "shaking",
        params=p.ports,
        outputs=tuple(Output(signal, made[i]) for i, signal in enumerate(signals)),
        period=scenario.clock.plant,
        draws=(number,),
    )


SHAKE = Effect(
    "shake",
    EffectRole.DISTURBANCE,
    Shake,
    shaken,
    lambda scenario: Bound(dbar=(1.3 * scenario.section(Shake).force, 0.0)),
    rate=Rate.STEP,
)


@pytest.fixture
def registered(monkeypatch):
    def register(*effects):
        monkeypatch.setitem(EFFECTS.__dict__, "plugins", effects)

    return register


def shaking(**more):
    return scenario_of("paper-simulation", {**SHORT, "shake.force": 5.0, **more})


# -- what an effect is --------------------------------------------------------------------


@pytest.mark.parametrize(
    "field, value",
    [("role", EffectRole.SENSOR), ("rate", "step"), ("switches", ("size",))],
)
def test_an_effect_that_could_never_act_is_refused(field, value):
    with pytest.raises(ArgumentError, match=r"shake .*(rate = |is no field)"):
        replace(SHAKE, **{field: value})
    with pytest.raises(ArgumentError, match="STEP for a drive"):
        replace(toys.RAMP, rate=Rate.SAMPLE)


# -- bounds -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "bound",
    [
        {"dbar": (math.nan, 0.0)}, {"dbar": (-5.0, 0.0)}, {"dbar": (1.0, 2.0, 3.0)}, {"dbar": 3.0},
        {"nbar": (math.inf, 0.0)}, {"mass": ("1", "2")}, {"delay": -0.01}, {"jitter": math.nan},
        {"lag": (0.05, 0.01)}, {"age": (0.0, -1.0)},
    ],
)  # fmt: skip
def test_an_impossible_bound_names_its_effect(registered, bound):
    registered(replace(SHAKE, bound=lambda scenario: Bound(**bound)))
    with pytest.raises(ArgumentError, match=rf"shake \(\[shake\]\).*{next(iter(bound))} = "):
        runnable(shaking(**{"guard.enabled": True}), "mb")


# -- functions that fail ------------------------------------------------------------------


@pytest.mark.parametrize("field", ["build", "acts", "bound", "check"])
def test_an_error_in_an_effect_names_it(registered, field):
    registered(replace(SHAKE, **{field: lambda scenario: 1 / 0}))
    done = CliRunner().invoke(
        root, ["run", "paper-simulation", "--set", "shake.force=1", "--guard"]
    )

    assert done.exit_code == 2
    said = " ".join(done.stderr.split())
    assert f"the effect shake ([shake]) fails in its {field}: ZeroDivisionError" in said


# -- what a role has a place for ----------------------------------------------------------


def reading(signal):
    return lambda scenario: replace(shaken(scenario), inputs=(port(signal),))


def drawing_poisson(scenario):
    system = shaken(scenario)
    return replace(system, draws=(replace(system.draws[0], kind="poisson"),))


FOREIGN = (TORQUE[0], REFERENCE[0], Signal("foo", "1", "nothing"))


@pytest.mark.parametrize(
    "build, words",
    [
        (lambda scenario: shaken(scenario, TORQUE), r"writes 'tau_right'.*thrust"),
        (drawing_poisson, "poisson"),
        *((reading(signal), f"reads '{signal.name}'") for signal in FOREIGN),
    ],
)
def test_an_effect_is_limited_to_the_signals_of_its_role(registered, build, words):
    registered(replace(SHAKE, build=build))
    with pytest.raises(ArgumentError, match=f"shake .*{words}"):
        runnable(shaking(), "mb")


@pytest.mark.parametrize("name", ["x", "V1", "tau_right", "shake_now"])
def test_a_diagnostic_has_a_name_of_its_own(registered, name):
    def build(scenario):
        named = (Output(Signal(name, "1", "something"), ca.SX(0)),)
        again = (Output(Signal("shake_now", "1", "something"), ca.SX(0)),)
        return replace(shaken(scenario), diagnostics=(*named, *again))

    registered(replace(SHAKE, build=build, rate=Rate.SAMPLE))
    with pytest.raises(ArgumentError, match=f"diagnostic '{name}'"):
        runnable(shaking(), "mb")


# -- outputs that hold reference, controller and plant alone --------------------------------


@pytest.mark.parametrize("what", ["ssp", "modelica", "simulink"])
@pytest.mark.parametrize("signals", [BODY_FORCE, TORQUE_NOISE], ids=["body", "wheels"])
def test_a_mean_force_is_not_lost_with_its_noise(registered, what, signals, tmp_path):
    registered(replace(SHAKE, build=lambda scenario: shaken(scenario, signals)))
    named = {} if what == "modelica" else {"law": "mb"}
    quiet = shaking(**{"disturbance.std": 0.0})
    with pytest.raises(ArgumentError, match=r"shake \(\[shake\]\)"):
        export_fmu(what, scenario=quiet, out=tmp_path, **named)
    assert not list(tmp_path.iterdir())


# -- figures of stability -----------------------------------------------------------------


# -- registries ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Point:
    """An entry point."""

    name: str
    loaded: object
    value: str = "somewhere:X"

    def load(self):
        """What it points to."""
        if isinstance(self.loaded, Exception):
            raise self.loaded
        return self.loaded


def table(key):
    return type("Own", (Section,), {"KEY": key})


@pytest.mark.parametrize(
    "loaded, said",
    [
        (3, "must point to a Effect"),
        (ModuleNotFoundError("No module named 'nowhere'"), "nowhere"),
        (replace(SHAKE, name="slope"), "name or the table"),
        (replace(SHAKE, section=table("slope")), "name or the table"),
    ],
)
def test_an_entry_point_that_is_no_effect_is_named(monkeypatch, loaded, said):
    monkeypatch.setattr(plugins, "entry_points", lambda group: [Point("bad", loaded)])
    with pytest.raises(ArgumentError, match=said):
        tuple(type(EFFECTS)())


@pytest.mark.parametrize("key", ["robot", "clock", "reference", "changes"])
def test_no_effect_takes_a_table_of_the_scenario(registered, key):
    registered(replace(SHAKE, section=table(key)))
    with pytest.raises(ArgumentError, match=f"table '{key}'"):
        scenario_of("paper-simulation", {"robot.m": 61.0})


def reference(*changed, inputs=()):
    """The toy clothoid with other outputs or inputs."""

    def build(scenario):
        system = toys.CLOTHOID.build(scenario)
        return replace(system, outputs=changed or system.outputs, inputs=(*system.inputs, *inputs))

    return replace(toys.CLOTHOID, build=build)


@pytest.mark.parametrize(
    "kind",
    [
        reference(*(Output(signal, ca.SX(0)) for signal in reversed(REFERENCE))),
        reference(*(Output(signal, ca.SX(0)) for signal in REFERENCE[:6])),
        reference(inputs=(port(TORQUE[0]),)),
    ],
    ids=["other order", "six", "reads a torque"],
)
def test_a_reference_gives_the_seven_signals_in_order(monkeypatch, kind):
    monkeypatch.setitem(REFERENCES.__dict__, "plugins", (kind,))
    with pytest.raises(ArgumentError, match=r"toy-clothoid.*x_d, y_d, theta_d"):
        runnable(scenario_of("paper-simulation", {"reference.kind": "toy-clothoid"}), "mb")


def test_an_unknown_unit_is_reported_with_its_field(registered, tmp_path):
    class Furlongs(Section, key="shake"):
        force: float = quantity(0.0, unit="furlong", doc="how far", minimum=0)

    registered(replace(SHAKE, section=Furlongs, acts=lambda scenario: True, bound=None))
    with pytest.raises(ArgumentError, match=r"shake\.force: unit 'furlong'"):
        export_fmu("closed-loop", law="mb", scenario=shaking(), out=tmp_path)

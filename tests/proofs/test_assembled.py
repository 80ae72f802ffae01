"""Alterations of the assembled guard are noticed."""

import math
from dataclasses import replace

import casadi as ca
import pytest

from tests.tables import cases, changes
from wmr_ctrl.control import applied, controller
from wmr_ctrl.control.guard import delay, guard
from wmr_ctrl.control.laws import prox
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED
from wmr_ctrl.world import slope, torque_noise
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.alterations import altered
from wmr_proofs.claim import CLAIMED
from wmr_proofs.claims import all_claims, effect_bounds
from wmr_proofs.claims.common import PRESET, scalars
from wmr_proofs.claims.effect_bounds import EffectGraph
from wmr_proofs.claims.exported import Assembled, setup
from wmr_proofs.graph import graph_of
from wmr_proofs.methods import portfolio

pytest.importorskip("z3")

ENTRIES = {claim.id: claim for claim in all_claims()}
CONDITIONS = controller._built_for


def bypassed(asked, *others):
    """The guard's answer with the requested force in place of the safe one."""
    return replace(guard.guarded(asked, *others), force=asked)


def unsafe_anchor(asked, v, both, coming):
    """The guard's answer with the requested force as the safe point for the wheels."""
    return replace(guard.guarded(asked, v, both, coming), safe=asked)


def rounded_down(_count):
    """No margin reserved for rounding."""
    return 0.0


def reached_about(both, phi, half_track):
    """Brakes within the wheels' reach only to a rounding error."""
    first, second = (b.braking for b in (both.axis(0), both.axis(1)))
    return first + second / half_track <= phi * (1 + 2.0**-44)


def never_at_rest(*given):
    """Effect of commands in transit from the measured mean alone, without a stop by friction."""
    return replace(delay.delayed_push(*given), since_rest=None)


def any_drives(*given):
    """No condition on delay, lag or jitter, for any parameters."""
    return CONDITIONS(*given)[:0]


def capped(std, truncate, believed):
    """Bound of torque noise that ignores noise beyond three standard deviations."""
    thrust = 2.0 * std * min(truncate, 3.0) / believed[0]
    return thrust, thrust * believed[1]


def kept_late(self, torque):
    """Memory of applied torques in which each torque is stored one sample too late."""
    return [torque, *([torque, *(item.sym for item in self.earlier)][: len(self.earlier)])]


def held_mean(commands, late, acting, decay):
    """Mean torque of drives without lag; the acting torque stays as it is."""
    mean, _ = applied.followed(commands, late, acting, 0)
    return mean, acting


def whole_shares(context):
    """Shares of a step that decays by exp(-rho T) in place of exp(-rho T/2)."""
    whole = -context.gain("rho") * context.period
    return ca.exp(whole), -ca.expm1(whole)


@pytest.mark.parametrize(
    "key, place, name, stand_in",
    [
        ("guard.assembled", controller, "guarded", bypassed),
        ("guard.assembled", guard, "rounding", rounded_down),
        ("guard.assembled.late", controller, "delayed_push", never_at_rest),
        ("guard.assembled.late", controller, "_built_for", any_drives),
        ("guard.assembled", guard, "feasible", lambda _: 1),
        ("guard.assembled.keeps", controller, "guarded", unsafe_anchor),
        ("guard.assembled.keeps", guard, "within_reach", reached_about),
        ("world.noise.thrust", torque_noise, "noise_at_most", capped),
        ("guard.assembled", applied.Applied, "following", kept_late),
        ("world.lag.applied", effect_bounds, "followed", held_mean),
        ("prox.assembled", prox, "_shares", whole_shares),
    ],
)
@pytest.mark.slow_but(
    "guard.assembled-wmr_ctrl.control.controller-guarded-bypassed",
    "guard.assembled-wmr_ctrl.control.guard.guard-rounding-rounded_down",
    "world.noise.thrust-wmr_ctrl.world.torque_noise-noise_at_most-capped",
    "guard.assembled-Applied-following-kept_late",
    "world.lag.applied-wmr_proofs.claims.effect_bounds-followed-held_mean",
)
def test_what_feeds_guard_and_law_and_is_exported_is_in_an_entry(
    monkeypatch, key, place, name, stand_in
):
    """Two of z3's engines prove the entry, but not with the stand-in."""
    claim, engines = ENTRIES[key], [*portfolio.ENGINES.items()][:2]
    monkeypatch.setattr(portfolio, "ENGINES", dict(engines))
    assert claim.method.decide(claim.statement(CLAIMED)).verdict == PROVED

    monkeypatch.setattr(place, name, stand_in)
    method = replace(claim.method, effort=5)
    assert method.decide(claim.statement(CLAIMED)).verdict in (REFUTED, OPEN)


def test_a_number_that_leaks_out_of_a_bound_is_found():
    def flat(scenario):
        return Bound(dbar=(math.cos(scenario.section(slope.Slope).angle), 0.0))

    leaking = replace(slope.SLOPE, bound=flat)
    with pytest.raises(ValueError, match="holds a number that is no symbol"):
        EffectGraph(leaking, {"slope.angle": 0.1}).bound("dbar")


def test_a_late_monitor_that_tells_ten_times_the_push_is_refuted():
    (claim,) = (item for item in all_claims() if item.id == "guard.monitor-late")
    with altered("wmr_ctrl.control.guard.monitor:LateMotion.least_push", lambda push: 10 * push):
        assert claim.method.decide(claim.statement(CLAIMED)).verdict == REFUTED


def test_law_and_map_have_no_part_in_the_flag():
    graphs = {
        graph_of(found.symbols, [found.told["feasible"]], found.cuts).digest
        for assemble in (controller.guard, controller.asking_controller)
        for kind in guard.MAPS
        for found in [Assembled(assemble, setup(kind, 0))]
    }
    assert len(graphs) == 1


def is_told(system):
    """Return the elements of a System's outputs, next state and diagnostics by name."""
    ports = (*system.outputs, *system.diagnostics)
    told = {
        f"{item.signal.name}[{i}]": part
        for item in ports
        for i, part in enumerate(ca.vertsplit(item.expr))
    }
    later = zip(scalars(system.state), ca.vertsplit(system.update), strict=True)
    return told | {f"next {name}": part for name, part in later}


def digest(system, names):
    """Digest of the compiled text of the named values."""
    table, told = scalars((*system.inputs, *system.state, *system.params)), is_told(system)
    return graph_of(table, [told[name] for name in names]).digest


@pytest.mark.parametrize(
    "law, told",
    cases("""
    pid | guard.enabled = false
    mb | guard.enabled = true
    mb | guard.enabled = true; actuator.delay = 0.013; actuator.lag = 0.02
    prox | actuator.delay = 0.013; actuator.lag = 0.02
    prox | guard.enabled = true; sensor.velocity_window = 0.02; actuator.jitter = 0.01
    smc | guard.enabled = true; actuator.delay = 0.013; actuator.lag = 0.02 | slow
    nn | guard.enabled = true; guard.map = "rotation-first" | slow
    nn | actuator.delay = 0.013; actuator.lag = 0.02 | slow
    kanayama | guard.enabled = true; sensor.velocity_window = 0.02; actuator.jitter = 0.01 | slow
    pursuit | guard.enabled = true | slow
    """),
)
def test_what_is_watched_and_asked_is_the_controller(law, told):
    """The graphs that entries are about have the compiled text of the exported controller."""
    setup = settle(load_scenario(PRESET, {"clock.control": 0.01, **changes(told)}), law)
    plain, asking = controller.controller(setup), controller.asking_controller(setup)
    names = [*is_told(plain)]

    assert {"tau_right[0]", "tau_left[0]"} <= {*names}
    assert digest(asking, names) == digest(plain, names)
    assert digest(controller.watched_controller(setup), names) == digest(plain, names)
    wish = [f"force[{i}]" for i in (0, 1)]
    assert digest(asking, wish) == digest(controller.law_graph(setup), wish)

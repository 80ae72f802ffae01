"""Entries compare every number of every effect's bound with the effect's graph."""

import ast
import inspect
import textwrap
from copy import copy

import pytest

from wmr_ctrl.results.ledger import REFUTED
from wmr_ctrl.world.effect import PAIRS
from wmr_ctrl.world.registry import OURS
from wmr_proofs.claim import CLAIMED
from wmr_proofs.claims import all_claims
from wmr_proofs.claims.effect_bounds import EffectGraph

pytest.importorskip("z3")

CLAIMS = {claim.id: claim for claim in all_claims()}
COMPARED = {
    "encoder": {"nbar": "world.encoder.v1 world.encoder.omega",
                "window": "world.encoder.v1 world.encoder.omega"},
    "velocity mean": {"age": "world.velocity-mean.bound", "window": "world.velocity-mean.bound",
                      "nbar": "world.velocity-mean.rounding world.velocity-mean.rounding-angular"},
    "gyro": {"nbar": "world.gyro"},
    "velocity noise": {"nbar": "world.velocity-noise"},
    "torque noise": {"dbar": "world.noise.thrust world.noise.moment"},
    "push": {"dbar": "world.push"},
    "gust": {"dbar": "world.gust"},
    "slope": {"dbar": "world.slope"},
    "resistance": {"dbar": "world.resistance.thrust world.resistance.moment"},
    "command delay": {"delay": "world.command-delay.bound"},
    "command loss": {"losses": "world.command-loss.bound"},
    "command dead band": {"dropped": "corridor.dead-band"},
    "wheel commands": {"command": "world.wheel-commands", "dropped": "world.wheel-commands"},
    "command quantum": {"command": "world.command-quantum.bound"},
    "delay": {"delay": "world.delay.bound"},
    "jitter": {"delay": "world.jitter.bound", "jitter": "world.jitter.bound"},
    "motor": {"dbar": "world.motor.bound-thrust world.motor.bound-moment"},
    "lag": {"lag": "world.lag.bound"},
    "wheels": {"dbar": "world.wheels.thrust world.wheels.moment"},
}  # fmt: skip
"""Entries by effect and number of its bound: one for both axes, or one for each."""
MORE = [
    ("encoder", "nbar", 0, "world.wheels.misread-v1"),
    ("encoder", "nbar", 1, "world.wheels.misread-omega"),
    ("lag", "lag", 0, "world.lag.constant"),
    ("lag", "lag", 1, "world.lag.constant"),
]
ONE_AXIS = {("gyro", "nbar"): (1,)}
LEAST = ("lag", "lag", 0)
"""The one number of which less is the weaker bound."""


def rows():
    """Yield (effect, number of its bound, axis, entry); the axis of a single number is None."""
    for effect, numbers in COMPARED.items():
        for number, text in numbers.items():
            if number not in PAIRS:
                yield effect, number, None, text
                continue
            for axis in ONE_AXIS.get((effect, number), (0, 1)):
                yield effect, number, axis, text.split()[axis if " " in text else 0]
    yield from MORE


def numbers_told(effect):
    """Names of the numbers that an effect's bound states anywhere in its text."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(effect.bound)))
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    made = (call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "Bound")
    told = {str(item.arg) for call in made for item in call.keywords}
    return told - {"hidden", "overshoots", "void"}


@pytest.mark.parametrize("effect", OURS, ids=lambda effect: effect.name)
def test_every_number_of_a_bound_has_an_entry(effect):
    assert numbers_told(effect) == set(COMPARED.get(effect.name, ()))


@pytest.mark.parametrize("effect, number, axis, key", [*rows()])
def test_half_a_bound_is_refuted(monkeypatch, effect, number, axis, key):
    original, halved = EffectGraph._bounded, []

    def half(self, share):
        told, trace = original(self, share)
        if self.effect.name != effect:
            return told, trace
        factor = 2.0 if (effect, number, axis) == LEAST else 0.5
        value = getattr(told, number)
        pair = value if isinstance(value, tuple) else (value,)
        less = tuple(factor * item if axis in (None, i) else item for i, item in enumerate(pair))
        told = copy(told)  # not made anew: that would compare the numbers once more
        object.__setattr__(told, number, less if isinstance(value, tuple) else less[0])
        halved.append(number)
        return told, trace

    claim = CLAIMS[key]
    monkeypatch.setattr(EffectGraph, "_bounded", half)
    assert claim.method.decide(claim.statement(CLAIMED)).verdict == REFUTED
    assert halved

"""Entries about guard, filter, gate, prox and corridor hold as they are worded.

Numbers are drawn from the hypotheses in the words, including their boundaries.  The product's own
functions and whole graphs are evaluated in doubles.  The goals are written a second time here.
"""

from fnmatch import fnmatchcase
from itertools import chain

import numpy as np
import pytest

from tests.proofs import worded, worded_filter, worded_guard, worded_laws, worded_stops
from tests.proofs.anew import altered
from tests.proofs.worded import CHECKS, NEAR, SAMPLES
from wmr_ctrl.control.filter import channels
from wmr_ctrl.control.guard import guard
from wmr_ctrl.results.ledger import load

FAMILIES = ("guard.", "filter.", "gate.", "corridor.", "prox.")
MODULES = (worded_guard, worded_filter, worded_laws, worded_stops)
EACH = list(dict.fromkeys(chain.from_iterable(CHECKS.values())))
NOT_SAMPLED = {
    "*.rounding.*": "about every rounding; tests/control/filter and tests/control/guard",
    "guard.*rounding": "about every rounding; tests/control/guard",
    "guard.flag.*": "about every rounding",
    "guard.assembled*": "graphs equal to other graphs; tests/control/guard/test_guard.py",
    "guard.axes": "an equality of graphs",
    "guard.sides": "an equality of graphs; tests/control/guard/test_guard_sides.py",
    "guard.simulated": "a step of the plant; tests/control/guard/test_guard_runs.py",
    "guard.monitor-late": "numbers of one example; tests/control/guard/test_lateness_any.py",
    "guard.delay.queue": "an equality of sums",
    "guard.delay.step": "one term of guard.delay.command",
    "guard.late.tail": "an equality of one example",
    "guard.late.rest": "an example",
    "guard.late.mean-piece": "an example; tests/control/guard/test_lateness.py",
    "guard.falling": "drives; tests/control/guard/test_changing.py",
    "guard.varying.*": "rooms behind a lag; tests/control/guard/late_formula.py",
    "filter.swung*": "loops that swing; tests/control/filter/test_filter_sides.py",
    "filter.in-time": "a count; tests/control/filter/test_filter_times.py",
    "filter.held-*": "steps of a run; tests/control/filter/test_held_loop.py",
    "filter.free.brake": "a sign",
    "filter.free.way": "distances of drives; tests/control/filter/test_ways.py",
    "filter.free.real": "distances of drives; tests/control/filter/test_ways.py",
    "filter.free.ramp": "a root; tests/control/filter/test_ramp_stop.py",
    "filter.leave.away": "signs",
    "filter.band.*": "tables; tests/control/filter/test_band.py",
    "prox.decay*": "values of V1 as free numbers",
    "prox.rises": "values of V1 as free numbers",
    "prox.assembled*": "graphs equal to other graphs",
    "prox.force*": "an equality of graphs",
    "prox.pushed*": "sums of terms of other entries",
    "prox.limit*": "sums of terms of other entries",
    "prox.gain.*": "sums of terms of other entries",
    "prox.observer*": "an equality of graphs",
    "prox.loop-*": "an equality of graphs",
    "prox.newton*": "V1 as a logarithm",
    "prox.smooth-ratio": "by ring, in cases",
    "corridor.dead-band": "tests/corridor/sending.py",
    "corridor.wheel-speed": "tests/corridor/sending.py",
    "corridor.pi-loop": "an equality of graphs",
    "corridor.guard-late": "benchmarks/corridor_late.py",
    "corridor.jitter": "tests/corridor/test_jitter.py",
    "corridor.ramp": "tests/corridor/sending.py",
}
"""Entries that no check is about, and why, or what tries them; a check goes first."""


def test_every_entry_of_these_families_is_sampled_or_named():
    ids = [e.id for e in load().entries if e.verdict in ("PROVED", "LEMMA")]
    ours = {key for key in ids if key.startswith(FAMILIES)}
    rest = ours - CHECKS.keys()

    assert CHECKS.keys() - ours == set()
    assert [key for key in sorted(rest) if not any(fnmatchcase(key, n) for n in NOT_SAMPLED)] == []
    assert [n for n in NOT_SAMPLED if not any(fnmatchcase(key, n) for key in rest)] == []


@pytest.mark.slow
@pytest.mark.parametrize("check", EACH, ids=lambda check: check.__name__)
def test_no_sample_breaks_a_claim_as_it_is_worded(check):
    for goal, spare in check(np.random.default_rng(61)).items():
        assert spare.shape == (SAMPLES,)
        assert spare.min() >= -NEAR, f"{check.__name__}: {goal} misses by {-spare.min():.3g}"


ALTERED = (
    (worded_guard.at_once, guard.ceiling, "- b.net", "- 0.99 * b.net"),
    (worded_guard.delayed, worded_guard.late_guard.largest_force, "b.braking + b.net", "b.braking"),
    (worded_stops.lowered, worded_stops.ways.told_command, "ca.fmin(b.kappa", "ca.fmax(b.kappa"),
    (worded_stops.left_behind, worded_stops.ways.Stop.retreat, "self.creep", "0"),
    (worded_filter.governed_wheels, channels.channels_of, "d[0] + l * d[1]", "d[0] + l * d[1] / 2"),
)


@pytest.mark.slow
@pytest.mark.parametrize("check, function, old, new", ALTERED)
def test_samples_notice_an_altered_formula(check, function, old, new):
    with altered(function, old, new):
        found = check(np.random.default_rng(61))
    assert min(spare.min() for spare in found.values()) < -NEAR


def test_checks_are_those_of_the_modules():
    assert {check.__module__ for check in EACH} == {module.__name__ for module in MODULES}
    assert worded.SAMPLES == 100_000

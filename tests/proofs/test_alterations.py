"""After altering one sign or constant in barrier, laws or model, the ledger's verdict changes.

Only entries whose graph contains the altered part are checked.
"""

import pytest

from tests.proofs.anew import altered, claim_of, verdict
from wmr_ctrl.control.barrier import stable as stable_barrier
from wmr_ctrl.control.laws import mb, nn
from wmr_ctrl.results.ledger import load
from wmr_ctrl.world.model import dynamics, kinematics
from wmr_proofs import paper_barrier as barrier
from wmr_proofs.alterations import built
from wmr_proofs.claims import all_claims
from wmr_proofs.entry import graph_hash

AXIS, SMOOTH = stable_barrier.Axis, stable_barrier.SmoothAxis
GRADIENT = '0.5 * context.per_axis("w") / context.per_axis("q")'
"""A/2, which v' = -(rho/2) dV1/dv has where law (9) has V1/A."""
ALTERATIONS = [
    (barrier.a_term, "v - c", "v + c", "eq74"),
    (barrier.a_term, "sign(v)", "-sign(v)", "eq74"),
    (barrier.f, "-log", "log", "eq22"),
    (barrier.minimiser, "+ 4", "+ 5", "eq18.stationary"),
    (barrier.minimiser, "1 / (u1 - u2)", "2 / (u1 - u2)", "eq18.stationary"),
    (barrier.g, "0.5 *", "0.4 *", "eq78"),
    (barrier.lyapunov, "0.5 *", "0.6 *", "eq76-77 eq20"),
    (AXIS.far_slope.func, "t * t + 4", "t * t + 5", "forms.v_c1"),
    (AXIS.divisor.func, "1 + curvature", "1 - curvature", "forms.q"),
    (AXIS.lyapunov.func, "0.5 *", "0.6 *", "forms.V1"),
    (stable_barrier._chi, "1 / order", "1 / (order + 1)", "forms.series"),
    (mb.build, 'context.per_axis("q")', '2 * context.per_axis("q")', "P8"),
    (mb.build, 'context.per_axis("V1_over_A")', GRADIENT, "gain.none"),
    (mb.build, 'context.per_axis("V1_over_A")', GRADIENT, "gain.none-smooth"),
    (mb.decay_rate, "-ca.expm1", "-2 * ca.expm1", "prox.newton-side"),
    (mb.decay_rate, "-ca.expm1", "-2 * ca.expm1", "prox.newton"),
    (barrier.f, "(u1 - abs(v)) / (u1 - u2)", "(u1 - abs(v)) ** 2", "convex"),
    (barrier.a_term, "u1 - abs(v)", "2 * (u1 - abs(v))", "convex"),
    (barrier.f, "-log", "log", "gain.ceiling"),
    (SMOOTH.divisor.func, "1 + ca.if_else", "2 + ca.if_else", "prox.smooth-ratio"),
    (SMOOTH.p.func, "(product + 1)", "(product + 2)", "smooth.v_c1"),
    (AXIS.lyapunov.func, "0.5 *", "0.6 *", "smooth.slope"),
    (nn._adapted, "* weights - learning", "* weights + learning", "eq58"),
    (nn.build, '-context.gain("rho1")', 'context.gain("rho1")', "eq57"),
    (nn.corner_basis, "-4 * node", "-2 * node", "eq58.basis"),
    (kinematics.auxiliary_velocity, "k[2] * ca.sin", "-k[2] * ca.sin", "eq37"),
    (kinematics.error_rate, "- v[0]", "+ v[0]", "eq33-35"),
    (kinematics.tracking_error, "-c * d[0]", "c * d[0]", "eq33-35"),
    (kinematics.pose_rate, "-ca.sin", "ca.sin", "eq03"),
    (dynamics.wheel_to_force, "tau[0] - tau[1]", "tau[0] + tau[1]", "eq04.wheels"),
    (dynamics.acceleration, "force - friction_force", "force + friction_force", "eq04.plant"),
]


@pytest.mark.parametrize(
    "function, old, new, ids",
    ALTERATIONS,
    ids=[f"{row[0].__qualname__}: {row[2]}" for row in ALTERATIONS],
)
@pytest.mark.slow_but("f: log1")
def test_an_alteration_changes_a_verdict(function, old, new, ids):
    assert changes_a_verdict(function, old, new, ids)


def changes_a_verdict(function, old, new, ids):
    """The first of the entries ``ids`` whose verdict the alteration changes; empty if none."""
    committed = load().by_id()
    claims = [claim for claim in all_claims() if claim.id in ids.split()]
    with altered(function, old, new):
        touched = [c for c in claims if graph_hash(c) != committed[c.id].graph_hash]
        assert touched, "the graph does not hold the altered part"
        changed = (c.id for c in touched if verdict(c) != committed[c.id].verdict)
        return next(changed, "")


def test_what_nobody_stated_stays_so_where_results_are_altered():
    """The guard of an altered `settle` has one limit for both directions, as stated."""
    claim = next(item for item in all_claims() if item.id.startswith("guard.assembled"))
    changed = built(claim, {"wmr_ctrl.control.setup:settle": lambda value: 1.25 * value})

    assert "limits.v_u1[1]" in changed.parts["linear-first"].symbols


def test_the_original_is_put_back():
    claim = claim_of("eq74")
    before = graph_hash(claim)
    with altered(barrier.a_term, "v - c", "v + c"):
        assert graph_hash(claim) != before

    assert graph_hash(claim) == before

"""What only a person's argument closes (docs/lemmas.md has the arguments), and what stays open."""

from __future__ import annotations

from wmr_ctrl.proofs.claim import CORRECTED, OURS, PRINTED, Claim, Claims
from wmr_ctrl.proofs.ledger import HAND, OPEN


def _hand(
    key: str,
    equations: tuple[int, ...],
    claim: str,
    meaning: str,
    premises: tuple[str, ...] = (),
    form: str = OURS,
) -> Claim:
    return Claim(key, equations, form, claim, meaning, verdict="HAND", premises=premises)


def _open(
    key: str, equations: tuple[int, ...], claim: str, meaning: str, premises: tuple[str, ...] = ()
) -> Claim:
    return Claim(key, equations, PRINTED, claim, meaning, verdict="OPEN", premises=premises)


claim = Claims()


@claim("lemma.log", (15,), by=HAND)
def lemma_log() -> None:
    """ln t <= t - 1 for t > 0.

    The one fact about the logarithm that the exact algebra uses.
    """


@claim("lemma.sine", (40, 46, 55), by=HAND)
def lemma_sine() -> None:
    """1 - cos t <= t^2/2, |sin t| <= |t|, and |sin t| >= (2/pi)|t| for |t| <= pi/2.

    What the window argument uses about the angle.
    """


@claim("lemma.integration", (41,), by=HAND)
def lemma_integration() -> None:
    """a bound of a derivative, integrated, bounds the function; a derivative bound that holds off
    finitely many points is enough for a continuous function.

    From rates to values.
    """


@claim("lemma.almost-everywhere", (30,), by=HAND, premises="eq30.printed")
def lemma_almost_everywhere() -> None:
    """V1 is locally Lipschitz in (v, v_c0) inside the limits; along an absolutely continuous motion
    it is absolutely continuous, and at almost every time either |v| != v_u2 or v' = 0.

    Why the corner at v_u2 does no harm in time.
    """


@claim("lemma.comparison", (9,), by=HAND, premises="authority.rises")
def lemma_comparison() -> None:
    """a scalar motion with v' <= 0 at a level never crosses it from below; with v' >= m > 0 up to
    the level it does.

    From the sign of the acceleration to whether the limit is kept.
    """


@claim("lemma.sampling", (9,), by=HAND)
def lemma_sampling() -> None:
    """if |v| <= L implies the same one period later for every disturbance constant over the period,
    |v| <= L holds at all samples by induction, and between them because v moves on a straight line.

    From one sample to all times. A disturbance that varies within the period counts by its mean;
    then the statement is about the samples.
    """


@claim(
    "prox.gain",
    by=HAND,
    premises="prox.pushed prox.pushed-angular prox.observer prox.observer-angular "
    "prox.observer-bound prox.observer-bound-angular",
)
def prox_gain() -> None:
    """sampled-data law, mass right: limsup |w| <= (T p/M + eps + E r)/(1 - E), p <= min(2 sup |d|,
    sup |d - d_old|/L) + eta.

    A bounded push leaves a bounded distance to the target, from every start and at every speed, for
    every period.
    """


@claim(
    "prox.limit",
    by=HAND,
    premises="prox.margin prox.margin-smooth prox.pushed prox.pushed-angular transport.inside "
    "transport.inside-smooth",
)
def prox_limit() -> None:
    """sampled-data law, mass right, no guard, torque not limited: |v_0| <= v_u1, |c+| <= C and T
    p/M <= m at every sample keep |v| <= v_u1 at the samples.

    What the law keeps by itself; the guard keeps it for more.
    """


@claim(
    "prox.any-mass",
    by=HAND,
    premises="prox.any-mass.step prox.any-mass.step-gentle prox.not-expansive prox.optimal "
    "prox.optimal-smooth",
)
def prox_any_mass() -> None:
    """target held, no disturbance, M/M^ in [3/5, 8/5] and another one in each sample: w and f go to
    0, by 0.93 a sample for L = 0.3 and 1 - E >= 1/4, by 0.993 for L = 0.07 and 1 - E >= 1/10,
    barrier or not.

    A mass believed wrong by that much does not make the velocity cycle around a target that is
    held.
    """


@claim("assumption.libm", (15,), by=HAND)
def assumption_libm() -> None:
    """log, exp and tanh of the C library are right to 2^-51 relative, and + - * / sqrt are rounded
    as IEEE 754 says, without fused multiply-add.

    A test compares the library with 300-bit arithmetic on random arguments; the compiler's flags
    forbid contraction.
    """


@claim("thm1.limits", (9, 30), form=PRINTED, by=HAND, premises="eq30")
def thm1_limits() -> None:
    """(Theorem 1) with the exact model and no disturbance |v_i| < v_u1i for ever.

    True, because V1 would have to become infinite at the limit; but a disturbance, which the
    theorem does not have, changes this (authority.*).
    """


@claim("thm1.velocity", (30,), form=PRINTED, by=HAND, premises="eq30 eq81")
def thm1_velocity() -> None:
    """(Theorem 1) z -> 0 where |v_c0i| < v_u2i.

    True under the same hypotheses.
    """


@claim("thm1.local", (31, 39), form=CORRECTED, by=HAND, premises="level.invariant strict.rate")
def thm1_local() -> None:
    """e -> 0 from V2 < min(2/k2, ((v_u22 - |v2d|)/(k2 v1d))^2/2) once v follows v_c1, for constant
    v1d > 0.

    What remains of the theorem's global claim; by level.invariant and LaSalle.
    """


@claim("thm1.window", (39, 40, 56), form=PRINTED, by=OPEN, premises="eq55 eq56 eq61.omega")
def thm1_window() -> None:
    """(Theorem 1) as a whole: the windows of length T, put one after the other, bring e into
    Omega_1.

    Every algebraic step is an entry; that the windows can be chained, and that Omega_1 is ever
    needed when strict.rate is at hand, is not shown.
    """


@claim(
    "thm2.bounded",
    (59, 60, 61, 85),
    form=PRINTED,
    by=OPEN,
    premises="eq59.printed eq84-85 eq60.step",
)
def thm2_bounded() -> None:
    """(Theorem 2) the network law keeps the limits and brings z and e into Omega_2 and Omega_3.

    The proof assumes that eps2 is bounded, which fails in the middle region (eq59.printed), and it
    has no disturbance. Where |v| <= v_u2 and |v_c0| < v_u2 the steps (63)-(85) hold.
    """

"""The command filter: its limit on bases with a first-order speed loop; 0 is never refused.

One axis, all numbers symbols.  tau, K and d may vary while a command acts, so the speed is v(t) =
E v_0 + (1 - E) m with E = exp(-int dt/tau) and m a mean of K u + d (filter.mean).
"""

from casadi import SX, fmax, fmin

from wmr_ctrl.control.filter import governor
from wmr_ctrl.control.filter.governor import FirstOrder, drive, drive_back, largest_command
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Named, Relations, Statement, between, positive, symbols

NUMBERS = "V dbar nbar K_min K_max kappa"


claim = Claims()


def sound(b: FirstOrder) -> Relations:
    """0 < K_min <= K_max, 0 <= dbar < V."""
    return _signs(b), b.dbar < b.V


def admits(b: FirstOrder) -> Relations:
    """0 < K_min <= K_max, 0 <= dbar <= V."""
    return _signs(b), b.dbar <= b.V


def _signs(b: FirstOrder) -> Relations:
    return b.K_min > 0, b.K_max >= b.K_min, b.dbar >= 0


class FilterAxis(Named):
    """Symbols of one axis: the filter's numbers, a command, and the base's response.

    e is exp(-H/tau_min), E the share of the old speed that is left.
    """

    def __init__(self) -> None:
        self.symbols = symbols(f"{NUMBERS} u v v_bar K d mean E e", NUMBERS)
        self.bounds = FirstOrder(**{name: self[name] for name in NUMBERS.split()})

    @property
    def hi(self) -> SX:
        """Largest command that is safe."""
        return largest_command(self.v_bar, self.bounds)

    @property
    def relaxing(self) -> Relations:
        """0 < e <= E <= 1 and kappa = e/(1 - e), e < 1."""
        e, E = self.e, self.E
        ratio = self.kappa * (1 - e) == e
        return e > 0, e < 1, between(e, E, 1), ratio


@claim("filter.drive")
def driven(mutation: Mutation) -> Statement:
    """K u + d <= drive(u) <= max(K_max u, 0) + dbar, and the same of -u and drive_back(u), for
    every u.

    The speed towards which a command can drive the base, gain and push at their worst.

    Given: {ANY_SIDE}.
    """
    a = FilterAxis()
    inside = between(a.K_min, a.K, a.K_max)
    given = admits(a.bounds), inside, a.dbar >= mutation(1, 0.9) * a.d
    u, b, reached = a.u, a.bounds, a.K * a.u
    ahead, back = drive(u, b), drive_back(u, b)
    least = ahead >= reached + a.d, back >= a.d - reached
    most = highest(u, b) >= ahead, highest(-u, b) >= back
    return Statement(a, (least, most), given)


def highest(u: SX, b: FirstOrder) -> SX:
    """Bound of drive(u)."""
    return fmax(b.K_max * u, 0) + b.dbar


@claim(
    "filter.inside",
)
def inside(mutation: Mutation) -> Statement:
    """E v + (1 - E) mean <= V.

    A command that takes over at a speed of at most v_bar never drives the base past its limit, for
    as long as it may act.

    Given: {ANY_SIDE}; v <= v_bar <= V; mean <= drive(u), u <= hi(v_bar); e <= E <= 1 with e =
    exp(-H/tau_min), kappa = e/(1 - e).
    """
    a = FilterAxis()
    b, E = a.bounds, a.E
    known = a.v_bar >= a.v, mutation(1, 0.99) * a.v_bar <= b.V
    sent = a.hi >= a.u, drive(a.u, b) >= a.mean
    goal = E * a.v + (1 - E) * a.mean <= b.V
    return Statement(a, goal, (admits(a.bounds), a.relaxing, known, sent))


@claim("filter.contains-clip")
def contains_clip(mutation: Mutation) -> Statement:
    """hi(v_bar) >= (V - dbar)/K_max >= 0, and hi(V) is that.

    The governor is never stricter than the clip, and never refuses to stop: 0 is always safe.

    Given: {ANY_SIDE}; v_bar <= V, kappa >= 0.
    """
    a = FilterAxis()
    b = a.bounds
    smallest = (b.V - b.dbar) / b.K_max
    given = admits(a.bounds), mutation(1, 0.99) * a.v_bar <= b.V, b.kappa >= 0
    goals = a.hi >= smallest, smallest >= 0, largest_command(b.V, b) == smallest
    return Statement(a, goals, given)


@claim(
    "filter.necessary",
)
def necessary(mutation: Mutation) -> Statement:
    """e v_bar + (1 - e)(K_max u + dbar) > V.

    No larger command is safe for the base with the largest gain, the smallest time constant and the
    largest push.

    Given: {ANY_SIDE}; 0 <= u, hi(v_bar) < u; e = exp(-H/tau_min), kappa = e/(1 - e).
    """
    a = FilterAxis()
    b, e = a.bounds, a.e
    given = admits(a.bounds), a.relaxing, a.u > mutation(1, 0.99) * a.hi, a.u >= 0
    end = e * a.v_bar + (1 - e) * (b.K_max * a.u + b.dbar)
    return Statement(a, end > b.V, given)


@claim(
    "filter.estimate",
)
def estimate(mutation: Mutation) -> Statement:
    """v + share (mean - v) <= relaxed(w, target).

    The bound on the speed that is carried from sample to sample remains a bound.

    Given: v <= w, mean <= target, 0 <= least <= share <= most <= 1 (least = 1 - exp(-t/tau_max),
    most = 1 - exp(-t/tau_min)).
    """
    t = symbols("v w mean target least share most")
    v, w, mean, target, least, share, most = t.values()
    bounds = w >= v, target >= mean, least >= 0
    shares = between(mutation(1, 0.9) * least, share, most), most <= 1
    end = governor.relaxed(w, target, most, least)
    goal = end >= v + share * (mean - v)
    return Statement(t, goal, (bounds, shares))


@claim("filter.curvature")
def curvature(mutation: Mutation) -> Statement:
    """0 < eta <= 1 and lo_i <= eta r_i <= hi_i with eta the smaller of both axes' shares.

    One factor scales both axes, so omega/v stays as asked for.

    Given: lo_i < 0 < hi_i; both axes' commands r_i of any size.
    """
    t = symbols("r1 lo1 hi1 r2 lo2 hi2")
    r, lo, hi = ([t[f"{name}{i}"] for i in (1, 2)] for name in ("r", "lo", "hi"))
    eta = mutation(1, 1.01) * fmin(*governor.admitted(r, lo, hi))
    goals = [eta > 0, eta <= 1]
    goals += [hi[i] >= eta * r[i] for i in (0, 1)]
    goals += [eta * r[i] >= lo[i] for i in (0, 1)]
    return Statement(t, goals, positive(*hi, *(-item for item in lo)))

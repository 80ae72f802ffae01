"""The regions of `wmr_proofs.regions` cover the whole domain, and each chart covers all of its
region.
"""

from functools import reduce

from casadi import SX, eq, if_else, logic_and, logic_or

from wmr_ctrl.control.barrier.stable import SmoothAxis
from wmr_proofs import paper_barrier as barrier
from wmr_proofs import regions
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Relations, Statement, positive, symbols

from .common import barrier_axis


def _bounds(u2: SX, b: SX) -> dict[str, tuple[SX, SX | None]]:
    """Open interval of each region's size; None: no bound."""
    edge = u2 + 1 / b
    return {
        "near": (SX(0), u2), "middle": (u2, edge), "far": (edge, None), "beyond": (u2, None),
        "in": (SX(0), u2), "out": (u2, u2 + b),
    }  # fmt: skip


def _inside(size: SX, region: str, u2: SX, b: SX) -> SX:
    points = {"zero": SX(0), "corner": u2, "edge": u2 + 1 / b, "kink": u2}
    if region in points:
        return eq(size, points[region])
    low, high = _bounds(u2, b)[region]
    return size > low if high is None else logic_and(size > low, size < high)


def _member(value: SX, name: str, u2: SX, b: SX) -> SX:
    """True if ``value`` lies in a signed region such as ``middle-``."""
    if name == "zero":
        return eq(value, 0)
    return _inside(-value if name.endswith("-") else value, name[:-1], u2, b)


LISTS = (
    {"key": "targets", "equations": (18,), "index": 1, "number": 11, "of": "v_c0",
     "all": "the real line", "names": (*regions.TARGETS, *regions.TARGET_EDGES)},
    {"key": "sides", "equations": (15,), "index": 0, "number": 7, "of": "v", "all": "|v| < v_u1",
     "names": (*regions.SIDES, *regions.SIDE_EDGES)},
    {"key": "smooth-targets", "index": 1, "number": 7, "of": "v_c0 for the smooth barrier",
     "all": "the real line", "names": regions.SMOOTH_TARGETS},
)  # fmt: skip
WHY = "The claims are shown region by region, and no region is left out."
claim = Claims(meaning=WHY)


@claim("cover.{key}", over=LISTS)
def covered(mutation: Mutation, names: tuple[str, ...], index: int) -> Statement:
    """the {number} regions and boundaries of {of} together cover {all}.

    Given: 0 < v_u2 < v_u1.
    """
    a, _, _, u1, u2 = barrier_axis()
    hits = (_member(a.all[index], name, u2, u1 - u2) for name in mutation(names, names[1:]))
    return a.states(if_else(reduce(logic_or, hits), 1, 0) > 0, given=a.inside)


@claim("cover.charts", (15, 18))
def charted(mutation: Mutation) -> Statement:
    """each chart of a bounded region covers all of it.

    Given: v_u2 > 0, b = v_u1 - v_u2 > 0, 0 < y < 1, n = y/(1 - y).
    """
    t = symbols("y u2 b")
    y, u2, b = t.values()
    n = y / (1 - y)
    goals: list[Relations] = []
    for name in ("near", "middle", "in", "out"):
        value = regions.side_value if name in ("in", "out") else regions.target_value
        low, high = _bounds(u2, b)[name]
        assert high is not None
        goals.append(value(f"{name}+", u2, b, n) == low + mutation * y * (high - low))
    return Statement(t, goals, (y > 0, y < 1, positive(u2, b)))


@claim("cover.numbers", (15, 18))
def reached(mutation: Mutation) -> Statement:
    """n/(1 + n) takes every value between 0 and 1 at a positive n."""
    t = symbols("y")
    y = t.y
    n = y / (1 - y)
    return Statement(t, (n > 0, n / (1 + n) == mutation * y), (y > 0, y < 1))


@claim("cover.far", (18,))
def far_reached(mutation: Mutation) -> Statement:
    """beyond v_u2 + 1/b every v_c0 is u1 - d + 1/d at a gap d between 0 and b.

    Given: 0 < v_u2 < v_u1, v_c0 > v_u2 + 1/(v_u1 - v_u2); mirrored for v_c0 < 0.
    """
    # For |v_c0| > v_u2 + 1/b the gap d of the compiled formula lies in (0, b), and the chart at it
    # gives v_c0 back: target_value("far+") with d = b/(1 + j).
    a, _, c, u1, u2 = barrier_axis()
    b = u1 - u2
    d = u1 - barrier.minimiser(c, u1, u2)
    goals = d > 0, b > d, u1 - d + mutation / d == c
    return a.states(goals, given=(a.inside, (c - u2) * b > 1, c > u2 + 1 / b))


@claim("cover.beyond")
def beyond_reached(mutation: Mutation) -> Statement:
    """smooth barrier: beyond v_u2 every v_c0 is u1 - d + 1/d - 1/b at a gap d between 0 and b.

    Given: 0 < v_u2 < v_u1 = v_u2 + b, v_u2 < v_c0 < 1e100; mirrored for v_c0 < 0.
    """
    # The same beyond v_u2 for the smooth barrier: target_value("beyond+") with d = b/(1 + j).
    a, v, c, u1, u2 = barrier_axis()
    b, d = u1 - u2, SmoothAxis(c, v, u1, u2).d
    goals = d > 0, b > d, u1 - d + mutation / d - 1 / b == c
    return a.states(goals, given=(a.inside, c > u2, c < 1e100))


@claim("cover.order", (15, 18))
def ordered(mutation: Mutation) -> Statement:
    """where |v| and |v_c1| share an interval, one of the three orders holds, and each has its
    chart.

    Given: i, j > 0.
    """
    t = symbols("i j")
    i, j = t.values()
    more, less = i - j, i / (j - i)
    below = if_else(i < j, abs(j * less / (1 + less) - mutation * i), 0)
    sign = if_else(i > j, more, if_else(i < j, less, 1))
    return Statement(t, (if_else(i > j, abs(j + more - i), below) == 0, sign > 0), positive(i, j))

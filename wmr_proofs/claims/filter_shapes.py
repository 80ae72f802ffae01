"""The command filter's graphs in variants that other entries do not cover.

Limits of wheels, in place of those of v and omega or beside them; every way to scale; samples with
jitter, commands that are lost or held.  Each entry is about all scales, sides or axes of its
variant.
"""

from casadi import SX, expm1, fmax, logic_or, vertsplit

from wmr_ctrl.control.filter.channels import WAYS
from wmr_ctrl.control.filter.clip import Clip
from wmr_ctrl.control.filter.governor import NEAR, drive, drive_back
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Cuts,
    Group,
    Relations,
    Statement,
    Symbols,
    between,
    nonnegative,
    positive,
    symbols,
    when,
    within,
)

from .command_filter import BESIDE, SEEN, SHAPES, STATED, WHEELED, Keys, arms, sound
from .common import elements_of, ports_of
from .filter_loops import LINEAR, SLOW

claim = Claims()
CLIPPED: Keys = {key: value for key, value in STATED.items() if key != "filter.odometry"}
CLIPPED |= {"filter.kind": "clip"}


def governor(more: Keys) -> Governor:
    """The governor of `command_filter` with other settings."""
    return Governor(load_scenario("paper-simulation", STATED | more))


def named_for(table: Symbols, scale: str) -> Symbols:
    """Symbols of one scale's graph, under names of their own."""
    return Symbols({f"{name} {scale}": symbol for name, symbol in table.items()})


def _clip(stated: Keys) -> Clip:
    return Clip(load_scenario("paper-simulation", stated))


@claim(
    "filter.sent-clip",
    each={
        f"{loop} {name}": {"more": stated | shape["more"]}
        for loop, stated in (("first", CLIPPED), ("linear", LINEAR))
        for name, shape in SHAPES.items()
    },
)
def sent_clip(mutation: Mutation, more: Keys) -> Statement:
    """|w| <= (V - dbar)/K_max, w each limited speed of the command that the whole clip sends to
    first-order loops or linear ones: v and omega, both wheels, or all of these, in each way to
    scale but one factor beside wheels.

    For any request, commands stay within the range that the loop's gain admits, at the wheels as
    well.

    Given: {COMMANDS}; l > 0; one limit for both directions; (V - dbar)/K_max > 0 of each speed, V
    less 2^-26 of it, N and delta in the places of K_max and dbar where loops are linear; {PLAIN}.
    """
    clip, goals = _clip(more), Group()
    cuts = {"numbers are sound": clip.sound}
    for i, (channel, limit) in enumerate(zip(clip.channels, clip.limits, strict=True)):
        cuts[f"limit {i}"] = limit
        goals += within(channel.of(clip.sent), mutation(1, 0.99) * limit)
    given = positive(*clip.limits), arms(clip.channels)
    return Statement(elements_of(clip.asked, *clip.p.ports), goals, given, cuts)


@claim("filter.clip", premises="filter.drive", each=SHAPES)
def clip_step(mutation: Mutation, more: Keys) -> Statement:
    """|w| <= V at a sample implies |E w + (1 - E) mean| <= V up to the next one, which is |w| <= V
    again, w each limited speed, for any request: v and omega, both wheels, or all of these, with
    each way to scale except one factor beside wheels.

    A step of the induction over samples (filter.mean). The memoryless clip (V - dbar)/K_max keeps
    the limit without odometry and time constants.

    Given: {COMMANDS}; l > 0, 0 < K_min <= K_max, 0 <= dbar < V of each speed, V less 2^-26 of it,
    one for both directions; -drive_back(u) <= mean <= drive(u), u the speed that is sent
    (filter.drive); 0 <= E <= 1; {PLAIN}.
    """
    clip = _clip(CLIPPED | more)
    table, goals = elements_of(clip.asked, *clip.p.ports), Group()
    given = [arms(clip.channels)]
    for i, channel in enumerate(clip.channels):
        f, b, u = symbols("w mean E"), channel.bounds, channel.of(clip.sent)
        table |= named_for(f, str(i))
        most, least = drive(u, b), -drive_back(u, b)
        given += [sound(b), within(f.w, b.V), between(least, f.mean, most), between(0, f.E, 1)]
        goals += within(f.E * f.w + (1 - f.E) * f.mean, mutation(1, 0.99) * b.V)
    return Statement(table, goals, given, {"numbers are sound": clip.sound})


@claim(
    "filter.slew-sent.together",
    each={scale: {"scale": scale} for scale in ("curvature", "axes", "turn", "drive")},
)
def slew_together(mutation: Mutation, scale: str) -> Statement:
    """|u| <= c and |u - u_before| <= a t on both axes, 0 <= t <= T, u the command that the whole
    clip with slew sends, with one factor for both axes, one for each, or one axis first.

    Commands stay within their limit and change no faster than stated, for any request.

    Given: {COMMANDS}, at any time; {GONE}; v and omega limited, one limit for both directions;
    parameters that are sound, a, T > 0, c = (V (1 - 2^-26) - delta - a reach)/K_max > 0; the
    command before within c; {PLAIN}.
    """
    clip = _clip(SLOW | {"filter.scale": scale})
    (before,), slew = clip.last, clip.p.take("filter.slew")
    cuts, goals = {"numbers are sound": clip.sound}, Group()
    given: list[Relations] = [positive(*vertsplit(slew), *clip.limits, clip.T), clip.sound == 1]
    goals += between(0, clip.time, clip.T)
    for i, limit in enumerate(clip.limits):
        cuts[f"limit {i}"] = limit
        u, was = clip.sent[i], before.sym[i]
        given.append(within(was, limit))
        goals += [within(u, limit), within(u - was, mutation(1, 0.9) * slew[i] * clip.time)]
    table = elements_of(clip.asked, clip.elapsed, *clip.last, *clip.p.ports)
    return Statement(table, goals, given, cuts)


@claim(
    "filter.rims",
    premises="filter.sent",
    each={
        f"{key} {name}-{way}{told}": {"more": more | keys, "side": side, "wheel": wheel}
        for told, keys in SEEN.items()
        for key, more in (("wheels", WHEELED), ("beside", BESIDE))
        for wheel, name in enumerate(("right", "left"))
        for side, way in enumerate(("forwards", "backwards"))
    },
)
def rims(mutation: Mutation, more: Keys, side: int, wheel: int) -> Statement:
    """right and left, forwards and backwards: E w + (1 - E)(K u + d_v +- l d_omega) <= W behind
    every command u that the whole filter admits to the wheel, w = v +- l omega; W = min(V, l Omega)
    (1 - 2^-26) where wheels are limited instead of v and omega, filter.wheel_speed (1 - 2^-26)
    where they are limited beside v and omega.

    The limit of a wheel includes pushes and errors of both axes.

    Given: any odometry within nbar of v and omega, or none, any time since the last sample; the
    stored bounds hold if that time is a period, or given as 0; w within W; one limit for both
    directions; no delay, jitter or losses, H = T; l, T > 0, 0 < tau_min <= tau_max, exp(-T/tau_min)
    <= E <= 1; 0 < K_min <= K <= K_max, |d_v| <= dbar_v, |d_omega| <= dbar_omega, dbar_v + l
    dbar_omega < W; u at most the step's limit (filter.sent); {PLAIN}.
    """
    graph, way = governor(more), WAYS[side]
    f = symbols("v1 v2 u K d1 d2 E kappa gone")
    ports = ports_of(graph.system)
    p = {port.signal.name: port.sym for port in ports}
    push, gain, error = p["filter.d"], p["filter.gain"], p.get("filter.odometry", SX.zeros(2))
    T, tau = graph.T, p["filter.tau"]
    cuts = {"1/(exp(T/tau_min) - 1)": 1 / expm1(T / tau[0]), "-most": expm1(-T / tau[0])}
    cuts["-least"] = expm1(-T / tau[1])
    kappa, most, least = cuts.values()
    cuts |= {f"V {i}": own.bounds.V for i, own in enumerate(graph.channels)}
    came = _timely(graph)
    given: list[Relations] = [
        positive(p["robot.l"], T, gain[0], f.kappa),
        nonnegative(*vertsplit(push), *vertsplit(error)), f.kappa == kappa,
        f.gone == most, -f.kappa * f.gone == 1 + f.gone, positive(-least, 1 + most),
        least >= most, between(1 + most, f.E, 1),
    ]  # fmt: skip
    for i, v in enumerate((f.v1, f.v2)):
        given += when(graph.seen, within(graph.odometry.sym[i] - v, error[i]))
        given += within((f.d1, f.d2)[i], push[i])
    place = len(graph.channels) - 2 + wheel
    channel, b = graph.channels[place], graph.channels[place].bounds
    w, total = channel.of((f.v1, f.v2)), push[0] + p["robot.l"] * push[1]
    given += [between(gain[0], f.K, gain[1]), total < b.V, within(w, b.V)]
    for known, sign in zip(graph.known, WAYS, strict=True):
        given.append(when(came, known.sym[place] >= sign * w))
    given.append(graph.limits[side][place] >= f.u)
    mean = f.K * f.u + mutation(1, 1.1) * way * channel.of((f.d1, f.d2))
    return Statement(f | elements_of(*ports), f.E * way * w + (1 - f.E) * mean <= b.V, given, cuts)


def _timely(graph: Governor) -> SX:
    """1 if a sample came when the filter expects one, within its jitter."""
    elapsed, T = graph.elapsed.sym, graph.T
    return logic_or(elapsed == 0, abs(elapsed - T) <= (graph.plans[0].jitter + NEAR) * T)


@claim(
    "filter.assembled.late",
    premises="filter.sent",
    each={
        "jitter": {"more": {"filter.jitter": 0.005}},
        "losses": {"more": {"filter.losses": 2}},
        "hold": {"more": {"filter.hold": 0.05}},
    },
)
def assembled(mutation: Mutation, more: Keys) -> Statement:
    """either axis, either way: E v + (1 - E) mean <= V behind every command u that the whole filter
    admits, mean at most what u or, once the base has stopped, pushes alone lead to: for a jitter of
    T/2, H = 3 T/2; two commands lost in a row, H = 3 T; a base that keeps its command for 5 T and
    stops then, H = 5 T.

    A command may act for longer than a period, and the filter takes that into account.

    Given: any odometry within nbar, or none, any time since the last sample; the stored bounds hold
    where every command that may act was sent in time; |v| <= V, one limit for both directions less
    2^-26 of it; v and omega limited; T > 0, 0 < tau_min <= tau_max; {INTERVALS}; exp(-H/tau_min) <=
    E <= 1; u at most the step's limit; mean <= max(drive(u), dbar); {PLAIN}.
    """
    graph = governor(more)
    table, cuts = elements_of(*ports_of(graph.system)), Cuts()
    T, goals, given = graph.T, Group(), list[Relations]([graph.T > 0])
    seen = graph.age.sym >= -NEAR * T
    for axis, motion in enumerate(graph.motions[0]):
        b, (low, _) = motion.bounds, motion.tau
        v, known_kappa, gone = symbols(f"speed{axis} kappa{axis} gone{axis}").values()
        table |= {f"speed{axis}": v, f"kappa{axis}": known_kappa, f"gone{axis}": gone}
        kappa = 1 / expm1(motion.schedule.longest * T / low)
        cuts[f"1/(exp(H/tau_min) - 1) {axis}"] = kappa
        given += [known_kappa > 0, known_kappa == kappa]
        given += [-known_kappa * gone == 1 + gone, 1 + gone > 0]
        given += [b.dbar < b.V, nonnegative(b.dbar, b.nbar), b.K_min > 0]
        given += [b.K_max >= b.K_min, within(v, b.V)]
        given += when(seen, within(graph.odometry.sym[axis] - v, b.nbar))
        for side, way in enumerate(WAYS):
            own = symbols(f"u{axis}{side} mean{axis}{side} E{axis}{side}")
            u, mean, E = own.values()
            table |= own
            given += [when(graph.punctual, graph.known[side].sym[axis] >= way * v)]
            given += [between(1 + gone, E, 1), graph.limits[side][axis] >= u]
            given.append(fmax(drive(u, b), mutation(1, 9) * b.dbar) >= mean)
            goals.append(E * way * v + (1 - E) * mean <= b.V)
    return Statement(table, goals, given, cuts)

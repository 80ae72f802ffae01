"""The command filter's graphs in variants that other entries do not cover.

Limits of wheels, in place of those of v and omega or beside them; every way to scale; samples with
jitter, commands that are lost or held.  Each entry is about all scales, sides or axes of its
variant.
"""

from typing import TypeAlias

from casadi import SX, expm1, fmax, logic_or, vertsplit

from wmr_ctrl.control.filter.band import BandGovernor
from wmr_ctrl.control.filter.channels import WAYS, Channel
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

from .command_filter import ALIKE, STATED, sound
from .common import elements_of, ports_of
from .filter_band import BANDED
from .filter_loops import LINEAR, SLOW

claim = Claims()
CLIPPED = STATED | {"filter.kind": "clip"}
Keys: TypeAlias = dict[str, object]
"""Keys of a scenario."""
WHEELED: Keys = {"filter.channels": "wheels", **ALIKE}
BESIDE: Keys = {"filter.wheel_speed": 1.0, **ALIKE}
SHAPES: tuple[Keys, ...] = (
    {"key": "axes", "more": {}, "limited": "v and omega, whose bounds differ, each by its own "
     "factor or one first",
     "scales": ("axes", "turn", "drive")},
    {"key": "wheels", "limited": "both wheels' speeds, by one factor or one axis first",
     "more": WHEELED, "scales": ("curvature", "turn", "drive")},
    {"key": "beside", "more": BESIDE, "scales": ("turn", "drive"),
     "limited": "v, omega and both wheels' speeds, one axis first"},
)  # fmt: skip
"""Speeds that are limited, and the ways to scale a command that no other entry is about.

One factor beside limits of wheels is in filter.rounding.beside.
"""


def governor(more: Keys) -> Governor:
    """The governor of `command_filter` with other settings."""
    return Governor(load_scenario("paper-simulation", STATED | more))


def named_for(table: Symbols, scale: str) -> Symbols:
    """Symbols of one scale's graph, under names of their own."""
    return Symbols({f"{name} {scale}": symbol for name, symbol in table.items()})


def _clip(stated: Keys, scale: str) -> Clip:
    told = {key: value for key, value in stated.items() if key != "filter.odometry"}
    return Clip(load_scenario("paper-simulation", told | {"filter.scale": scale}))


def _arms(channels: list[Channel]) -> Relations:
    """The half track of each wheel is positive."""
    return positive(*(channel.arm for channel in channels if channel.ways[1]))


@claim("filter.sent.{key}", premises="filter.limits", over=SHAPES)
def sent(mutation: Mutation, more: Keys, scales: tuple[str, ...]) -> Statement:
    """in the command that the whole governor sends, each limited speed is at most the step's limit,
    in both directions and for any request: {limited}.

    Nothing bypasses the filter, whichever speeds it limits and however it scales.

    Given: {COMMANDS}, any odometry, any time since the last sample; l > 0; the limits above 0.
    """
    table, cuts = Symbols(), Cuts()
    goals, given = Group(), Group()
    for scale in scales:
        graph = governor({**more, "filter.scale": scale})
        table |= named_for(elements_of(*ports_of(graph.system)), scale)
        limits = [
            (f"limit {side} {i} {scale}", limit)
            for side, own in enumerate(graph.limits)
            for i, limit in enumerate(own)
        ]
        cuts |= {**dict(limits), f"numbers are sound {scale}": graph.sound}
        given += positive(*(limit for _, limit in limits)), _arms(graph.channels)
        for side, way in enumerate(WAYS):
            for channel, limit in zip(graph.channels, graph.limits[side], strict=True):
                most = mutation(1, 0.99) * limit
                commands = (graph.sent, graph.safe)
                goals += [most >= way * channel.of(command) for command in commands]
    return Statement(table, goals, given, cuts)


@claim("filter.sent-clip.{key}", over=SHAPES)
def sent_clip(mutation: Mutation, more: Keys, scales: tuple[str, ...]) -> Statement:
    """|w| <= (V - dbar)/K_max, w each limited speed of the command that the whole clip sends to
    first-order loops or linear ones: {limited}; where no wheel is limited, by one factor as well.

    For any request, commands stay within the range that the loop's gain admits, at the wheels as
    well.

    Given: {COMMANDS}; l > 0; (V - dbar)/K_max > 0 of each speed, V less 2^-26 of it, N and delta in
    the places of K_max and dbar where loops are linear.
    """
    table, cuts = Symbols(), Cuts()
    goals, given = Group(), Group()
    for loop, stated in (("first", CLIPPED), ("linear", LINEAR)):
        for scale in scales if more else ("curvature", *scales):
            clip = _clip(stated | more, scale)
            name = f"{scale} {loop}"
            table |= named_for(elements_of(clip.asked, *clip.p.ports), name)
            cuts[f"numbers are sound {name}"] = clip.sound
            given += positive(*clip.limits), _arms(clip.channels)
            for i, (channel, limit) in enumerate(zip(clip.channels, clip.limits, strict=True)):
                cuts[f"limit {i} {name}"] = limit
                goals += within(channel.of(clip.sent), mutation(1, 0.99) * limit)
    return Statement(table, goals, given, cuts)


@claim(
    "filter.clip",
    premises="filter.drive",
    each={
        f"{key} {scale}": {"more": more, "scale": scale}
        for key, more, scales in (
            ("axes", {}, ("curvature", "axes", "turn", "drive")),
            ("wheels", WHEELED, ("curvature", "turn", "drive")),
            ("beside", BESIDE, ("turn", "drive")),
        )
        for scale in scales
    },
)
def clip_step(mutation: Mutation, more: Keys, scale: str) -> Statement:
    """|w| <= V at a sample implies |E w + (1 - E) mean| <= V up to the next one, which is |w| <= V
    again, w each limited speed, for any request: v and omega, both wheels, or all of these, with
    each way to scale except one factor beside wheels.

    A step of the induction over samples (filter.mean). The memoryless clip (V - dbar)/K_max keeps
    the limit without odometry and time constants.

    Given: {COMMANDS}; l > 0, 0 < K_min <= K_max, 0 <= dbar < V of each speed, V less 2^-26 of it;
    -drive_back(u) <= mean <= drive(u), u the speed that is sent (filter.drive); 0 <= E <= 1.
    """
    clip = _clip(CLIPPED | more, scale)
    table, goals = elements_of(clip.asked, *clip.p.ports), Group()
    given = [_arms(clip.channels)]
    for i, channel in enumerate(clip.channels):
        f, b, u = symbols("w mean E"), channel.bounds, channel.of(clip.sent)
        table |= named_for(f, str(i))
        most, least = drive(u, b), -drive_back(u, b)
        given += [sound(b), within(f.w, b.V), between(least, f.mean, most), between(0, f.E, 1)]
        goals += within(f.E * f.w + (1 - f.E) * f.mean, mutation(1, 0.99) * b.V)
    return Statement(table, goals, given, {"numbers are sound": clip.sound})


@claim("filter.slew-sent.together")
def slew_together(mutation: Mutation) -> Statement:
    """|u| <= c and |u - u_before| <= a t on both axes, 0 <= t <= T the time since the sample
    before, u the command that the whole clip with slew sends, with one factor for both axes, one
    for each, or one axis first.

    Commands stay within their limit and change no faster than stated, for any request.

    Given: {COMMANDS}, at any time; parameters that are sound, a, T > 0, c = (V (1 - 2^-26) - delta
    - a reach)/K_max > 0; the command before within c.
    """
    table, cuts = Symbols(), Cuts()
    goals, given = Group(), Group()
    for scale in ("curvature", "axes", "turn", "drive"):
        clip = Clip(load_scenario("paper-simulation", SLOW | {"filter.scale": scale}))
        table |= named_for(elements_of(clip.asked, clip.elapsed, *clip.last, *clip.p.ports), scale)
        (before,), slew = clip.last, clip.p.take("filter.slew")
        cuts |= {f"numbers are sound {scale}": clip.sound}
        cuts |= {f"limit {i} {scale}": limit for i, limit in enumerate(clip.limits)}
        given += positive(*vertsplit(slew), *clip.limits, clip.T)
        given.append(clip.sound == 1)
        goals += between(0, clip.time, clip.T)
        for i, limit in enumerate(clip.limits):
            u, was = clip.sent[i], before.sym[i]
            given += within(was, limit)
            goals += [within(u, limit), within(u - was, mutation(1, 0.9) * slew[i] * clip.time)]
    return Statement(table, goals, given, cuts)


BANDS = (
    {"key": "scales", "loops": "second-order ones, each axis by its own factor or one first",
     "shapes": tuple(BANDED | {"filter.scale": scale} for scale in ("axes", "turn", "drive"))},
    {"key": "pi", "loops": "PI ones, by one factor", "shapes": (
        {"filter.kind": "band", "filter.loop": "pi", "clock.control": 0.1,
         "filter.mass": (50.0, 65.0), "filter.inertia": (4.0, 6.0), "filter.kp": (135.0, 165.0),
         "filter.ki": (270.0, 330.0)},)},
)  # fmt: skip


@claim("filter.band.sent.{key}", over=BANDS)
def band_sent(mutation: Mutation, shapes: tuple[Keys, ...]) -> Statement:
    """u_before - fall <= u <= u_before + rise and |u| <= the largest command that 0 may follow,
    with the command u that the whole band sends on either axis; for loops: {loops}.

    Nothing bypasses the filter: no command and no scaling of the other axis.

    Given: {COMMANDS}, at any time, parameters that are sound; 0 is within the admitted fall and
    rise, and 0 <= the largest command that 0 may follow.
    """
    table, cuts = Symbols(), Cuts()
    goals, given = Group(), Group()
    for number, stated in enumerate(shapes):
        graph = BandGovernor(load_scenario("paper-simulation", stated))
        table |= named_for(elements_of(*ports_of(graph.system)), str(number))
        cuts[f"sound {number}"] = graph.sound
        given.append(graph.sound == 1)
        for axis, (low, high) in enumerate(graph.ends):
            cuts |= {f"end {number} {axis} {k}": end for k, end in enumerate((low, high))}
            cuts[f"stop {number} {axis}"] = graph.stopping[axis]
            given += nonnegative(high, -low, graph.stopping[axis])
            u = mutation(1, 1.1) * graph.sent[axis]
            goals += [between(low, u, high), within(u, graph.stopping[axis])]
    return Statement(table, goals, given, cuts)


WHEELS = (
    {"key": "wheels", "more": WHEELED, "which": "min(V, l Omega)",
     "what": "wheels are limited instead of v and omega"},
    {"key": "beside", "more": BESIDE, "which": "filter.wheel_speed",
     "what": "wheels are limited beside v and omega"},
)  # fmt: skip


@claim(
    "filter.rims.{key}",
    premises="filter.sent.{key}",
    over=WHEELS,
    each={
        f"{name}-{way}": {"side": side, "wheel": wheel}
        for wheel, name in enumerate(("right", "left"))
        for side, way in enumerate(("forwards", "backwards"))
    },
)
def rims(mutation: Mutation, more: Keys, side: int, wheel: int) -> Statement:
    """right and left, forwards and backwards: E w + (1 - E)(K u + d_v +- l d_omega) <= W behind
    every command u that the whole filter admits to the wheel, w = v +- l omega and W = {which} (1 -
    2^-26); {what}.

    The limit of a wheel includes pushes and errors of both axes.

    Given: any odometry within nbar of v and omega, or none, any time since the last sample; the
    stored bounds hold if that is a period; w within W; no delay, jitter or losses, H = T; l, T > 0,
    0 < tau_min <= tau_max; 0 < K_min <= K <= K_max, |d_v| + l |d_omega| <= dbar_v + l dbar_omega <
    W, each within its own; u at most the step's limit (filter.sent.{key}).
    """
    graph, way = governor(more), WAYS[side]
    f = symbols("v1 v2 u K d1 d2 E kappa gone")
    ports = ports_of(graph.system)
    p = {port.signal.name: port.sym for port in ports}
    push, error, gain = (p[f"filter.{name}"] for name in ("d", "odometry", "gain"))
    T, tau = graph.T, p["filter.tau"]
    cuts = {"1/(exp(T/tau_min) - 1)": 1 / expm1(T / tau[0]), "-most": expm1(-T / tau[0])}
    cuts["-least"] = expm1(-T / tau[1])
    kappa, most, least = cuts.values()
    seen, came = graph.age.sym >= -NEAR * T, _timely(graph)
    given: list[Relations] = [
        positive(p["robot.l"], T, gain[0], f.kappa),
        nonnegative(*vertsplit(push), *vertsplit(error)), f.kappa == kappa,
        f.gone == most, -f.kappa * f.gone == 1 + f.gone, positive(-least, 1 + most),
        least >= most, between(1 + most, f.E, 1),
    ]  # fmt: skip
    for i, v in enumerate((f.v1, f.v2)):
        given += when(seen, within(graph.odometry.sym[i] - v, error[i]))
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


TIMES: tuple[Keys, ...] = (
    {"key": "jitter", "more": {"filter.jitter": 0.005}, "H": "3 T/2, for a jitter of T/2"},
    {"key": "losses", "more": {"filter.losses": 2}, "H": "3 T, for two commands lost in a row"},
    {"key": "hold", "more": {"filter.hold": 0.05},
     "H": "5 T, for a base that keeps its command so long and stops then"},
)  # fmt: skip


@claim("filter.assembled.{key}", premises="filter.sent", over=TIMES)
def assembled(mutation: Mutation, more: Keys) -> Statement:
    """either axis, either way: E v + (1 - E) mean <= V behind every command u that the whole filter
    admits, mean at most the steady speed of u or, once the base has stopped, of pushes alone; H =
    {H}.

    A command may act for longer than a period, and the filter takes that into account.

    Given: any odometry within nbar, or none, any time since the last sample; the stored bounds hold
    where every command that may act was sent in time; |v| <= V; T > 0, 0 < tau_min <= tau_max;
    {INTERVALS}; exp(-H/tau_min) <= E <= 1; u at most the step's limit.
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

"""The guard behind a varying lag: bounds of the acting force, and the limit that is still kept.

Exponentials are symbols with their relations; the sums may be those of any number of commands. That
the acting push stays below Z is argued by hand (guard.varying.lag).
"""

from dataclasses import replace

from casadi import SX, fmax, fmin, if_else

from wmr_ctrl.control.guard.delay import integral, moved, push, waiting
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Relations, Statement, between, nonnegative, positive, symbols

from .guard_axis import LAGGING, GuardAxis
from .guard_sample import left, on
from .guard_sent import larger, spares

LAGS = on("varying.")
claim = Claims()


def exponentials(a: GuardAxis) -> Relations:
    """Their relations; without jitter T and T + J are the same time."""
    fast, slow, rises, falls = a.fast, a.slow, a.rises_by, a.falls
    same = () if a.varies else (a.rise_late == a.rise,)
    return (
        between(0, fast, slow), positive(slow), between(0, rises, falls), falls <= 1,
        slow * (1 - falls) <= a.J, a.rise_J == (slow - fast) * (1 - rises),
        between(0, a.rise, a.rise_late), slow - fast >= a.rise_late, same,
    )  # fmt: skip


def _core(a: GuardAxis, way: int, room: SX, most: SX) -> SX:
    """M_min room less the largest effect of the last and the new command, each at most ``most``."""
    spare = a.M_min * room + a.slow * a.lasts(way)[0]
    return spare - (a.slow + a.J) * most


@claim("guard.varying.moved")
def varying_moved(mutation: Mutation) -> Statement:
    """Z after a piece of time is at least p + e (Z0 - p) for every e between exp(-h/a) and
    exp(-h/b), lies between Z0 and p, and does not fall where Z0 or p rises.

    Z falls slowest with the time constant b and rises fastest with a.

    Given: 0 <= exp(-h/a) <= exp(-h/b) <= 1, Z0, p >= 0.
    """
    t = symbols("z p more_z more_p falls rises between")
    z, p, more_z, more_p, falls, rises, e = t.values()
    first, second = moved(z, p, (falls, rises)), moved(more_z, more_p, (falls, rises))
    lies = between(p + e * (z - p), first, fmax(z, p)), first >= fmin(z, p)
    given = nonnegative(z, p), more_z >= z, more_p >= p, between(0, rises, e), between(e, falls, 1)
    return Statement(t, (mutation(1, 0.99) * second >= first, lies), given)


@claim("guard.varying.integral")
def varying_integral(mutation: Mutation) -> Statement:
    """b Z + its integral = b Z0 + h p + (b - a)(1 - exp(-h/a)) max(p - Z0, 0).

    Contribution of a piece in addition to that of a constant lag b.

    Given: a piece with full weight for every age; exponentials free.
    """
    t = symbols("z p time fast slow falls rises")
    z, p, time, a, b, falls, rises = t.values()
    weights = (time, b * (1 - falls), a * (1 - rises))
    whole = b * moved(z, p, (falls, rises)) + integral(z, p, weights)
    return Statement(t, whole == b * z + waiting(z, p, time, (b - mutation * a) * (1 - rises)))


@claim("guard.varying.piece")
def varying_piece(mutation: Mutation) -> Statement:
    """the weighted integral of Z over a piece is between 0 and its weight times S.

    So all pieces together contribute no more than behind a constant lag b.

    Given: 0 <= Z0, p <= S, weights of the differences within 0 and that of p.
    """
    t = symbols("z p most time fall rise")
    z, p, most, time, fall, rise = t.values()
    counted = integral(z, p, (time, fall, rise))
    given = [item >= 0 for item in (z, p, fall, rise)]
    given += [most >= z, most >= p, time >= fall, time >= rise]
    goals = mutation(1, 0.99) * time * most >= counted, counted >= 0
    return Statement(t, goals, given)


@claim("guard.varying.more")
def varying_more(mutation: Mutation) -> Statement:
    """b Z + (the last command's contribution within J) + c(T) (S - Z_J) <= (b + J) S, and b Z + c(T
    + J) (S - Z) <= b S.

    The last command and the new one together contribute no more than b + J times the largest push.

    Given: 0 <= Z, p_1 <= S, S, J > 0; {EXPONENTIALS}.
    """
    a = GuardAxis(LAGGING)
    z, most, p = a.z_ahead, a.most, push([a.sent], a.bounds, 1)
    again = waiting(z, p, a.J, a.rise_J)
    after = moved(z, p, (a.falls, a.rises_by))
    b = a.slow
    last = mutation(1, 0.99) * (b + a.J) * most >= b * z + again + a.rise * (most - after)
    goals = last, b * most >= b * z + a.rise_late * (most - z), again >= 0
    sizes = positive(a.J), between(0, z, most), most >= p, positive(most)
    return a.states(goals, given=(exponentials(a), sizes))


@claim("guard.{at}spare", premises="guard.late.caps guard.varying.piece", over=LAGS)
def varying_spare(mutation: Mutation, a: GuardAxis) -> Statement:
    """core >= max(brakes + net, 0)/alpha ahead, or behind, or for both together, core = M_min (u1 -
    reached) + b Z - (b + J) S.

    The caps leave the room that braking needs, also if both directions are full.

    Given: sums without b Z at most (late - J - b) S in rest and (usual - J - b) S in the mean, each
    way (guard.varying.piece); mixed = usual >= J + b, b >= 0; {caps}.
    """
    b, lag, S = a.bounds, a.slow, a.S
    given = [a.usual >= a.J + lag, a.both_act == a.usual, lag >= 0]
    for way, name in ((1, "ahead"), (-1, "back")):
        for sums, time in ((a[name], a.usual), (a[f"rest_{name}"], a.late)):
            given.append((time - a.J - lag) * S + lag * a.lasts(way)[0] >= b.M_min * sums)
    cores = [_core(a, way, left, S) for way, left in zip((1, -1), spares(a), strict=True)]
    need = mutation(1, 1.01) * fmax(b.braking + a.net, 0) / b.alpha
    rules = (a.stated, a.shared(), a.apart(), given)
    return Statement(a, larger(*cores) >= need, rules, a.cuts)


@claim("guard.{at}left", premises="guard.varying.more", over=LAGS)
def varying_left(mutation: Mutation, a: GuardAxis) -> Statement:
    """M_min room >= min(core, S/alpha), core = M_min (u1 - reached) + b Z - (b + J) S.

    Every line is a mean of core and S/alpha.

    Given: {MORE}; M_min, alpha, S > 0, 0 <= Z, Z_J <= S, J >= 0; {EXPONENTIALS}.
    """
    b, room, most = a.bounds, a.room, a.most
    z, after, again = a.lasts(1)
    lag, J = a.slow, a.J
    least = mutation(1, 1.01) * fmin(_core(a, 1, room, most), most / b.alpha)
    given = (
        between(0, z, most), between(0, after, most), nonnegative(again),
        positive(most), (lag + J) * most >= lag * z + again + a.rise * (most - after),
        lag * most >= lag * z + a.rise_late * (most - z), exponentials(a),
        positive(b.M_min, b.alpha, *([J] * a.varies)),
    )  # fmt: skip
    return Statement(a, b.M_min * a.sums.left(room, b) >= least, given)


@claim("guard.{at}room", premises="guard.{at}left guard.{at}spare", over=LAGS)
def varying_room(mutation: Mutation, a: GuardAxis) -> Statement:
    """M_min alpha room >= max(brakes + net, 0) ahead, or behind, or for both together.

    Commands already sent never use the room that braking needs.

    Given: guard.{at}left, guard.{at}spare; M_min, alpha > 0, S >= brakes + net.
    """
    b, t = a.bounds, symbols("room_ahead room_back core_ahead core_back brakes")
    rooms, cores = (t.room_ahead, t.room_back), (t.core_ahead, t.core_back)
    need = fmax(t.brakes + a.net, 0) / b.alpha
    pairs = zip(rooms, cores, strict=True)
    lines = [b.M_min * room >= fmin(core, a.most / b.alpha) for room, core in pairs]
    given = lines, larger(*cores) >= need, a.most >= need * b.alpha, positive(b.M_min, b.alpha)
    return Statement(a | t, b.M_min * larger(*rooms) >= mutation(1, 1.01) * need, given)


@claim("guard.{at}counts", over=LAGS)
def counts(mutation: Mutation, a: GuardAxis) -> Statement:
    """room is at most the value of each of its lines, from u1 less the speed reached when the new
    command may first take over; in both directions.

    Definition of the room, as lines.

    Given: reached as in guard.late.mean, with the integral of Z for the sums, and b Z; {SIGNS},
    alpha T <= 1, 0 <= J <= T; {EXPONENTIALS}.
    """
    least = left(mutation, a)
    return replace(least, given=(least.given, exponentials(a)))


@claim(
    "guard.{at}inside",
    premises="guard.{at}feasible guard.{at}counts",
    over=on("varying.", back=True),
)
def varying_inside(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """for p_0 > 0 two speeds are at most u1, for v and -v: the speed reached + ((T + J) p_0 + c(T +
    J) max(p_0 - Z, 0))/M_min, and the speed reached + (the last command's contribution in J + T p_0
    + c(T) max(p_0 - Z_J, 0))/M_min.

    A robot within its limit stays within it: a push larger than the last one is worst if it comes
    early, a smaller one if it comes late.

    Given: {counts}, whose hypotheses hold; M >= M_min, lo <= hi, brakes >= net; Z, Z_J and the last
    command's contribution >= 0.
    """
    # A command of larger p than the last is worst early, another one late; both to their end.
    b, spare = a.bounds, a.u1 - a.arrived
    z, after, again = a.lasts(way)
    p, period = fmax(a.push(way), 0), mutation(1, 1.01) * b.period
    early = waiting(z, p, period + a.J, a.rise_late) / a.mass
    late = (waiting(after, p, period, a.rise) + again) / a.mass
    goals = [b.u1 >= a.arrived + if_else(p > 0, more, spare) for more in (early, late)]
    limits = b.braking >= a.net, a.hi >= a.lo, a.lines(way, a("room_", way), spare)
    masses = nonnegative(z, after, again), a.mass >= b.M_min, positive(b.M_min)
    given = a.sound(), exponentials(a), limits, masses
    return Statement(a, goals, given, a.rooms)


@claim("guard.{at}graceful", premises="guard.{at}counts", over=on("varying.", back=True))
def varying_graceful(mutation: Mutation, way: int, a: GuardAxis) -> Statement:
    """for |d| <= dbar + D the two speeds of guard.varying.inside, with D added over all times that
    matter, are at most u1 + D (T + late)/M_min; for v and -v.

    Under a push that exceeds its bound by D the speed exceeds the limit by at most a known amount.

    Given: {counts}, whose hypotheses hold; F = hi(y), or -hi(-y) backwards; D >= 0, pushes and Z
    larger by at most D; p_0 + D > 0; brakes - net >= D; Z, Z_J and the last command's contribution
    >= 0; {caps}.
    """
    # Pushes, and Z with them, are larger by at most D; worst for F = hi.
    b, D = a.bounds, a.extra
    z, after, again = a.lasts(way)
    p = fmax((a.hi if way > 0 else -a.lo) + a.net + D, 0)
    early = waiting(z + D, p, b.period + a.J, a.rise_late) - D * a.J
    late = waiting(after + D, p, b.period, a.rise) + again
    limit = a.exceeded(mutation(1, 0.99))
    start = a.arrived + D * a.late / b.M_min
    goals = [limit >= if_else(p > 0, start + more / b.M_min, b.u1) for more in (early, late)]
    known = a.stated, exponentials(a), D >= 0, a.withstands(D)
    given = known, a.lines(way, a("room_", way), b.u1 - a.arrived), nonnegative(z, after, again)
    return Statement(a, goals, given, a.rooms)

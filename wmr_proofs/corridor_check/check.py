"""Check a corridor's certificate: if no sample before has left its box, the next does not either.

On a box, graphs are linear except for remainders, which intervals bound.  So a state is a sum of
two parts: responses to the inputs of the last ``lags`` samples, and the response to the state
before these, which is in its own box.  Responses are products of matrices of doubles.  The rounding
of a product is treated as one more input, and so are the errors of the matrices.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import numpy as np

from .certificate import Certificate
from .graphs import OUT, Graph, each
from .intervals import Floats, RefusedError, most

ROBOT, COMMAND = 5, 2
UNIT = 2.0**-45
"""Largest relative error of a sum of 150 products."""
LONGEST = 40_000
"""Most samples of a standing loop."""
LEFT = 1e-8
"""Share of a deviation at which its sums end."""
DUST = 1e-12
"""Size below all that matters."""
TERMS = 800_000
"""Most terms of a sum."""
ALONE = 2**17
"""Products of numbers for which BLAS starts no threads."""
ROUNDS = 3
"""Rounds in which the long run's box shrinks."""


def check(c: Certificate) -> tuple[Floats, Floats]:
    """Distance [m] from the place on the path, and turn [rad], in each sample (K).

    Raises RefusedError if it is not shown that no deviation exceeds them.
    """
    sizes = [c.fast, c.state, c.out, c.push, c.reckoned, c.velocity, c.wide, c.command, c.dead,
             c.gap, c.law_gap, c.step_gap, c.aside, c.lower, np.array([c.pose, c.disc[0]]),
             ]  # fmt: skip
    if not all(((part >= 0) & (part < np.inf)).all() for part in sizes):
        raise RefusedError("a size is negative or no number")
    sample = _Sample(c)
    box = _gathered(c, sample, (_run if c.lags else _standing)(c, sample))
    _compare(c, box)
    turn = np.abs(c.fine[:, :, 2]).max(axis=1) + box.fast[:, 2] + c.aside[:, 1]
    return _distance(box, sample.course), turn * OUT


def _compare(c: Certificate, box: Certificate) -> None:
    """Raise RefusedError if a value leaves the box of ``c``."""
    for name in ("fast", "state", "out"):
        found, claimed = getattr(box, name), getattr(c, name)
        if not (found <= claimed).all():
            k, i = np.unravel_index(np.argmax(found / np.maximum(claimed, 1e-300)), found.shape)
            reach = f"{found[k, i]:.6g} of {claimed[k, i]:.6g}"
            raise RefusedError(f"{name} {i + 1} reaches {reach} in sample {k}")


def latched(c: Certificate, box: Floats, samples: int, stages: int) -> list[float]:
    """Distances [m] of a repeating loop with states in ``box`` after ``samples`` samples, twice as
    many, ...

    Raises RefusedError if a sample that begins there, or any later one, may leave the certificate's
    box.
    """
    c = _without_start(c)
    sample, result = _Sample(c), []
    _compare(c, _gathered(c, sample, _begun_within(c, sample, box)))
    for _ in range(stages):
        sample = _Sample(c)
        found = _gathered(c, sample, _standing(c, sample, samples))
        _compare(c, found)
        c = found
        result.append(float(_distance(c, sample.course)[0]))
    return result


def in_the_long_run(c: Certificate) -> float:
    """Distance [m] of a repeating loop in the long run; `check` has shown that it stays in its box.

    The response to its initial state decays, so the loop enters the box of the other inputs.  This
    step is repeated.
    """
    c = _without_start(c)
    for _ in range(ROUNDS):
        sample = _Sample(c)
        c = _gathered(c, sample, _standing(c, sample))
    return float(_distance(c, sample.course)[0])


def _without_start(c: Certificate) -> Certificate:
    return replace(c, start=0.0 * c.start, disc=(0.0, 0))


def _distance(c: Certificate, course: _Course) -> Floats:
    ways = slice(course.nz, c.fast.shape[1] - 2 * len(c.pairs))
    off = np.abs(c.fine[:, :, :2] @ course.rows[ways, :2].T).max(axis=1) + c.fast[:, ways]
    return (off.max(axis=1) / cos(pi / (2 * off.shape[1])) + c.aside[:, 0]) * OUT


class _Course:
    """The undisturbed loop of a certificate, as variables and numbers of its graphs.

    ``seen`` (K, any): for the law.  ``moved`` (K, steps, any): for plant steps.  ``order``: places
    in the state of the law's variables.  ``ages``: samples since the command that acts in each
    plant step.  ``rows``: elements, directions of the position, sums and differences of pairs of
    deviations.  Consecutive samples with equal boxes are of one ``kind`` (K); ``first`` (kinds) is
    the first sample of each.  They share matrices, which are wide enough for all of them.
    """

    def __init__(self, c: Certificate) -> None:
        """Raises RefusedError if a sample does not begin where the previous one ended."""
        (K, steps, self.nz), self.n = c.fine.shape, c.states.shape[1]
        self.steps, self.outs, nz = steps - 1, c.outs.shape[1], self.nz
        queue = nz + COMMAND * c.queue
        sent = np.hstack([c.outs[:, :COMMAND], c.states[:-1, nz:queue]])
        after = [c.fine[:, -1], sent[:, : COMMAND * c.queue], c.outs[:, COMMAND:]]
        ended = np.hstack([c.fine[:, 0], *after])
        if not np.array_equal(ended, np.hstack([c.states[:-1, :nz], c.states[1:]])):
            raise RefusedError("a sample begins with something else than the last one ended in")
        if c.knots[:1] != [0] or c.knots != sorted(set(c.knots) & set(range(self.steps))):
            raise RefusedError("rows are summed up at other times than those of plant steps")
        memory = range(queue, queue + c.memory)
        self.order = [*range(ROBOT), *memory, *range(nz, queue), *range(memory.stop, self.n)]
        self.seen = np.hstack([c.states[:-1, self.order], c.law_numbers])
        self.ages = [-((s - c.late) // self.steps) for s in range(self.steps)]
        acts = sent.reshape(K, -1, COMMAND)[:, self.ages]
        parts = [c.fine[:, :-1], acts, np.zeros_like(acts), c.body, c.step_numbers]
        self.moved = np.concatenate(parts, axis=2)
        every = np.hstack([c.fast, c.state[:-1], c.out])
        differs = np.append(True, (every[1:] != every[:-1]).any(axis=1))
        self.first, self.kind = np.flatnonzero(differs), np.cumsum(differs) - 1
        count, unit = c.fast.shape[1] - nz - 2 * len(c.pairs), np.eye(nz)
        angles = [k * pi / count for k in range(count)]
        ways = [cos(angle) * unit[0] + sin(angle) * unit[1] for angle in angles]
        pairs = zip(c.pairs, c.ratios, strict=True)
        sums = [unit[a] + sign * ratio * unit[b] for (a, b), ratio in pairs for sign in (1, -1)]
        self.rows = np.array([*unit, *ways, *sums])

    def ends(self, each: Floats) -> Floats:
        """Smallest and largest entries (2, kinds, ...) of a per-sample array, for each kind."""
        return np.array([part.reduceat(each, self.first) for part in (np.minimum, np.maximum)])


def _boxes(c: Certificate, course: _Course, error: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Deviations of the law's variables (kinds, any) and products of two of them; the same for
    plant steps.
    """
    fast, state, out = (part[course.first] for part in (c.fast, c.state, c.out))
    early = np.minimum(c.fast, np.vstack([c.fast[:1], c.fast[:-1]]))
    K, (a, b), both = len(fast), np.array(c.pairs).T, list[Floats]()
    for rows in (course.ends(early)[1], fast):
        robot = rows[:, :ROBOT]
        products = robot[:, :, None] * robot[:, None]
        sums = rows[:, len(course.rows) - 2 * len(c.pairs) :].reshape(K, -1, 2).max(axis=2) ** 2
        least = np.minimum(products[:, a, b], sums / (4 * c.ratios))
        products[:, a, b] = products[:, b, a] = least
        both.append(products)
    seen, begun = state[:, course.order], state[:, :ROBOT]
    seen[:, :ROBOT] += error
    by_seen, mixed = seen[:, :, None] * seen[:, None], begun[:, :, None] * error
    least = np.minimum(both[0], begun[:, :, None] * begun[:, None])
    by_seen[:, :ROBOT, :ROBOT] = least + mixed + mixed.swapaxes(1, 2) + np.outer(error, error)
    queue = state[:, course.nz : course.nz + COMMAND * c.queue].reshape(K, -1, COMMAND)
    sent = np.concatenate([out[:, None, :COMMAND], queue], axis=1)
    last = max(course.ages) + (len(c.share) > 0)
    acts = sent[:, min(course.ages) : last + 1].max(axis=1)
    known = np.tile(np.concatenate([c.push, c.wide]), (K, 1))
    moved = np.hstack([fast[:, : course.nz], acts, known])
    by_moved = moved[:, :, None] * moved[:, None]
    by_moved[:, :ROBOT, :ROBOT] = products
    return seen, by_seen * OUT, moved, by_moved * OUT


class _Linear:
    """Gradients of law and plant step along the trajectory, and bounds of all other contributions.

    ``by_law`` (kinds, outputs, variables), ``by_step`` (kinds, steps, fast, variables): gradients.
    ``law`` and ``step`` (kinds, ...): largest errors.  ``given`` (kinds, inputs): sizes of inputs,
    see `_Sample`.  ``constant`` (fast): increment in each plant step of a repeating loop.
    """

    def __init__(self, c: Certificate, course: _Course) -> None:
        """Raises RefusedError if a limit may act on the box."""
        law, step, outs = Graph(c.law), Graph(c.step), course.outs
        seen, moved, K = course.seen, course.moved, len(course.first)
        shown = law.values(np.array([seen, seen]))
        level = most(shown)[:, outs:]
        room = Graph(c.sizes).values(np.array([seen, seen]))[0] / OUT - c.lower * OUT
        if not ((level + c.out[:, COMMAND:]) * OUT <= room).all():
            raise RefusedError("a limit may act on its box")

        place = c.pose + c.reckoned[:COMMAND]
        error = np.array([*place, c.reckoned[2], *c.velocity])
        size, products, wide, by_wide = _boxes(c, course, error)
        at, passed = course.ends(seen), course.ends(moved)
        by_law, off = (part[:, 0] for part in law.linear(at[:, :, None], size, products))
        self.by_step, more = step.linear(passed, wide, by_wide)
        self.by_law = by_law

        off[:, :outs] += course.ends(most(shown[..., :outs] - c.outs))[1] + c.law_gap
        acts = np.abs(c.outs[:, :COMMAND]) - c.out[:, :COMMAND] > c.dead * OUT
        off[:, :COMMAND] += c.command + course.ends(np.where(acts, 0.0, c.dead))[1]
        after = step.values(np.array([moved, moved]))
        still = 0.0 if c.lags else after[:, 0, 0].mean(axis=0) - c.fine[0, 1]
        self.constant = np.zeros(course.nz) + still
        more += course.ends(most(after - c.fine[:, 1:] - still))[1] * OUT
        more += np.abs(self.by_step[..., -COMMAND:]) @ c.wide + c.step_gap
        self.law, self.step = off * OUT, more * OUT
        changes = course.ends(level + c.out[:, COMMAND:])[1, :, -COMMAND:]
        changes += 2 * (c.command + c.dead)
        known = np.tile(np.concatenate([c.push, error, [1.0]]), (K, 1))
        late = (changes[:, None] * c.off).reshape(K, -1)
        self.given = np.hstack([off[:, :COMMAND], late, known]) * OUT


class _Sample:
    """Matrices of K kinds of samples by the state at their beginning and by inputs.

    Inputs: the command's error, late commands, push, measurement errors, a constant.  ``next`` (K,
    n, any): the state a sample later; ``box`` (K, n): other contributions to it.  ``rows`` (K, any,
    any): the fast state's rows, the rest of the state, the fast state's rows at other knots,
    command and conditions.  ``apart`` (knots; K, rows): errors of rows at a knot, and between it
    and the next one, -inf if nothing is between.  ``direct``: errors of command and conditions.
    """

    def __init__(self, c: Certificate) -> None:
        course = self.course = _Course(c)
        linear = _Linear(c, course)
        K, n, nz, outs, steps = len(course.first), course.n, course.nz, course.outs, course.steps
        self.n, self.given = n, linear.given
        wide, full = n + self.given.shape[1], np.hstack([c.state[course.first], self.given])
        shown = np.zeros((K, linear.law.shape[1], wide))
        shown[:, :, course.order] = linear.by_law
        shown[:, :, -1 - ROBOT : -1] = linear.by_law[:, :, :ROBOT]
        unit = np.broadcast_to(np.eye(wide), (K, wide, wide))
        sent = [shown[:, :COMMAND] + unit[:, n : n + COMMAND]]
        sent += [unit[:, nz + COMMAND * k : nz + COMMAND * (k + 1)] for k in range(c.queue)]
        push, now, off = unit[:, -1 - ROBOT - COMMAND : -1 - ROBOT], unit[:, :nz], np.zeros((K, nz))
        courses, offs, slopes = [now], [off], linear.by_step[..., :-COMMAND]
        still = np.outer(linear.constant, np.eye(wide)[-1])
        for s, age in enumerate(course.ages):
            phase, acts, by_step = (s - c.late) % steps, sent[age], slopes[:, s]
            if phase < len(c.share):
                late = unit[:, n + COMMAND * (1 + phase) : n + COMMAND * (2 + phase)]
                acts = (1 - c.share[phase]) * acts + c.share[phase] * sent[age + 1] + late
            given = np.concatenate([now, acts, push], axis=1)
            rough = each(np.abs(by_step), each(np.abs(given), full)) + np.abs(still) @ full[0]
            held = each(np.abs(by_step[:, :, :nz]), off)
            off = (held + linear.step[:, s] + UNIT * rough) * OUT
            now = by_step @ given + still
            courses.append(now)
            offs.append(off)
        self.next = np.concatenate([now, *sent[: c.queue], shown[:, COMMAND:outs]], axis=1)
        self.box = course.ends(c.gap)[1] + UNIT * each(np.abs(self.next), full)
        self.box[:, :nz] += off
        self.box[:, n - outs + COMMAND :] += linear.law[:, COMMAND:outs]
        self.apart, sizes = [], np.abs(course.rows).T
        for a, b in zip(c.knots, [*c.knots[1:], steps], strict=True):
            beside = np.zeros((K, nz))
            for s in range(a + 1, b):
                share = (s - a) / (b - a)
                chord = courses[s] - (1 - share) * courses[a] - share * courses[b]
                rough = UNIT * (np.abs(courses[a]) + np.abs(courses[b]))
                beside = np.maximum(beside, each(np.abs(chord) + rough, full) + offs[s])
            ended = off if b == steps else 0.0  # counts at the end already
            inner = np.where(b > a + 1, (beside - ended) @ sizes, -np.inf)
            self.apart.append((offs[a] @ sizes, inner))
        read = [*range(COMMAND), *range(outs, shown.shape[1])]
        begin, *knots = (course.rows @ courses[a] for a in c.knots)
        self.rows = np.concatenate([begin, unit[:, nz:n], *knots, shown[:, read]], axis=1)
        self.direct = linear.law[:, read]


class _Answers:
    """Responses of the state to inputs of some samples: ``columns`` (m, n, samples), ``weights``.

    The m columns of a sample are those of inputs, then a disc's pair, then one for each element of
    the state.
    """

    def __init__(self, c: Certificate, sample: _Sample, count: int) -> None:
        self.pose, self.sample, self.n = c.pose, sample, sample.n
        weights, disc = sample.given.copy(), sample.given.shape[1] - 1 - ROBOT
        weights[:, disc : disc + COMMAND] = c.reckoned[:COMMAND] * OUT
        weights[:, -1] = 0.0
        used = np.flatnonzero(weights.any(axis=0))
        self.kept, self.pair, self.weights_of = self.n + used, len(used), weights[:, used]
        self.discs, m = [self.n + disc, self.n + disc + 1], len(used) + COMMAND + self.n
        if m * count > TERMS:
            raise RefusedError("its loop forgets too slowly")
        self.columns, self.weights = np.zeros((m, self.n, count)), np.zeros((m, count))

    def put(self, place: int, k: int, rounded: Floats | float = 0.0) -> None:
        """Store the responses to a sample of kind ``k`` at a place, with its rounding error
        ``rounded``.
        """
        here = self.sample.next[k]
        own = here[:, self.kept], here[:, self.discs], np.eye(self.n)
        self.columns[:, :, place] = np.concatenate(own, axis=1).T
        self.weights[: self.pair, place] = self.weights_of[k]
        self.weights[-self.n :, place] = self.sample.box[k] + rounded

    def reach(self, rows: Floats, k: int, state: Floats) -> Floats:
        """Largest values of rows of the state and of a sample's inputs, without a start."""
        total = np.abs(rows[:, self.kept]) @ self.weights_of[k]
        total += np.hypot(*rows[:, self.discs].T) * self.pose
        width = max(1, ALONE // rows[:, : self.n].size)
        for first in range(0, self.columns.shape[2], width):
            part = slice(first, first + width)
            seen = np.abs(rows[:, : self.n] @ self.columns[..., part])
            total += (seen @ self.weights[:, part, None]).sum(axis=0)[:, 0]
            total += np.hypot(*seen[self.pair : -self.n]).sum(axis=1) * self.pose
        return np.asarray((total + UNIT * np.abs(rows[:, : self.n]) @ state) * OUT)


def _begun(c: Certificate) -> Floats:
    """Columns (n, any) of the initial state's deviations; the last two belong to a disc."""
    unit = np.eye(len(c.start))[:, c.disc[1] : c.disc[1] + COMMAND]
    return np.hstack([c.start, c.disc[0] * unit])


def _started(seen: Floats) -> Floats:
    """Largest sums of columns as in `_begun` (..., rows, any)."""
    every = np.abs(seen[..., :-2]).sum(axis=-1) + np.hypot(seen[..., -2], seen[..., -1])
    return np.asarray(every * OUT)


def _run(c: Certificate, sample: _Sample) -> Floats:
    """Largest values (K + 1, rows) of the rows of each sample, and of the state after the last."""
    K, n, begun, reached = len(c.fine), sample.n, _begun(c), list[Floats]()
    count, place, kinds = min(c.lags, K + 1), 0, sample.course.kind
    answers, far = _Answers(c, sample, count), np.zeros((n, count))
    for k in range(K + 1):
        kind = kinds[min(k, K - 1)]
        if 2 * count < k < K - 1 and (kinds[k - 2 * count - 1 : k + 2] == kind).all():
            reached.append(reached[-1])  # nothing differs from a sample ago
            continue
        rows = sample.rows[kind]
        most = answers.reach(rows, kind, c.state[k])
        reached.append(most + (_started(rows[:, :n] @ begun) if k < count else 0.0))
        if k == K:
            break
        A = sample.next[kind, :, :n]
        answers.columns, begun = A @ answers.columns, A @ begun
        held = (np.abs(answers.columns[-n:]) * far[:, None]).sum(axis=0).max(axis=1)
        answers.put(place, kind, UNIT * np.abs(A) @ (c.state[k] + held) * OUT)
        far[:, place] = c.state[k + 1]
        place = (place + 1) % count
        if k + 1 >= count:  # what its oldest sample ended in is within the box there
            answers.columns[:-n, :, place] = 0.0
            answers.weights[-n:, place] = far[:, place]
    return np.array(reached)


def _begun_within(c: Certificate, sample: _Sample, box: Floats) -> Floats:
    """Largest values (2, rows) of rows of a sample that begins in a box, and of the next state."""
    n, rows, answers = sample.n, sample.rows[0], _Answers(c, sample, 1)
    after = rows[:, :n] @ sample.next[0]
    more = 0.0, np.abs(rows[:, :n]) @ sample.box[0]
    reached = []
    for part, off in zip((rows, after), more, strict=True):
        own = np.abs(part[:, :n]) @ box + np.abs(part[:, -1]) + off
        reached.append(answers.reach(part, 0, c.state[0]) + own * OUT)
    return np.array(reached)


def _standing(c: Certificate, sample: _Sample, samples: int = LONGEST) -> Floats:
    """Largest values (2, rows) of the rows of one sample that the loop repeats up to ``samples``
    times.

    The state before these samples is within the box.
    """
    n, rows, state = sample.n, sample.rows[0], c.state[0]
    (answers := _Answers(c, sample, 1)).put(0, 0)
    A, m = sample.next[0, :, :n], len(answers.weights)
    course = [np.hstack([answers.columns[..., 0].T, _begun(c), sample.next[0, :, -1:]])]
    while (np.abs(course[-1][:, m - n : m]) @ state > LEFT * (state + DUST)).any():
        if len(course) > samples:
            break
        course.append(A @ course[-1])
        if len(course) > LONGEST or not np.abs(course[-1]).max() < 1e9:
            raise RefusedError("the loop does not come to rest")
    ways = np.array(course)
    still = np.abs(ways[..., -1]).sum(axis=0)
    held = (np.abs(ways[..., m - n : m]) @ state).max(axis=0)
    sample.box[0] += UNIT * np.abs(A) @ (state + held + still) * OUT
    answers = _Answers(c, sample, len(ways) - 1)
    for k in range(len(ways) - 1):
        answers.put(k, 0)
    answers.columns = ways[:-1, :, :m].transpose(2, 1, 0)
    seen = rows[:, :n] @ ways[..., m:]
    left = np.abs(rows[:, :n] @ ways[-1, :, m - n : m]) @ state
    begun = np.maximum(_started(seen[..., :-1]).max(axis=0), left)
    sums = np.abs(np.cumsum(np.vstack([rows[:, -1], seen[..., -1]]), axis=0)).max(axis=0)
    sums += UNIT * np.abs(rows[:, :n]) @ still + (OUT - 1) * np.abs(seen[..., -1]).sum(axis=0)
    reached = answers.reach(rows, 0, state) + (begun + sums) * OUT
    return np.array([reached, reached])


def _gathered(c: Certificate, sample: _Sample, reached: Floats) -> Certificate:
    """The certificate, with the largest values of rows as its box."""
    count, nz, further = c.fast.shape[1], c.fine.shape[2], len(c.knots) - 1
    ends = np.cumsum([count, sample.n - nz, *[count] * further])
    begin, rest, *knots, out = np.split(reached, ends, axis=1)
    course = [item[:-1] for item in (begin, *knots)] + [begin[1:]]
    kinds, fast = sample.course.kind, []
    for k, (here, beside) in enumerate(sample.apart):
        fast += [course[k] + here[kinds], np.maximum(*course[k : k + 2]) + beside[kinds]]
    state, out = np.hstack([begin[:, :nz], rest]), (out[:-1] + sample.direct[kinds]) * OUT
    return replace(c, fast=np.max(fast, axis=0) * OUT, state=state, out=out)

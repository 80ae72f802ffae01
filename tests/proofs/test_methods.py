"""The methods of proof: statements that each must prove, refute or leave open."""

from fractions import Fraction

import casadi as ca
import pytest

from wmr_ctrl.results.ledger import OPEN, load
from wmr_proofs.methods.spec import Z3, Ball, Refute, Ring, Table
from wmr_proofs.regions import POSITIVE, Case, at
from wmr_proofs.statement import Statement, above, at_least, equal, symbols


def about(names, build):
    t = symbols(names)
    goals, given = build(*t.values())
    return Statement(t, tuple(goals), tuple(given))


SQUARE = about("x y", lambda x, y: ([equal((x + y) ** 2, x**2 + 2 * x * y + y**2)], []))
WRONG_SQUARE = about("x y", lambda x, y: ([equal((x + y) ** 2, x**2 + y**2)], []))
ROOT = about("x", lambda x: ([equal(ca.sqrt(x**2 + 2 * x + 1), x + 1)], []))
ANGLE = about(
    "x y", lambda x, y: ([equal(ca.sin(x + y), ca.sin(x) * ca.cos(y) + ca.cos(x) * ca.sin(y))], [])
)
LOG = about("x", lambda x: ([at_least(x - 1, ca.log(x))], []))
EXP = about("x", lambda x: ([at_least(ca.exp(x), 1 + x)], []))
POSITIVE_X = (Case("x > 0", {"x": POSITIVE}, lambda n: {"x": n["x"]}),)
TWO_WAYS = about("x", lambda x: ([equal(ca.if_else(x > 1, x, ca.if_else(x <= 1, x, 0)), x)], []))
BRANCH = about("x", lambda x: ([at_least(ca.if_else(x > 0, x, -x))], []))
DIVIDED = about("x", lambda x: ([equal(ca.if_else(x > 0, 1 / x, 0) * x, 1)], []))
UNIT = {"x": (Fraction(0), Fraction(1))}


@pytest.mark.parametrize(
    "method, statement, verdict",
    [
        (Ring(), SQUARE, "PROVED"),
        (Ring(), WRONG_SQUARE, "REFUTED"),
        (Ring(POSITIVE_X), ROOT, "PROVED"),
        (Ring(), ANGLE, "PROVED"),
        (Ring(POSITIVE_X), TWO_WAYS, "PROVED"),
        (Ring(POSITIVE_X), DIVIDED, "PROVED"),
        (Ring(POSITIVE_X), LOG, "OPEN"),
        (Ring(POSITIVE_X, log_lemma=True), LOG, "PROVED"),
        (Z3(), SQUARE, "PROVED"),
        (Z3(points=(at(x=1),)), SQUARE, "PROVED"),
        (Z3(points=(at(x=1),)), WRONG_SQUARE, "REFUTED"),
        (Z3(), BRANCH, "PROVED"),
        (Z3(), about("x", lambda x: ([at_least(ca.sqrt(x), 1)], [at_least(x, 1)])), "PROVED"),
        (Ball(box=UNIT), BRANCH, "PROVED"),
        (Ball(box=UNIT), about("x", lambda x: ([above(ca.exp(x), 0.9 + x)], [])), "PROVED"),
        (Ball(box=UNIT), about("x", lambda x: ([above(ca.exp(x), 1.1 + x)], [])), "REFUTED"),
        (
            Ball(box=UNIT),
            about("x", lambda x: ([above(ca.log(ca.if_else(x > 0.5, x, 1)), -1)], [])),
            "PROVED",
        ),
        (Refute((at(x=1, y=1),)), WRONG_SQUARE, "REFUTED"),
        (Refute((at(x=0, y=1),)), WRONG_SQUARE, "OPEN"),
        (Table(lambda: (at(x=1, y=1), at(x=2, y=-3))), SQUARE, "PROVED"),
        (Table(lambda: (at(x=0, y=1), at(x=2, y=-3))), WRONG_SQUARE, "REFUTED"),
    ],
)
def test_verdicts(method, statement, verdict):
    assert method.decide(statement).verdict == verdict


@pytest.mark.parametrize(
    "method, least, verdict",
    [
        (Ring(POSITIVE_X), 1, "OPEN"), (Refute((at(x=-2),)), -1, "OPEN"),
        (Refute((at(x="-1/2"),)), -1, "REFUTED"),
    ],
)  # fmt: skip
def test_cases_and_counterexamples_must_keep_the_hypotheses(method, least, verdict):
    positive = about("x", lambda x: ([above(x)], [above(x, least)]))

    assert method.decide(positive).verdict == verdict


def test_pi_is_exact():
    still = about("x", lambda x: ([above(ca.fabs(ca.sin(x)))], [above(x)]))

    assert Refute(({"x": "1 pi"},)).decide(still).verdict == "REFUTED"


def test_a_free_symbol_is_refused():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")

    with pytest.raises(ValueError, match="does not name"):
        _ = Statement({"x": x}, (equal(x * y),)).graph


def test_z3_tries_each_engine_again_with_more_work_until_the_effort_is_spent(monkeypatch):
    import z3

    from wmr_proofs.methods import portfolio

    asked = []

    def attempt(self, engine, terms, size):
        assert terms
        asked.append((engine, size))
        self.spent += size[0] if engine == "cases" else size[0] / 2  # the others have no more
        return z3.unknown, None

    monkeypatch.setattr(portfolio.Portfolio, "attempt", attempt)
    spent = 2 + 15 + 8 * 2 / 2

    for effort, rounds in ((spent, 2), (1000, 3)):
        asked.clear()
        statement = about("x", lambda x: ([at_least(x * x)], []))
        assert Z3(effort=effort).decide(statement).verdict == "OPEN"
        first, *later = portfolio.ATTEMPTS[:rounds]
        expected = [*((engine, first) for engine in portfolio.ENGINES)]
        assert asked == [*expected, *(("cases", size) for size in later)]


def test_what_z3_does_hangs_on_nothing_that_was_asked_before(monkeypatch):
    from wmr_proofs.methods import portfolio

    solvers = []

    def recorded(context):
        solvers.append(portfolio._by_cases(context, random_seed=3))
        return solvers[-1]

    monkeypatch.setattr(portfolio, "ENGINES", {"cases": recorded})

    def steps(count):
        before = len(solvers)
        Z3().decide(about("x y", lambda x, y: ([at_least(x**count + y**2 - x * y)], [above(x, 1)])))
        return [solver.statistics().get_key_value("rlimit count") for solver in solvers[before:]]

    first = steps(2)
    assert len(first) > 1
    steps(4)
    assert steps(2) == first


def test_z3_ends_within_its_effort_and_tells_what_it_tried():
    x = symbols("x y z w")
    powers = [x[name] ** 4 * x[other] ** 2 for name, other in ("xy", "yz", "zw", "wx")]
    hard = Statement(x, (at_least(sum(powers) - 4 * x["x"] * x["y"] * x["z"] * x["w"] + 2),))
    method = Z3(effort=3)

    finding = method.decide(hard)

    assert finding.verdict == OPEN
    assert finding.evidence["work"] <= 1.05 * method.effort
    assert "of 3 million units" in finding.evidence["tried"]


def test_entries_need_at_most_two_thirds_of_the_effort():
    work = {
        entry.id: entry.evidence["work"] for entry in load().entries if "work" in entry.evidence
    }

    assert len(work) > 300
    assert {key for key, spent in work.items() if spent > 2 / 3 * Z3().effort} == set()

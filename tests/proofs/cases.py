"""An entry's obligations case by case: every choice is decided in both ways.

The rest of the graph in a case has no minimum, absolute value or condition, which is easier for
solvers.  Symbols to which a hypothesis gives one value are replaced by that number.
"""

from fractions import Fraction
from functools import partial

import z3

from wmr_proofs.graph import ProvedGraph, UndecidedError, Walk, paths
from wmr_proofs.methods.smt import OUTSIDE, TermArithmetic, relation
from wmr_proofs.statement import EQUAL

MOST = 256
"""Cases of one statement; with more UndecidedError is raised."""


class CaseTerms(TermArithmetic):
    """Terms of one case.

    ``taken``: the decisions made; ``outside``: conditions under which a term is undefined.
    """

    def __init__(self, ask, known):
        super().__init__()
        self.ask, self.known = ask, known
        self.taken = []
        self.outside = []

    def variable(self, name):
        """The known number of an input, or a real variable."""
        value = self.known.get(name)
        return super().variable(name) if value is None else z3.RealVal(str(value), self.context)

    def apply(self, op, args):
        """Decide each choice between terms, and record where an operation is undefined."""
        if op in ("fmin", "fmax"):
            least = self._decided(args[0] <= args[1])
            return args[0] if least == (op == "fmin") else args[1]
        if op == "fabs":
            return args[0] if self._decided(args[0] >= 0) else -args[0]
        if op == "sign":
            up = self._decided(args[0] > 0)
            return self.constant(1 if up else -1 if self._decided(args[0] < 0) else 0)
        if op in OUTSIDE:
            self.outside.append(OUTSIDE[op](*args))
        return super().apply(op, args)

    def compare(self, op, left, right, _ask):
        """Decide the comparison."""
        return self._decided(super().compare(op, left, right, _ask))

    def logic(self, op, args):
        """Combine conditions that are already decided."""
        return not args[0] if op == "not" else (all(args) if op == "and" else any(args))

    def number(self, condition):
        """Return the term 1 for a true condition, else 0."""
        return self.constant(int(condition))

    def _decided(self, condition):
        plain = z3.simplify(condition)
        if z3.is_true(plain) or z3.is_false(plain):
            return bool(z3.is_true(plain))
        truth = self.ask(plain.sexpr())
        self.taken.append(condition if truth else z3.Not(condition))
        return truth


def cases(statement):
    """Yield each goal and domain in each case, as SMT-LIB 2 text that must be unsatisfiable.

    Raises UndecidedError for more than MOST cases.
    """
    if statement.computed:
        raise UndecidedError("rounded results that are read have to be defined as well")
    known = dict(_known(statement))
    for goal, kind in enumerate(statement.goal_kinds):
        for _, texts in paths(partial(_case, statement, goal, kind, known), MOST):
            yield from texts


def _case(statement, goal, kind, known, ask):
    nodes, outputs = statement.graph.nodes, statement.graph.outputs
    terms = CaseTerms(ask, known)
    (value,) = Walk(ProvedGraph(nodes, (outputs[goal],)), terms, ask).outputs()
    undefined = [item for item in terms.outside if not z3.is_false(z3.simplify(item))]
    others = Walk(ProvedGraph(nodes, outputs[len(statement.goal_kinds) :]), terms, ask).outputs()
    base = [relation(k, v) for k, v in zip(statement.given_kinds, others, strict=True)]
    base += [*terms.facts, *terms.taken]
    return [_text(terms, [*base, wrong]) for wrong in (z3.Not(relation(kind, value)), *undefined)]


def _text(terms, every):
    solver = z3.Solver(ctx=terms.context)
    solver.add(*every)
    return f"(set-logic QF_NRA)\n{solver.to_smt2()}"


def _known(statement):
    """Symbols to which a hypothesis a x + b = 0 gives a value."""
    outputs = statement.graph.outputs[len(statement.goal_kinds) :]
    for kind, place in zip(statement.given_kinds, outputs, strict=True):
        name, slope, rest = _line(statement.graph, place) if kind == EQUAL else ("", 0, 0)
        if name and slope:
            yield name, Fraction(-rest) / slope


def _line(graph, place):
    """Name, slope and rest of an expression linear in one input; name "" and slope 0 without one.

    Of any other expression the slope is 0 as well.
    """
    node, none = graph.nodes[place], ("?", Fraction(0), Fraction(0))
    if node.op == "const":
        return "", Fraction(0), Fraction(node.value)
    if node.op == "input":
        return node.name, Fraction(1), Fraction(0)
    if node.op not in ("add", "sub", "mul", "neg"):
        return none
    first, *others = (_line(graph, k) for k in node.args)
    if node.op == "neg":
        return first[0], -first[1], -first[2]
    second = others[0]
    if "?" in (first[0], second[0]) or (first[0] and second[0]):
        return none
    if node.op == "mul":
        (_, _, factor), line = (first, second) if second[0] else (second, first)
        return line[0], factor * line[1], factor * line[2]
    sign = 1 if node.op == "add" else -1
    return first[0] + second[0], first[1] + sign * second[1], first[2] + sign * second[2]

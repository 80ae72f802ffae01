"""Check certificates of the ledger with the standard library alone: ``check.py FOLDER``.

An obligation is a text in SMT-LIB 2.  Its assertions are read as facts ``p >= 0``, ``p > 0`` or ``p
= 0`` about polynomials with exact rational coefficients, and as "and" and "or" of facts.  A choice
(ite) and a quotient are unknown numbers, ``?0``, ``?1`` and so on, in the order in which the text
has them.  A case may state which of its two values a choice has.  A quotient q = n/d satisfies q d
= n once d is shown to be above or below 0.

A point, with a rational number for each symbol, shows that all assertions can hold together.  A
tree shows that they cannot.  It refers to facts by their names:

    ["ite", K, YES, NO]               cases: the choice ?K has its first or its second value
    ["or", FACT, NODE, NODE, ...]     cases: the first, second, ... part of a disjunction holds
    ["cut", NAME, POLYNOMIAL, A, B]   cases: the polynomial is at least 0, or below it
    ["den", K, SIGN, SUM, NODE]       the sum shows that SIGN d > 0 for the denominator d of ?K
    ["sum", PRODUCTS, MULTIPLES]      the end of a case: its facts contradict each other

A product [c, [FACT, ...], [POLYNOMIAL, ...]] with c > 0 has facts that are not negative and squares
of polynomials as factors.  A multiple [FACT, POLYNOMIAL] is that of an equation.  A sum adds them
up to the polynomial 0, although one product is above 0: it has no squares and only facts ``>``.
That is the contradiction.  A polynomial is written [[c, NAME, POWER, ...], ...].

``index.json`` has the SHA-256 of each obligation and of its certificate; both are in a packed file
for each entry.  Work and memory are bounded: a certificate that needs more is refused.
"""

import json
import lzma
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, cast

Number = int | Fraction
Monomial = tuple[tuple[str, int], ...]
Polynomial = dict[Monomial, Number]

MOST_BYTES = 4_000_000
"""Largest size of one unpacked file."""
MOST_WORK = 200_000
"""Units for one obligation: one for each word of 64 bits in a polynomial, ten for a formula."""
MOST_POWER = 100
EXACT = re.compile(r"-?[0-9]+(/[0-9]+)?")
DECIMAL = re.compile(r"[0-9]+\.0")
NAME = re.compile(r"[\w.-]+")
TOKEN = re.compile(r"\(|\)|\|[^|\\\n]*\||[^\s()|]+")
STRICTER = {">=": ">", ">": ">="}
"""Relation to 0 of -p where that of p fails."""


class Refused(Exception):  # noqa: N818
    """A text is not of the expected form, or a certificate does not show what it should."""


class Work:
    """Remaining work allowed for one obligation."""

    left = MOST_WORK

    def spend(self, amount: int) -> None:
        """Raise Refused if more work is requested than is left."""
        self.left -= amount
        need(self.left >= 0, "more work than is allowed")


WORK = Work()


def need(truth: object, why: str) -> None:
    """Raise Refused unless the condition is true."""
    if not truth:
        raise Refused(why)


def exact(value: Any) -> Number:
    """A whole number, or a fraction as text."""
    need(type(value) in (int, str) and EXACT.fullmatch(str(value)), "a number is expected")
    above, _, below = str(value).partition("/")
    need(not below or int(below), "a denominator is 0")
    return _plain(Fraction(int(above), int(below or 1)))


def _plain(value: Number) -> Number:
    return value.numerator if value.denominator == 1 else value


def const(value: Number) -> Polynomial:
    """The polynomial that is this number."""
    return {(): value} if value else {}


def var(name: str) -> Polynomial:
    """The polynomial that is this unknown."""
    return {((name, 1),): 1}


def add(a: Polynomial, b: Polynomial, times: Number = 1) -> Polynomial:
    """a plus a number times b."""
    WORK.spend(_words(a) + _words(b))
    total = dict(a)
    for monomial, c in b.items():
        total[monomial] = total.get(monomial, 0) + times * c
    return {monomial: c for monomial, c in total.items() if c}


def mul(a: Polynomial, b: Polynomial) -> Polynomial:
    """Product of two polynomials."""
    WORK.spend(len(a) * _words(b) + len(b) * _words(a))
    total: Polynomial = {}
    for m, c in a.items():
        for n, d in b.items():
            both = joined(m, n)
            total[both] = total.get(both, 0) + c * d
    return {monomial: c for monomial, c in total.items() if c}


def _words(p: Polynomial) -> int:
    sizes = (c.numerator.bit_length() + c.denominator.bit_length() for c in p.values())
    return sum(1 + size // 64 for size in sizes)


def joined(m: Monomial, n: Monomial) -> Monomial:
    """Product of two monomials."""
    powers = dict(m)
    for name, power in n:
        powers[name] = powers.get(name, 0) + power
        need(powers[name] <= MOST_POWER, "a power is too high")
    return tuple(sorted(powers.items()))


def key(p: Polynomial) -> tuple[tuple[Monomial, Number], ...]:
    """A key that is equal for equal polynomials."""
    return tuple(sorted(p.items()))


def names(p: Polynomial) -> set[str]:
    """Unknowns of a polynomial."""
    return {name for monomial in p for name, _ in monomial}


class Fact(NamedTuple):
    """A polynomial compared with 0: ``>=``, ``>`` or ``=``."""

    poly: Polynomial
    kind: str


class Join(NamedTuple):
    """``and`` or ``or`` of formulas."""

    word: str
    parts: tuple[Any, ...]


Formula = Fact | Join


def negated(formula: Formula) -> Formula:
    """The negation of the formula."""
    WORK.spend(10)
    if isinstance(formula, Join):
        other = "or" if formula.word == "and" else "and"
        return Join(other, tuple(negated(part) for part in formula.parts))
    minus = add({}, formula.poly, -1)
    if formula.kind == "=":
        return Join("or", (Fact(formula.poly, ">"), Fact(minus, ">")))
    return Fact(minus, STRICTER[formula.kind])


def formula_key(formula: Formula) -> tuple[Any, ...]:
    """A key that is equal for equal formulas."""
    WORK.spend(10)
    if isinstance(formula, Fact):
        return key(formula.poly), formula.kind
    return formula.word, tuple(formula_key(part) for part in formula.parts)


def flat(name: str, formula: Formula) -> Iterator[tuple[str, Formula]]:
    """Facts of a formula, with the parts of a conjunction separated."""
    WORK.spend(10)
    if isinstance(formula, Join) and formula.word == "and":
        for number, part in enumerate(formula.parts):
            yield from flat(f"{name}.{number}", part)
    else:
        yield name, formula


class Choice(NamedTuple):
    """A number that is one of two values."""

    condition: Formula
    yes: Polynomial
    no: Polynomial


class Quotient(NamedTuple):
    """A number that is the quotient of two others."""

    above: Polynomial
    below: Polynomial


Value = Polynomial | Formula


class Problem:
    """An obligation: facts by name, and the meanings of the unknowns ?0, ?1, ..."""

    def __init__(self, text: str) -> None:
        self.symbols: list[str] = []
        self.atoms: list[Choice | Quotient] = []
        self.facts: dict[str, Formula] = {}
        self._defined: dict[str, Value] = {}
        self._places: dict[Any, int] = {}
        commands = parsed(text)
        need(commands and commands[-1] == ["check-sat"], "check-sat must be the last command")
        asserted = 0
        for command in commands[:-1]:
            match command:
                case ["set-info" | "set-logic", *_]:
                    pass
                case ["declare-fun", str(name), [], "Real"]:
                    need(name.startswith("|") and name not in self.symbols, f"declared: {name}")
                    self.symbols.append(name)
                case ["define-fun", str(name), [], "Real" | "Bool" as sort, term]:
                    need(name.startswith("$") and name not in self._defined, f"defined: {name}")
                    value = self._defined[name] = self._value(term)
                    need(isinstance(value, dict) == (sort == "Real"), f"{name} is not a {sort}")
                case ["assert", term]:
                    self.facts.update(flat(f"a{asserted}", _formula(self._value(term))))
                    asserted += 1
                case _:
                    raise Refused("a command that is not known")

    def _value(self, term: Any) -> Value:
        if isinstance(term, str):
            if DECIMAL.fullmatch(term):
                return const(int(term[:-2]))
            if term in ("true", "false"):
                return Join("and" if term == "true" else "or", ())
            need(term in self._defined or term in self.symbols, f"not declared: {term}")
            return self._defined[term] if term in self._defined else var(term)
        need(term and isinstance(term[0], str), "an operation is expected")
        word, values = term[0], [self._value(part) for part in term[1:]]
        if word == "ite" and len(values) == 3 and isinstance(values[1], dict):
            condition = _formula(values[0])
            yes, no = values[1], _number(values[2])
            known = formula_key(condition), key(yes), key(no)
            return self._atom(known, Choice(condition, yes, no))
        if values and all(isinstance(value, dict) for value in values):
            return self._real(word, [_number(value) for value in values])
        return _logical(word, [_formula(value) for value in values])

    def _real(self, word: str, values: Sequence[Polynomial]) -> Value:
        """Arithmetic and comparisons."""
        first, *rest = values
        if word == "-" and not rest:
            return add({}, first, -1)
        if word in ("+", "-", "*") and rest:
            for other in rest:
                first = mul(first, other) if word == "*" else add(first, other, int(word + "1"))
            return first
        need(len(rest) == 1, f"operation {word}")
        if word == "/":
            (below,) = rest
            need(below, "division by the number 0")
            if set(below) == {()}:
                return mul(first, const(_plain(Fraction(1) / below[()])))
            return self._atom((key(first), key(below)), Quotient(first, below))
        less, more = add(rest[0], first, -1), add(first, rest[0], -1)
        match word:
            case "=":
                return Fact(more, "=")
            case "distinct":
                return negated(Fact(more, "="))
            case ">" | ">=":
                return Fact(more, word)
            case "<" | "<=":
                return Fact(less, word.replace("<", ">"))
        raise Refused(f"operation {word}")

    def _atom(self, known: Any, meaning: Choice | Quotient) -> Polynomial:
        """The unknown for a choice or a quotient, one for equal ones; unknowns of its parts have
        lower numbers.
        """
        if known not in self._places:
            self._places[known] = len(self.atoms)
            self.atoms.append(meaning)
        return var(f"?{self._places[known]}")

    def holds(self, point: Mapping[str, Any]) -> None:
        """Raise Refused unless all assertions hold at the point."""
        need(isinstance(point, dict) and set(point) == set(self.symbols), "a point is expected")
        at = {name: exact(value) for name, value in point.items()}
        for number, atom in enumerate(self.atoms):
            if isinstance(atom, Choice):
                value = _at(atom.yes if _true(atom.condition, at) else atom.no, at)
            else:
                below = _at(atom.below, at)
                need(below, "a denominator is 0 at the point")
                value = Fraction(_at(atom.above, at)) / below
            at[f"?{number}"] = _plain(value)
        for name, fact in self.facts.items():
            need(_true(fact, at), f"{name} does not hold at the point")


def _formula(value: Value) -> Formula:
    need(not isinstance(value, dict), "a formula is expected")
    return cast(Formula, value)


def _number(value: Value) -> Polynomial:
    need(isinstance(value, dict), "a number is expected")
    return cast(Polynomial, value)


def _logical(word: str, values: Sequence[Formula]) -> Formula:
    """Connectives."""
    shape = word, len(values)
    if word in ("and", "or"):
        return Join(word, tuple(values))
    if shape == ("not", 1):
        return negated(values[0])
    if shape == ("=>", 2):
        return Join("or", (negated(values[0]), values[1]))
    if shape == ("=", 2):
        values = [*values, negated(values[1])]
    else:
        need(shape == ("ite", 3), f"operation {word}")
    condition, yes, no = values
    cases = Join("and", (condition, yes)), Join("and", (negated(condition), no))
    return Join("or", cases)


def _at(p: Polynomial, at: Mapping[str, Number]) -> Number:
    """Value of a polynomial."""
    total: Polynomial = {}
    for monomial, c in p.items():
        term = const(c)
        for name, power in monomial:
            for _ in range(power):
                term = mul(term, const(at[name]))
        total = add(total, term)
    return total.get((), 0)


def _true(formula: Formula, at: Mapping[str, Number]) -> bool:
    if isinstance(formula, Join):
        holds = (_true(part, at) for part in formula.parts)
        return all(holds) if formula.word == "and" else any(holds)
    value = _at(formula.poly, at)
    return value > 0 or (value == 0 and formula.kind == ">=") if formula.kind != "=" else not value


def parsed(text: str) -> list[Any]:
    """The commands of a text as nested lists."""
    need(text.isascii() and text.replace("\n", "").isprintable(), "a character is not allowed")
    lines = (line for line in text.split("\n") if not line.startswith(";"))
    stack: list[list[Any]] = [[]]
    body = "\n".join(lines)
    need(not TOKEN.sub("", body).strip(), "a text that is not understood")
    for token in TOKEN.findall(body):
        if token == "(":
            stack.append([])
        elif token == ")":
            need(len(stack) > 1, "a bracket too many")
            stack[-2].append(stack.pop())
        else:
            stack[-1].append(token)
    need(len(stack) == 1, "a bracket is missing")
    return stack[0]


class Case(NamedTuple):
    """Facts that hold in a case, values of its choices, and denominators of known sign."""

    problem: Problem
    facts: Mapping[str, Formula]
    chosen: Mapping[int, Polynomial]
    signs: Mapping[Any, int]

    def having(self, name: str, formula: Formula) -> "Case":
        """The case in which the formula holds, too."""
        WORK.spend(len(self.facts))
        return self._replace(facts={**self.facts, **dict(flat(name, formula))})

    def taking(self, number: Any, yes: bool) -> "Case":
        """The case in which a choice has its first value, or its second."""
        atom = self._atom(number)
        need(isinstance(atom, Choice) and number not in self.chosen, "an open choice is expected")
        choice = cast(Choice, atom)
        formula = choice.condition if yes else negated(choice.condition)
        chosen = {**self.chosen, number: choice.yes if yes else choice.no}
        return self._replace(chosen=chosen).having(f"{number}{'+' if yes else '-'}", formula)

    def denominator(self, number: Any) -> Polynomial:
        """The denominator of a quotient."""
        atom = self._atom(number)
        need(isinstance(atom, Quotient), "a quotient is expected")
        return cast(Quotient, atom).below

    def signed(self, number: Any, sign: int) -> "Case":
        """The case in which the sign of a quotient's denominator is known."""
        return self._replace(signs={**self.signs, key(self.denominator(number)): sign})

    def _atom(self, number: Any) -> Choice | Quotient:
        need(
            type(number) is int and 0 <= number < len(self.problem.atoms), "a number of an unknown"
        )
        return self.problem.atoms[number]

    def plain(self, p: Polynomial) -> Polynomial:
        """A positive multiple of p, after substitution of known choices and quotients."""
        while ready := self._ready(p):
            top = max(ready)  # what it is made of has smaller numbers, so that this ends
            if top in self.chosen:
                p = put(p, {f"?{top}": self.chosen[top]}, const(1), 1)
                continue
            below = self.denominator(top)
            same = {f"?{k}": atom.above for k in ready
                    if isinstance(atom := self.problem.atoms[k], Quotient)
                    and key(atom.below) == key(below)}  # fmt: skip
            sign = self.signs[key(below)]
            p = put(p, same, add({}, below, sign), sign)
        return p

    def _ready(self, p: Polynomial) -> list[int]:
        """Unknowns of p that can be substituted in this case."""
        atoms = (int(name[1:]) for name in names(p) if name.startswith("?"))
        return [k for k in atoms if k in self.chosen
                or (isinstance(atom := self.problem.atoms[k], Quotient)
                and key(atom.below) in self.signs)]  # fmt: skip

    def fact(self, name: Any) -> Fact:
        """A fact, after substitution of known choices and quotients."""
        need(isinstance(name, str) and name in self.facts, "a fact is expected")
        formula = self.facts[name]
        need(isinstance(formula, Fact), "a disjunction is no fact")
        return Fact(self.plain(cast(Fact, formula).poly), cast(Fact, formula).kind)

    def polynomial(self, given: Any) -> Polynomial:
        """A polynomial, read from a certificate."""
        total: Polynomial = {}
        for term in _list(given):
            need(len(_list(term)) % 2 == 1, "a term is expected")
            product = const(exact(term[0]))
            for name, power in zip(term[1::2], term[2::2], strict=True):
                need(isinstance(name, str) and self._is_known(name), "an unknown name")
                need(type(power) is int and 0 < power <= MOST_POWER, "a power is expected")
                product = mul(product, {((name, power),): 1})
            total = add(total, product)
        return total

    def _is_known(self, name: str) -> bool:
        atoms = len(self.problem.atoms)
        return name in self.problem.symbols or name in {f"?{number}" for number in range(atoms)}

    def ends(self, node: Any) -> None:
        """Raise Refused unless the sum is both 0 and above 0."""
        need(len(_list(node)) == 3 and node[0] == "sum", "a sum is expected")
        total: Polynomial = {}
        strict = False
        for product in _list(node[1]):
            need(len(_list(product)) in (2, 3), "a product is expected")
            value = const(exact(product[0]))
            need(value and value[()] > 0, "a coefficient is not above 0")
            above = len(product) == 2
            for name in _list(product[1]):
                fact = self.fact(name)
                need(fact.kind != "=", f"{name} is an equation")
                value, above = mul(value, fact.poly), above and fact.kind == ">"
            for given in _list(product[2]) if len(product) == 3 else []:
                root = self.polynomial(given)
                value = mul(value, mul(root, root))
            total, strict = add(total, value), strict or above
        for multiple in _list(node[2]):
            need(len(_list(multiple)) == 2, "a multiple is expected")
            fact = self.fact(multiple[0])
            need(fact.kind == "=", "an equation is expected")
            total = add(total, mul(fact.poly, self.polynomial(multiple[1])))
        need(not total, "a sum is not 0")
        need(strict, "no product of a sum is above 0")

    def refuted(self, node: Any) -> None:
        """Raise Refused unless the tree shows that the facts of the case contradict each other."""
        match node:
            case ["sum", *_]:
                self.ends(node)
            case ["ite", number, yes, no]:
                self.taking(number, True).refuted(yes)
                self.taking(number, False).refuted(no)
            case ["or", str(name), *nodes]:
                joined = self.facts.get(name)
                need(isinstance(joined, Join), "a disjunction is expected")
                parts = cast(Join, joined).parts
                need(len(parts) == len(nodes), "a disjunction has another number of parts")
                for number, (part, child) in enumerate(zip(parts, nodes, strict=True)):
                    self.having(f"{name}:{number}", part).refuted(child)
            case ["cut", str(name), given, at_least, under]:
                need(name.startswith("c"), "the name of a cut")
                cut = Fact(self.polynomial(given), ">=")
                self.having(name, cut).refuted(at_least)
                self.having(name, negated(cut)).refuted(under)
            case ["den", number, 1 | -1 as sign, total, child]:
                other = Fact(add({}, self.denominator(number), -sign), ">=")
                self.having("*", other).ends(total)
                self.signed(number, sign).refuted(child)
            case _:
                raise Refused("a node is expected")


def put(
    p: Polynomial, values: Mapping[str, Polynomial], below: Polynomial, sign: int
) -> Polynomial:
    """p with each name replaced by sign value/below, times a power of below, which is above 0."""
    groups: dict[Monomial, Polynomial] = {}
    for monomial, c in p.items():
        inside = tuple(pair for pair in monomial if pair[0] in values)
        outside = tuple(pair for pair in monomial if pair[0] not in values)
        groups.setdefault(inside, {})[outside] = c
    degrees = {inside: sum(power for _, power in inside) for inside in groups}
    most = max(degrees.values())
    total: Polynomial = {}
    for inside, factor in groups.items():
        for name, power in inside:
            for _ in range(power):
                factor = mul(factor, values[name])
        for _ in range(most - degrees[inside]):
            factor = mul(factor, below)
        total = add(total, factor, sign ** degrees[inside])
    return total


def _list(value: Any) -> list[Any]:
    need(isinstance(value, list), "a list is expected")
    return cast(list[Any], value)


def check(text: str, certificate: Any) -> str:
    """``unsat`` or ``sat``, as the certificate shows for an obligation; else raise Refused."""
    WORK.left = MOST_WORK
    try:
        problem = Problem(text)
        match certificate:
            case {"proof": tree, **rest} if not rest:
                Case(problem, problem.facts, {}, {}).refuted(tree)
                return "unsat"
            case {"point": point, **rest} if not rest:
                problem.holds(point)
                return "sat"
    except (RecursionError, ValueError) as error:
        raise Refused(f"too deep or too long: {error}") from None
    raise Refused("a certificate is expected")


def digest(value: Any) -> str:
    """SHA-256 of a text, or of data as JSON."""
    text = value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
    return sha256(text.encode()).hexdigest()


def unpacked(path: Path) -> Any:
    """Data of a JSON file, packed or not."""
    try:
        data = path.read_bytes() if path.stat().st_size <= MOST_BYTES else None
        if data is not None and path.suffix == ".xz":
            packed = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=16 * MOST_BYTES)
            data = packed.decompress(data, MOST_BYTES) if data else b""
            need(packed.eof, f"{path.name} is too long or cut off")
        need(data is not None, f"{path.name} is too long")
        return json.loads(cast(bytes, data), parse_float=_no_float, parse_constant=_no_float)
    except (OSError, lzma.LZMAError, ValueError, RecursionError) as error:
        raise Refused(f"{path.name} cannot be read: {error}") from None


def _no_float(text: str) -> NoReturn:
    raise Refused(f"no exact number: {text}")


def _shown(path: Path, wanted: Iterable[Any]) -> int:
    """Number of obligations of one entry that certificates show."""
    held = unpacked(path) if path.exists() else {}
    shown = 0
    for row in wanted:
        match row:
            case [str(), str(), str(), ""]:
                continue
            case [str(name), str(answer), str(text_hash), str(certificate_hash)]:
                text, certificate = _pair(held.get(name) if isinstance(held, dict) else None)
            case _:
                raise Refused("a row of the index is not understood")
        need(digest(text) == text_hash, f"{name} is another obligation")
        need(digest(certificate) == certificate_hash, f"{name} has another certificate")
        need(check(text, certificate) == answer, f"{name} is not {answer}")
        shown += 1
    return shown


def _pair(item: Any) -> tuple[str, Any]:
    match item:
        case [str(text), certificate]:
            return text, certificate
    raise Refused("an obligation with its certificate is expected")


def rows_of(folder: Path) -> Iterator[tuple[str, list[Any]]]:
    """Each entry of the index, with name, answer and hashes of its obligations."""
    for row in _list(unpacked(folder / "index.json")):
        match row:
            case {"id": str(entry), "obligations": list(wanted)} if NAME.fullmatch(entry):
                yield entry, wanted
            case _:
                raise Refused("a row of the index is not understood")


def main(arguments: Sequence[str]) -> int:
    """0 if all certificates of a folder show what its index says, 1 if not, 2 if unreadable."""
    if len(arguments) != 1:
        sys.stderr.write("usage: check.py FOLDER, the one that has index.json\n")
        return 2
    folder = Path(arguments[0])
    try:
        rows = list(rows_of(folder))
    except Refused as error:
        sys.stderr.write(f"{error}\n")
        return 2
    whole = refused = shown = 0
    for entry, wanted in rows:
        try:
            count = _shown(folder / f"{entry}.json.xz", wanted)
        except (Refused, RecursionError) as error:
            sys.stdout.write(f"REFUSED {entry}: {error}\n")
            refused += 1
            continue
        shown += count
        whole += count == len(wanted) > 0
    asked = sum(len(wanted) for _, wanted in rows)
    sys.stdout.write(f"{shown} of {asked} obligations shown, {refused} entries refused\n")
    sys.stdout.write(f"{whole} entries whole, {len(rows) - whole} without certificate\n")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

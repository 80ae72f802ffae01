"""The checker of certificates: the conclusion of each kind of node, and the files it refuses."""

import json
import lzma
import random
import subprocess
import sys
import tracemalloc
from pathlib import Path

import pytest

from wmr_proofs import check as checker
from wmr_proofs.certificates import FOLDER, held, index
from wmr_proofs.check import Refused, check, digest

ROOT = Path(__file__).parents[2]


def obligation(*asserted, symbols="x y"):
    """A text that asserts these formulas about real numbers."""
    declared = [f"(declare-fun |{name}| () Real)" for name in symbols.split()]
    lines = ["(set-logic QF_NRA)", *declared, *(f"(assert {formula})" for formula in asserted)]
    return "\n".join([*lines, "(check-sat)", ""])


def product(*facts, times="1", squares=()):
    """One product of a sum."""
    return [times, list(facts), [list(root) for root in squares]] if squares else [times, [*facts]]


def total(*products, multiples=()):
    """Return the node of a sum."""
    return ["sum", list(products), [list(item) for item in multiples]]


HALVES = obligation("(> |x| 0.0)", "(< |x| 0.0)")
SQUARE = obligation("(< (+ (* |x| |x|) 1.0) 0.0)")
X = [["1", "|x|", 1]]
CHOICE = obligation("(< (ite (>= |x| 0.0) |x| (- |x|)) 0.0)")
QUOTIENT = obligation("(> |x| 0.0)", "(< (/ 1.0 |x|) 0.0)")
EITHER = obligation("(or (> |x| 1.0) (< |x| (- 1.0)))", "(< (* |x| |x|) 1.0)")
EQUATION = obligation("(= |x| |y|)", "(> (- |x| |y|) 0.0)")
NAMED = obligation("(> |x| 0.0)", "(= |x| (- 1.0))").replace(
    "(assert (=", "(define-fun $1 () Real (- 1.0))\n(assert (="
)
BOTH = total(product("a0"), product("a1"))
GOOD = [
    (HALVES, BOTH),
    (SQUARE, total(product("a0"), product(times="1", squares=(X,)), product())),
    (
        CHOICE,
        ["ite", 0, total(product("a0"), product("0+")), total(product("a0"), product("0-"))],
    ),
    (
        QUOTIENT,
        [
            "den", 0, 1, total(product("a0"), product("*")),
            total(product("a1"), product()),
        ],
    ),
    (
        EITHER,
        [
            "or", "a0",
            total(product("a1"), product("a0:0", "a0:0"), product("a0:0", times="2")),
            total(product("a1"), product("a0:1", "a0:1"), product("a0:1", times="2")),
        ],
    ),
    (EQUATION, total(product("a1"), multiples=(("a0", [["-1"]]),))),
    (
        SQUARE,
        [
            "cut", "c0", X, total(product("a0"), product("c0", "c0"), product()),
            total(product("a0"), product("c0", "c0"), product()),
        ],
    ),
]  # fmt: skip


@pytest.mark.parametrize("text, tree", GOOD)
def test_each_kind_of_node_shows_what_it_says(text, tree):
    assert check(text, {"proof": tree}) == "unsat"


@pytest.mark.parametrize(
    "text, tree",
    [
        (HALVES, total(product("a0"))),
        (HALVES, total(product("a0"), product("a1", times="-1"))),
        (HALVES, total(product("a0"), product("a1", times="0"))),
        (HALVES, total(product("a0", times="1.0"), product("a1"))),
        (HALVES, total(product("a0"), product("a2"))),
        (HALVES, total()),
        (HALVES.replace("(<", "(<=").replace("(>", "(>="), BOTH),
        (HALVES, ["ite", 0, BOTH, BOTH]),
        (HALVES, ["cut", "a0", X, BOTH, BOTH]),
        (HALVES, ["cut", "c0", [["1", "|z|", 1]], BOTH, BOTH]),
        (HALVES, ["cut", "c0", [["1", "|x|", -1]], BOTH, BOTH]),
        (HALVES, ["cut", "c0", X, BOTH]),
        (SQUARE, total(product("a0"), product(times="1", squares=(X,)))),
        (CHOICE, ["ite", 0, GOOD[2][1][2], GOOD[2][1][3][:1]]),
        (CHOICE, ["ite", 0, GOOD[2][1][3], GOOD[2][1][2]]),
        (CHOICE, ["ite", -1, GOOD[2][1][2], GOOD[2][1][3]]),
        (QUOTIENT, ["den", 0, -1, *GOOD[3][1][3:]]),
        (QUOTIENT, GOOD[3][1][4]),
        (EITHER, GOOD[4][1][:3]),
        (EQUATION, total(product("a1"), product("a0", times="1"))),
        (EQUATION, total(multiples=(("a0", []),))),
    ],
)
def test_what_shows_nothing_is_refused(text, tree):
    with pytest.raises(Refused):
        check(text, {"proof": tree})


@pytest.mark.parametrize(
    "text",
    [
        obligation("true").replace("(check-sat)", ""),
        obligation("(> |z| 0.0)"),
        obligation("(> |x| 0.0)", symbols="x x"),
        obligation("(> x 0.0)"),
        obligation("(> |x| 1e3)"),
        obligation("(> |x| 0)"),
        obligation("(> (/ |x| 0.0) 0.0)"),
        obligation("(exists ((z Real)) (> z |x|))"),
        obligation("(> |x| |y| 0.0)"),
        obligation("(=> |x| true)"),
        obligation("(ite true |x| true)"),
        obligation("|x|"),
        obligation("(> |x| 0.0))"),
        obligation("(> |x| 0.0)").replace("(check-sat)", "(push 1)\n(check-sat)"),
        obligation("true") + "; a comment\u2028(assert false)",
        obligation("true") + "; a comment\r(assert false)",
        NAMED.replace("() Real (- 1.0)", "() Bool (- 1.0)"),
        NAMED.replace("$1", "|x|"),
    ],
)
def test_another_text_than_is_expected_is_refused(text):
    for certificate in ({"proof": BOTH}, {"point": {"|x|": "1", "|y|": "0"}}):
        with pytest.raises(Refused):
            check(text, certificate)


def test_a_point_meets_what_is_asserted():
    text = obligation("(= (* |x| |x|) (/ 1.0 4.0))", "(> (/ 1.0 |y|) |x|)", "(not (= |x| |y|))")

    assert check(text, {"point": {"|x|": "-1/2", "|y|": "1"}}) == "sat"
    for x, y in (("1/2", "2"), ("1/3", "1"), ("1/2", "0"), ("0.5", "1"), ("1/0", "1"), (0.5, "1")):
        with pytest.raises(Refused):
            check(text, {"point": {"|x|": x, "|y|": y}})
    with pytest.raises(Refused):
        check(text, {"point": {"|x|": "-1/2"}})


@pytest.mark.parametrize(
    "certificate",
    [
        None, [], {}, {"proof": BOTH, "point": {}}, {"tree": BOTH}, {"proof": {}},
        {"proof": ["sum", [["1", ["a0"], [], []]], []]}, {"proof": ["sum", "a0", []]},
        {"proof": ["sum", [[True, ["a0"]], ["1", ["a1"]]], []]},
        {"proof": ["sum", [["1", [["a0"]]], ["1", ["a1"]]], []]},
    ],
)  # fmt: skip
def test_another_certificate_than_is_expected_is_refused(certificate):
    with pytest.raises(Refused):
        check(HALVES, certificate)


def doubling(sort, first, step, last):
    """Text of sixty definitions; each reads the previous definition twice."""
    lines = [f"(define-fun $0 () {sort} {first})"]
    lines += [f"(define-fun ${k + 1} () {sort} {step.replace('$', f'${k}')})" for k in range(60)]
    return obligation(last).replace("(assert", "\n".join([*lines, "(assert"]))


def deep(node):
    for _ in range(100_000):
        node = ["cut", "c0", X, node, node]
    return node


HOSTILE = {
    "a high power": (HALVES, ["cut", "c0", [["1", "|x|", 10**12]], BOTH, BOTH]),
    "a long number": (HALVES, total(product("a0", times="9" * 5000), product("a1"))),
    "an exponent": (HALVES, total(product("a0", times="1e999999999"), product("a1"))),
    "a power tower": (doubling("Real", "|x|", "(* $ $)", "(> $60 0.0)"), total(product("a0"))),
    "a tower of numbers": (doubling("Real", "3.0", "(* $ $)", "(> $60 0.0)"), total(product("a0"))),
    "many terms": (
        doubling("Real", "(+ |x| |y|)", "(+ (* $ |x|) (* $ $))", "(> $60 0.0)"),
        total(product("a0")),
    ),
    "many conditions": (
        doubling("Bool", "(> |x| 0.0)", "(= $ $)", "(not $60)"),
        total(product("a0")),
    ),
    "many factors": (HALVES, total(product(*["a0"] * 3000), product("a1"))),
    "squares of sums": (
        HALVES,
        total(
            product(
                "a0", squares=([[str(k), "|x|", k + 1, "|y|", 90 - k] for k in range(90)],) * 50
            )
        ),
    ),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_asks_for_all_of_the_memory_is_refused(name):
    text, tree = HOSTILE[name]
    tracemalloc.start()
    try:
        with pytest.raises(Refused):
            check(text, {"proof": tree})
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()

    assert peak < 300e6


def test_what_is_too_deep_is_refused():
    with pytest.raises(Refused):
        check(HALVES, {"proof": deep(BOTH)})


def folder_with(path, text, certificate, answer="unsat"):
    """A folder of one entry with one obligation."""
    rows = [["goal-1", answer, digest(text), digest(certificate)]]
    (path / "index.json").write_text(json.dumps([{"id": "own", "obligations": rows}]))
    data = json.dumps({"goal-1": [text, certificate]}).encode()
    (path / "own.json.xz").write_bytes(lzma.compress(data))
    return path


def said(folder):
    """Exit code and text of the checker, run as a program with no package beside it."""
    command = [sys.executable, "-I", "-S", str(ROOT / "wmr_proofs" / "check.py"), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    return done.returncode, done.stdout + done.stderr


def test_files_that_cannot_be_read_are_refused(tmp_path):
    assert said(tmp_path)[0] == 2
    assert said(folder_with(tmp_path, HALVES, {"proof": BOTH})) == (
        0, "1 of 1 obligations shown, 0 entries refused\n1 entries whole, 0 without certificate\n"
    )  # fmt: skip
    packed = tmp_path / "own.json.xz"
    good = packed.read_bytes()
    texts = (b" " * 50_000_000, b'{"goal-1": ["", 1e5]}', b"[" * 200_000)
    for data in (good[:-9], b"", b"[" * 50_000, *map(lzma.compress, texts)):
        packed.write_bytes(data)
        code, text = said(tmp_path)
        assert (code, "REFUSED own" in text) == (1, True), text
        assert "Traceback" not in text
    packed.unlink()
    assert said(tmp_path)[0] == 1
    for rows in ("{}", "[1]", '[{"id": "../own", "obligations": []}]', "[" * 5000, "1e5"):
        (tmp_path / "index.json").write_text(rows)
        assert said(tmp_path)[0] == 2


def test_another_answer_or_hash_than_in_the_index_is_refused(tmp_path):
    assert said(folder_with(tmp_path, HALVES, {"proof": BOTH}, "sat"))[0] == 1
    folder_with(tmp_path, HALVES, {"proof": BOTH})
    path = tmp_path / "index.json"
    path.write_text(path.read_text().replace(digest(HALVES), digest(SQUARE)))
    assert said(tmp_path)[0] == 1


def test_with_hashes_as_committed_every_alteration_is_refused():
    """One character of a text or of a certificate is replaced."""
    rng = random.Random(0)
    whole = [row for row in index().values() if all(item[3] for item in row["obligations"])]
    for row in rng.sample(whole, 5):
        items = held(row["id"])
        for name, answer, text_hash, certificate_hash in row["obligations"]:
            text, packed = items[name][0], json.dumps(items[name][1], separators=(",", ":"))
            assert check(text, json.loads(packed)) == answer
            assert digest(altered(text, rng)) != text_hash
            assert digest(altered(packed, rng)) != certificate_hash == digest(packed)


def altered(text, rng):
    """The text with another character somewhere."""
    place = rng.randrange(len(text))
    other = rng.choice(sorted(set("0123456789+-a ") - {text[place]}))
    return text[:place] + other + text[place + 1 :]


def test_it_reads_a_folder_in_the_package(tmp_path):
    code = "import sys, wmr_proofs.check as c; sys.exit(c.main(sys.argv[1:]))"
    folder = folder_with(tmp_path, HALVES, {"proof": BOTH})
    done = subprocess.run(
        [sys.executable, "-S", "-c", code, str(folder)], cwd=ROOT, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert checker.main([str(FOLDER), "more"]) == 2

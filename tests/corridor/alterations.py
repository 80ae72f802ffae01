"""Alter each bound of the corridor's computation, one at a time: who notices?

    python -m tests.corridor.alterations [FILE ...] [--no-tests]

Each ``<=`` and ``>=``, each maximum and minimum, and each ``&=`` of `wmr_proofs/corridor` is turned
into its opposite in a copy.  The checker notices if a certificate of CASES is refused, or the
computation fails; else the default tests of this folder run.  Prints what nobody notices.
"""

import ast
import subprocess
import sys
import tempfile
from pathlib import Path
from shutil import copytree

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "wmr_proofs" / "corridor"
OPPOSITE = {
    "max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum",
    ast.LtE: ast.Gt(), ast.GtE: ast.Lt(),
}  # fmt: skip
NO_BOUND = {
    ("along.py", "memory"), ("along.py", "batch"), ("along.py", "young"), ("along.py", "spacings"),
    ("along.py", "count_from"), ("along.py", "brief"), ("along.py", "chunks"),
    ("along.py", "is_slow"), ("along.py", "matrices"), ("along.py", "__init__"),
    ("along.py", "typical"), ("along.py", "pairs"), ("stretch.py", "forgets"),
    ("passage.py", "_slowly"), ("passage.py", "_held"), ("passage.py", "_chunk"),
    ("remainders.py", "_too_wide"), ("instant.py", "going_on"), ("gains.py", "_samples"),
    ("whole.py", "_closing"), ("whole.py", "_least"), ("whole.py", "_passes"),
    ("certificate.py", "_closed"), ("stated.py", "of_loop"), ("stated.py", "of_run"),
}  # fmt: skip
"""Functions that choose sizes, counts or an order; whatever they choose is verified afterwards."""


def places(source):
    """Function, line, and a function that alters a tree, of each place."""
    tree, found = ast.parse(source), []
    for owner in ast.walk(tree):
        if not isinstance(owner, ast.FunctionDef):
            continue
        for node in ast.walk(owner):
            name = getattr(getattr(node, "func", None), "id", None) or getattr(
                getattr(node, "func", None), "attr", None
            )
            compares = isinstance(node, ast.Compare) and type(node.ops[0]) in OPPOSITE
            joins = isinstance(node, ast.AugAssign) and isinstance(node.op, ast.BitAnd)
            if name in OPPOSITE or compares or joins:
                found.append((owner.name, node.lineno, node))
    return tree, [*{id(node): (name, line, node) for name, line, node in found}.values()]


def altered(tree, node):
    """The text with one node turned into its opposite, and the node as it was."""
    before = ast.unparse(node)
    if isinstance(node, ast.Compare):
        node.ops[0] = OPPOSITE[type(node.ops[0])]
        undo = {ast.Gt: ast.LtE(), ast.Lt: ast.GtE()}[type(node.ops[0])]
        text = ast.unparse(tree)
        node.ops[0] = undo
    elif isinstance(node, ast.AugAssign):
        node.op, text = ast.BitOr(), None
        text = ast.unparse(tree)
        node.op = ast.BitAnd()
    else:
        key = "id" if hasattr(node.func, "id") else "attr"
        own = getattr(node.func, key)
        setattr(node.func, key, OPPOSITE[own])
        text = ast.unparse(tree)
        setattr(node.func, key, own)
    return text, before


def noticed(name, text, tests):
    """Whether the checker or a test notices a file's other text; None if nobody does."""
    with tempfile.TemporaryDirectory() as folder:
        copytree(ROOT / "wmr_proofs", Path(folder) / "wmr_proofs")
        (Path(folder) / "wmr_proofs" / "corridor" / name).write_text(text)
        begin = f"import sys; sys.path.insert(0, {folder!r}); import pytest, wmr_proofs.corridor"
        code = f"{begin}; sys.exit(pytest.main(sys.argv[1:]))"
        told = ["-n", "0", "-q", "-x", "-p", "no:cacheprovider"]
        runs = [("checker", ["tests/corridor/test_checker.py", "-k", "states or whole"])]
        if tests:
            runs.append(("tests", ["tests/corridor"]))
        for who, files in runs:
            command = [sys.executable, "-c", code, *told, *files]
            if subprocess.run(command, cwd=ROOT, capture_output=True).returncode:
                return who
    return None


def main(given):
    """Alter all, or those of the named files."""
    tests, names = "--no-tests" not in given, [item for item in given if item[0] != "-"]
    for path in sorted(FOLDER.glob("*.py")):
        if names and path.name not in names:
            continue
        tree, found = places(path.read_text())
        for owner, line, node in found:
            if (path.name, owner) in NO_BOUND:
                continue
            text, before = altered(tree, node)
            who = noticed(path.name, text, tests)
            print(f"{path.name}:{line} {owner}: {before[:70]}: {who or 'NOBODY'}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

"""Alter each bound of the corridor's computation, one at a time, and print who notices.

    python -m tests.corridor.alterations [FILE ...]

Each ``<=`` and ``>=``, each maximum and minimum, and each ``&=`` of `wmr_proofs/corridor` is turned
into its opposite.  The checker notices if a case of PROBES no longer gets a width; otherwise the
default tests of this folder run.
"""

import ast
import os
import sys
from contextlib import redirect_stdout
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType

import pytest

from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_proofs.corridor.asked import certified_corridor, run_corridor
from wmr_proofs.corridor.inputs import is_steady

FOLDER = Path(__file__).parents[2] / "wmr_proofs" / "corridor"
OPPOSITE = {
    "max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum",
    ast.LtE: ast.Gt, ast.GtE: ast.Lt, ast.BitAnd: ast.BitOr,
}  # fmt: skip
MISLED = changes("sensor.pose_noise = 1e-5; sensor.velocity_noise = [1e-4, 2e-4]")
PROBES = (
    ("kanayama", safe(MISLED, "guard.enabled = false; changes = []")),
    ("prox", safe("guard.enabled = false; actuator.jitter = 0.002; changes = []",
                  "corridor.start = [1e-4, 1e-4, 1e-3]")),
    ("mb", safe("reference.kind = lemniscate; clock.duration = 1.0; disturbance.std = 0.5",
                "changes = [{t = 0.505, m = 60.0}]")),
    ("prox", safe("reference.kind = stop-and-go; reference.radius = 2.0; reference.period = 4.0",
                  "reference.speed = 0.2; robot.mu = 0.02; disturbance.std = 0.1; changes = []",
                  "clock.control = 0.02; clock.duration = 1.0")),
)  # fmt: skip
NO_BOUND = {
    "along.py": """memory batch young spacings count_from brief chunks is_slow matrices __init__
                   typical pairs ratios steady_until distance off turned""",
    "carried.py": "_absolute", "certificate.py": "position",
    "stretch.py": "forgets", "remainders.py": "_too_wide", "instant.py": "going_on",
    "passage.py": "_slowly _held _chunk _expected", "gains.py": "_samples", "peaks.py": "limit",
    "whole.py": "_closing _least _passes", "stated.py": "of_loop of_run",
}  # fmt: skip
"""Functions that choose sizes, counts, or an order, which is verified afterwards, or whose distance
is no less than the checker's own when it is printed."""
HARMLESS = {
    "(begun.fast[:ROBOT] / scale[:ROBOT]).max()": "how far a box may grow until it is given up",
    "self.latest[place].max(axis=0)": "a box that a deviation leaves is made anew (`_bent`)",
}
"""Further bounds that choose something, and what."""


def places(tree):
    """Each function with the syntax nodes of its bounds."""
    for owner in ast.walk(tree):
        for node in ast.walk(owner) if isinstance(owner, ast.FunctionDef) else ():
            call = getattr(node, "func", None)
            key = getattr(call, "id", getattr(call, "attr", None))
            if isinstance(node, ast.Compare):
                key = type(node.ops[0])
            elif isinstance(node, ast.AugAssign):
                key = type(node.op)
            if key in OPPOSITE:
                yield owner.name, node, OPPOSITE[key]


def turn(node, other):
    """Turn a node into its opposite."""
    if isinstance(node, ast.Compare):
        node.ops[0] = other()
    elif isinstance(node, ast.AugAssign):
        node.op = other()
    else:
        setattr(node.func, "id" if isinstance(node.func, ast.Name) else "attr", other)


def put(module, tree):
    """Replace the code of the module's functions by that of another syntax tree."""
    codes, left = {}, [compile(tree, module.__file__, "exec")]
    while left:
        code = left.pop()
        codes[code.co_qualname] = code
        left += [item for item in code.co_consts if isinstance(item, CodeType)]
    owners = [module, *(item for item in vars(module).values() if isinstance(item, type))]
    for value in [value for owner in owners for value in vars(owner).values()]:
        if isinstance(value, property | cached_property):
            value = value.fget if isinstance(value, property) else value.func
        if isinstance(value, FunctionType) and value.__module__ == module.__name__:
            value.__code__ = codes.get(value.__qualname__, value.__code__)


def refused():
    """True if a probe has no width."""
    for law, scenario in PROBES:
        try:
            steady = is_steady(setup := settle(scenario, law))
            tube = certified_corridor(setup) if steady else run_corridor(scenario, law)
        except Exception:
            return True
        if tube.position is None:
            return True
    return False


def noticed():
    """Name of the test or checker that notices the altered code."""
    if refused():
        return "checker"
    with open(os.devnull, "w") as nothing, redirect_stdout(nothing):
        failed = pytest.main(["-n", "0", "-q", "-x", "-p", "no:cacheprovider", "tests/corridor"])
    return "tests" if failed else "NOBODY"


def main(names):
    """Alter all files, or only the named ones."""
    if not (child := os.fork()):
        os._exit(refused())
    assert os.waitpid(child, 0)[1] == 0, "a probe has no width without any alteration"
    for path in sorted(FOLDER.glob("*.py")):
        if names and path.name not in names:
            continue
        text, module = path.read_text(), import_module(f"wmr_proofs.corridor.{path.stem}")
        for k, (owner, node, _) in enumerate(places(ast.parse(text))):
            if owner in NO_BOUND.get(path.name, "").split() or ast.unparse(node) in HARMLESS:
                continue
            if child := os.fork():
                os.waitpid(child, 0)
                continue
            tree = ast.parse(text)
            found = [*places(tree)][k]
            turn(*found[1:])
            put(module, tree)
            print(f"{path.name}:{node.lineno} {owner}: {ast.unparse(node)[:70]}: {noticed()}")
            sys.stdout.flush()
            os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1:])

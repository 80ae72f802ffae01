"""Alter each bound of the corridor's computation, one at a time, and print who notices.

    python -m tests.corridor.alterations [FILE ...]

Each ``<=`` and ``>=``, each maximum and minimum, and each ``&`` of `wmr_proofs/corridor` is turned
into its opposite.  The checker notices if a case of PROBES no longer gets a width; otherwise the
default tests of this folder run.
"""

import ast
import os
import sys
from contextlib import redirect_stdout
from importlib.util import find_spec, module_from_spec
from pathlib import Path

import pytest

from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl.control.setup import settle

FOLDER = Path(__file__).parents[2] / "wmr_proofs" / "corridor"
OPPOSITE = {
    "max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum",
    "fmax": "fmin", "fmin": "fmax",
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
    "along.py": """memory batch young spacings count_from brief chunks is_slow matrices knots
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
    "max(growth, 1.0)": "with how many bits a matrix is computed, which `doubles` verifies",
    "linear.max(axis=0)": "where the search for an error of dead reckoning begins",
}
"""Further bounds that choose something, and what."""


def places(tree, owner=""):
    """Function and text of each bound, and where it stands: a syntax node, field and index."""
    for node in ast.iter_child_nodes(tree):
        for field, value in ast.iter_fields(node):
            for k, item in enumerate(value if isinstance(value, list) else [value]):
                if OPPOSITE.get(item if isinstance(item, str) else type(item)):
                    text = ast.unparse(tree if isinstance(tree, ast.Call) else node)
                    yield owner, text, (node, field, k)
        yield from places(node, node.name if isinstance(node, ast.FunctionDef) else owner)


def turn(node, field, k):
    """Turn a bound into its opposite."""
    value = getattr(node, field)
    if isinstance(value, list):
        value[k] = OPPOSITE[type(value[k])]()
    else:
        setattr(node, field, OPPOSITE.get(value) or OPPOSITE[type(value)]())


def put(path, tree):
    """Import a module of the corridor, of which nothing has been imported, from a syntax tree."""
    spec = find_spec(f"wmr_proofs.corridor.{path.stem}")
    module = sys.modules[spec.name] = module_from_spec(spec)
    exec(compile(tree, path, "exec"), vars(module))
    setattr(sys.modules["wmr_proofs.corridor"], path.stem, module)


def refused():
    """True if a probe has no width."""
    from wmr_proofs.corridor.asked import certified_corridor, run_corridor
    from wmr_proofs.corridor.inputs import is_steady

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
        tree = ast.parse(path.read_text())
        for owner, text, place in [*places(tree)]:
            if owner in NO_BOUND.get(path.name, "").split() or text in HARMLESS:
                continue
            if child := os.fork():
                os.waitpid(child, 0)
                continue
            turn(*place)
            put(path, tree)
            print(f"{path.name}:{place[0].lineno} {owner}: {text[:70]}: {noticed()}", flush=True)
            os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1:])

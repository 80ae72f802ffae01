"""Second solvers: questions that z3 closes are asked of Yices and, if it does not answer, of cvc5.

The three decide products of unknowns each by their own code.  Yices is a program, which its wheel
puts beside the interpreter.
"""

import resource
import shutil
import subprocess
import sys
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

from tests.proofs.cases import cases
from wmr_proofs.graph import UndecidedError
from wmr_proofs.methods.obligations import obligations
from wmr_proofs.statement import own_point

IMPATIENCE, PATIENCE = 2, 10
"""Seconds of the processor's time for one obligation and strategy, at first and in the end, so that
a busy machine finds the same."""
COVERINGS = {"nl-cov": "true", "nl-ext": "none"}
STRATEGIES = {
    "as it comes": {},
    "coverings": COVERINGS,
    "coverings, justified": {**COVERINGS, "decision": "justification"},
    "coverings, equalities split": {**COVERINGS, "arith-rewrite-equalities": "true"},
}
"""cvc5's ways with products of unknowns, one after the other: linear lemmas by default, and cells
that cover the space (cylindrical algebraic coverings), whose luck hangs on what comes first."""
LONGEST = 300.0
"""Seconds for one obligation by the clock, whatever the processor does meanwhile."""

_CVC5 = """
import sys, cvc5
solver = cvc5.Solver(cvc5.TermManager())
for name, value in zip(sys.argv[1::2], sys.argv[2::2]):
    solver.setOption(name, value)
parser = cvc5.InputParser(solver)
parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, sys.stdin.read(), "obligation")
symbols = parser.getSymbolManager()
while not (command := parser.nextCommand()).isNull():
    sys.stdout.write(command.invoke(solver, symbols))
"""


def programs():
    """Return the installed solvers by name: their strategies as commands that read a file.

    The quicker solver comes first.
    """
    own = Path(sys.executable).with_name("yices-smt2")
    yices = own if own.exists() else shutil.which(own.name)
    asked = [[sys.executable, "-c", _CVC5, *chain(*way.items())] for way in STRATEGIES.values()]
    found = {"yices": [[str(yices)]] if yices else [], "cvc5": asked if find_spec("cvc5") else []}
    return {name: commands for name, commands in found.items() if commands}


def confirmed_by(statement, point=None, patience=PATIENCE):
    """Return the first solver that finds every goal and every domain unsatisfiable, or ().

    It does so as a whole or in every case of the choices (`tests.proofs.cases`).  It must also find
    the hypotheses satisfiable, at ``point`` if given.  Parts of a statement are taken one by one.
    """
    if statement.parts:
        found = [confirmed_by(part, own_point(point or {}, part, key), patience)
                 for key, part in statement.parts.items()]  # fmt: skip
        return tuple(sorted(set(chain(*found)))) if all(found) else ()
    *wrong, hypotheses = obligations(statement, point)
    for name in programs():

        def says(word, text, name=name):
            return answer(name, text, patience) == word

        if says("sat", hypotheses.text) and (
            all(says("unsat", item.text) for item in wrong) or _all_cases(statement, says)
        ):
            return (name,)
    return ()


def _all_cases(statement, says):
    try:
        return all(says("unsat", text) for text in cases(statement))
    except UndecidedError:  # more cases than are tried
        return False


def answer(name, text, patience=PATIENCE):
    """A solver's answer to a file: sat, unsat or unknown; each strategy first briefly, then for
    longer.
    """
    limits = [limit for limit in (IMPATIENCE, patience) if limit <= patience]
    said = (_said(text, limit, way) for limit in limits for way in programs()[name])
    return next((word for word in said if word in ("sat", "unsat")), "unknown")


def _said(text, patience, command):
    """Return a solver's answer to ``text``, or "unknown".

    The solver runs in a process that can be ended: solvers do not always keep to their limits.
    """

    def limited():
        resource.setrlimit(resource.RLIMIT_CPU, (patience, patience))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    try:
        done = subprocess.run(
            command, input=text, capture_output=True, text=True, timeout=LONGEST, check=False,
            preexec_fn=limited,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "unknown"
    return done.stdout.strip() or "unknown"

"""Rooms that are neither too small nor shared by two things of one name."""

from __future__ import annotations

import ast
from collections import defaultdict

from tests.architecture.tree import (
    Module,
    functions,
    modules,
    names_of_modules,
    nodes_of,
    offenders,
)

SHORT = 30
"""Lines of code below which a file with a single user should live with that user."""
KEPT_SHORT = {
    "wmr_ctrl.world.command_dead_band": "an effect has a file",
    "wmr_ctrl.world.command_quantum": "an effect has a file",
    "wmr_ctrl.world.wheel_speed_limit": "an effect has a file",
}
"""Short files with one user that are looked up by name, and why."""
BY_NAME = ("wmr_ctrl.laws.",)
"""Folders with a file for each name that users type: a law."""
ELSEWHERE = ("wmr_proofs.", "wmr_ctrl.codegen.")

NO_NOUNS = {"found", "made", "told", "settled", "kept"}
SNIFFED = {
    "wmr_ctrl.core.fields.files": "only some errors of the system have a text",
    "wmr_ctrl.core.fields.values": "arrays of any library give their numbers by tolist",
    "wmr_proofs.alterations": "walks values of any class to the part that a claim alters",
    "wmr_ctrl.results.files": "only some errors of the system have a number",
    "wmr_ctrl.results.formats": "only some errors of the system have a text",
    "wmr_ctrl.simulation.batch": "os.sched_getaffinity is on Linux only",
}
"""Where an object may be asked for a name that it may not have, and why."""


def lines_of_code(module: Module) -> int:
    """Lines that are neither empty, comments, texts by themselves nor imports."""
    rest = {
        line
        for node in nodes_of(module.tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    lines = enumerate(module.text.splitlines(), start=1)
    written = ((n, line.strip()) for n, line in lines if n not in rest)
    return sum(1 for _, line in written if line and not line.startswith("#"))


def users() -> dict[str, set[str]]:
    """Modules by the modules that they import, typing included."""
    by_module = defaultdict(set)
    for module in modules():
        for name in module.imports(typing=True):
            by_module[name].add(module.name)
    return by_module


def asked_for_by_name(module: Module, by: dict[str, set[str]]) -> bool:
    """A law; what its package shows to others; what runs by itself."""
    package = module.name.rpartition(".")[0]
    shown = by[module.name] == {package}
    alone = "__main__" in module.text
    return module.name.startswith(BY_NAME) or shown or alone or module.name in KEPT_SHORT


def test_no_file_is_a_fragment_of_its_only_user():
    by = users()
    short = {
        module.name: sorted(by[module.name])
        for module in modules()
        if module.path.name != "__init__.py"
        and lines_of_code(module) < SHORT
        and len(by[module.name]) < 2
        and not asked_for_by_name(module, by)
        and not module.name.startswith("wmr_ctrl.codegen.")
    }

    assert short == {}


def test_reasons_for_short_files_are_about_files_that_are_there():
    assert set(KEPT_SHORT) | set(SNIFFED) <= names_of_modules()
    assert all(lines_of_code(m) < SHORT for m in modules() if m.name in KEPT_SHORT)


def test_a_class_name_stands_for_one_class():
    places = defaultdict(list)
    for module in modules():
        for node in nodes_of(module.tree):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(module.name)
    doubles = {name: where for name, where in places.items() if len(where) > 1}

    assert doubles == {}


def test_values_are_named_by_nouns():
    def verbs(module: Module) -> set[str]:
        if module.name.startswith(ELSEWHERE):
            return set()
        return named(module.tree) & NO_NOUNS

    assert offenders(verbs) == {}


def named(tree: ast.Module) -> set[str]:
    """Names of variables, parameters and fields."""
    nodes = nodes_of(tree)
    values = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    fields = {
        n.attr for n in nodes if isinstance(n, ast.Attribute) and isinstance(n.ctx, ast.Store)
    }
    return values | fields | {n.arg for n in nodes if isinstance(n, ast.arg)}


def test_nothing_is_asked_for_names_that_it_may_not_have():
    assert set(offenders(sniffed)) <= set(SNIFFED)


def sniffed(module: Module) -> list[str]:
    """Calls of hasattr, and of getattr with a text."""
    calls = [node for node in nodes_of(module.tree) if isinstance(node, ast.Call)]
    return [
        ast.unparse(call)
        for call in calls
        if isinstance(call.func, ast.Name)
        and call.func.id in ("getattr", "hasattr")
        and (call.func.id == "hasattr" or isinstance(call.args[1], ast.Constant))
    ]


def test_the_checks_see_what_they_should():
    text = (
        "import os\n\n\ndef f(found, a):\n    '''Text.'''\n    kept = getattr(a, 'b')  # why\n"
        "    a.made = hasattr(kept, found)\n    return getattr(a, found)\n"
    )
    module = Module("wmr_ctrl.x", next(m.path for m in modules()), text, ast.parse(text))

    assert named(module.tree) & NO_NOUNS == {"found", "kept", "made"}
    assert len(sniffed(module)) == 2
    assert lines_of_code(module) == 4
    assert [f.name for f in functions(module.tree)] == ["f"]

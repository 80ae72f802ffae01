"""Tests are paired with modules by their names.

The functions of ``wmr_ctrl/ROOM/NAME.py`` are called in ``tests/ROOM/test_NAME.py``.  Another file
of tests begins with the name of a module beside the one that it is about, or with its folder's.
"""

import ast
from functools import cache

from tests.architecture.tree import ROOT, functions, modules, nodes_of

TESTS = ROOT / "tests"
ROOMS = ("core", "results", "world", "control", "codegen", "simulation", "export")
WITHOUT = {}
"""Modules that need no test of their own, and why."""


@cache
def parsed():
    """Every Python file below tests, parsed."""
    return {path: ast.parse(path.read_text("utf-8")) for path in sorted(TESTS.rglob("*.py"))}


@cache
def paired():
    """The modules of these rooms that have functions, each with the file of its test."""
    found = (item for item in modules() if item.room in ROOMS and item.path.stem != "__init__")
    return {item: mirrored_test(item.path) for item in found if any(functions(item.tree))}


def mirrored_test(path):
    return TESTS / path.relative_to(ROOT / "wmr_ctrl").with_name(f"test_{path.name}")


def test_every_module_has_its_test_and_is_called_there():
    faults = {item.name: why for item, path in paired().items() if (why := fault(item, path))}

    assert {name: why for name, why in faults.items() if name not in WITHOUT} == {}
    assert set(WITHOUT) <= set(faults)


def fault(module, path):
    """Fault of a module's test; empty if it calls the module and asserts something."""
    if path not in parsed():
        return f"{path.relative_to(ROOT)} is missing"
    tree = parsed()[path]
    if not uses(tree, module.name):
        return f"{path.relative_to(ROOT)} calls nothing of it"
    return "" if asserts(tree) else f"{path.relative_to(ROOT)} asserts nothing"


def uses(tree, name):
    """True if functions of a test use what they import from a module."""
    imported = {given for given, home in imports_of(tree) if home == name}
    named = (node.id for node in nodes_of(tree) if isinstance(node, ast.Name))
    return not imported.isdisjoint(named)


def imports_of(tree):
    """Names that a file imports, each with the module where it is defined."""
    for node in nodes_of(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("wmr_ctrl"):
            for alias in node.names:
                yield alias.asname or alias.name, home(node.module or "", alias.name)


@cache
def home(package, name):
    """The module that defines a name, following re-exports by packages."""
    by_name = {item.name: item for item in modules()}
    if f"{package}.{name}" in by_name:
        return f"{package}.{name}"
    if package not in by_name or by_name[package].path.stem != "__init__":
        return package
    own = by_name[package]
    stub = own.path.with_suffix(".pyi")
    tree = ast.parse(stub.read_text("utf-8")) if stub.is_file() else own.tree
    for node in (item for item in nodes_of(tree) if isinstance(item, ast.ImportFrom)):
        if own.origin(node) != package and name in {alias.name for alias in node.names}:
            return home(own.origin(node), name)
    return package


def asserts(tree):
    """True if a test asserts values or errors, itself or through a helper of that name."""
    called = (node.func for node in nodes_of(tree) if isinstance(node, ast.Call))
    names = {ast.unparse(item).rpartition(".")[2] for item in called}
    by_others = any(name == "raises" or name.startswith("assert_") for name in names)
    return by_others or any(isinstance(node, ast.Assert) for node in nodes_of(tree))


def test_every_test_is_named_after_what_it_tests():
    astray = [
        str(path.relative_to(TESTS))
        for room in ROOMS
        for path in sorted((TESTS / room).rglob("test_*.py"))
        if not is_named_after_something(path)
    ]

    assert astray == []


def is_named_after_something(path):
    mirrored = ROOT / "wmr_ctrl" / path.parent.relative_to(TESTS)
    names = {mirrored.name, *(item.stem for item in mirrored.glob("*.py"))}
    own = path.stem.removeprefix("test_")
    return any(own == name or own.startswith(f"{name}_") for name in names)


def test_what_tests_import_of_each_other_is_there():
    missing = {
        f"{path.relative_to(ROOT)}: {node.module}"
        for path, tree in parsed().items()
        for node in nodes_of(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tests.")
        if not is_there(node.module or "")
    }

    assert missing == set()


def is_there(module):
    path = ROOT.joinpath(*module.split("."))
    return path.is_dir() or path.with_suffix(".py").is_file()

"""Short functions, short files, documented and annotated names."""

import ast
import statistics

from tests.architecture.tree import (
    Function,
    functions,
    length,
    modules,
    nodes_of,
    offenders,
    public,
)

LONGEST_FUNCTION = 60
FOLLOWS_FROM_A_VALUE = {
    "wmr_ctrl.core.fields.orientation": {
        "field_inward",
        "field_outward",
    },  # a field's, checked later
    "wmr_ctrl.core.fields.section": {"quantity"},  # stands for a field of the type of its default
    "wmr_ctrl.core.fields.values": {
        "clean",
        "default",
    },  # what a field's kind says, known at run time
    "wmr_ctrl.core.data": {"data", "with_tuples"},  # what a file of ours holds
    "wmr_ctrl.export.cosim.slave": {"variable"},  # a value of FMPy, which has no types
}
NUMBERS_OF_ANY_KIND = {"wmr_proofs", "codegen"}
"""Rooms whose public signatures say ``Any``: they calculate with numbers of any kind."""


def test_no_function_is_too_long():
    def long(module):
        sizes = {f.name: length(f) for f in functions(module.tree)}
        return [f"{name}: {size}" for name, size in sizes.items() if size > LONGEST_FUNCTION]

    assert offenders(long) == {}


def test_most_functions_take_a_few_lines():
    lengths = [length(function) for module in modules() for function in functions(module.tree)]

    assert statistics.median(lengths) <= 8
    assert statistics.quantiles(lengths, n=10)[-1] <= 35


def test_what_users_call_is_typed_to_the_end():
    """No ``Any`` in public signatures and fields, except where a type follows from a value."""

    def loose(module):
        names = set() if module.room in NUMBERS_OF_ANY_KIND else {*untyped(module.tree)}
        return names - FOLLOWS_FROM_A_VALUE.get(module.name, set())

    assert offenders(loose) == {}


def untyped(tree):
    """Public functions, methods and fields whose annotations mention ``Any``."""
    owners = [tree, *(n for n in public(tree) if isinstance(n, ast.ClassDef))]
    fields = [node for owner in owners for node in owner.body if isinstance(node, ast.AnnAssign)]
    said = {ast.unparse(node.target): [node.annotation] for node in fields}
    for node in public(tree):
        if isinstance(node, Function):
            said[node.name] = [node.returns, node.args]
    return [
        name
        for name, notes in said.items()
        if not name.startswith("_") and any(mentions_any(note) for note in notes)
    ]


def mentions_any(annotation):
    names = ast.walk(annotation) if annotation is not None else ()
    return any(isinstance(node, ast.Name) and node.id == "Any" for node in names)


def test_no_path_of_modules_is_changed():
    def changed(module):
        nodes = [node for node in nodes_of(module.tree) if isinstance(node, ast.Attribute)]
        return [text for node in nodes if (text := ast.unparse(node)) == "sys.path"]

    assert offenders(changed) == {}

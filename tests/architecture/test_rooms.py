"""The rooms of the two packages: number, purpose, size and names."""

import ast
import io
import re
import tokenize

import pytest

from tests.architecture.tree import PACKAGES, ROOT, modules, nodes_of, offenders

MOST_ROOMS = 12
BESIDE_ROOMS = {"__init__", "__main__", "api", "extend", "version"}
TOKENS = {"wmr_ctrl": 425_000, "wmr_proofs": 200_000}
"""Most tokens of code of each package."""
COUNTED = {tokenize.NAME, tokenize.OP, tokenize.NUMBER, tokenize.STRING}
SNIFFED = {
    "wmr_ctrl.core.fields.files": "only some errors of the system have a text",
    "wmr_ctrl.core.fields.values": "arrays of any library give their numbers by tolist",
    "wmr_proofs.alterations": "walks values of any class to the part that a claim alters",
    "wmr_ctrl.results.files": "only some errors of the system have a number",
    "wmr_ctrl.results.formats": "only some errors of the system have a text",
    "wmr_ctrl.simulation.batch": "os.sched_getaffinity is on Linux only",
}
"""Places where code may test whether an object has an attribute, and why."""


def folders(package):
    """Folders of Python files below a package."""
    return sorted({path.parent for path in (ROOT / package).rglob("*.py")} - {ROOT / package})


def test_there_are_at_most_twelve_rooms():
    rooms = {module.room for module in modules() if module.room not in PACKAGES}
    files = {path.stem for path in (ROOT / "wmr_ctrl").glob("*.py")}

    assert files == BESIDE_ROOMS
    assert len(rooms - files) <= MOST_ROOMS


@pytest.mark.parametrize("package", PACKAGES)
def test_rooms_have_folders_one_deep(package):
    most = 2 if package == "wmr_ctrl" else 1
    deep = [path for path in folders(package) if len(path.relative_to(ROOT / package).parts) > most]

    assert deep == []


def test_page_lists_each_room_with_the_sentence_of_its_docstring():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    first = page[page.index("\n| ") :].split("\n\n")[0]
    shown = dict(re.findall(r"^\| `(\w+)/` \| (.+?) \|", first, flags=re.M))
    rooms = [path for path in folders("wmr_ctrl") if path.parent.name == "wmr_ctrl"]
    sentences = {path.name: sentence(path) for path in [*rooms, ROOT / "wmr_proofs"]}

    assert shown == sentences
    assert len(page.split()) <= 2500


def sentence(folder):
    """First paragraph of a folder's docstring."""
    tree = ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))
    return " ".join((ast.get_docstring(tree) or "").split("\n\n")[0].split())


def test_purpose_of_every_folder_is_one_sentence():
    every = [path for package in PACKAGES for path in folders(package)]
    bad = {str(path): text for path in every if not is_sentence(text := sentence(path))}

    assert bad == {}


def is_sentence(text):
    return text.endswith(".") and ". " not in text


def test_no_file_has_the_name_of_another_room():
    names = {path.name for package in PACKAGES for path in folders(package)}
    twice = [
        module.name
        for module in modules()
        if module.path.stem in names - {module.path.parent.name}
        and module.path.parent != ROOT / "wmr_ctrl"
    ]

    assert twice == []


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_keep_their_budget(package, record_property):
    texts = (path.read_text(encoding="utf-8") for path in (ROOT / package).rglob("*.py"))
    count = sum(map(tokens_of_code, texts))
    record_property("tokens", count)
    print(f"{package}: {count} tokens of code, at most {TOKENS[package]}")

    assert count <= TOKENS[package]


def tokens_of_code(text):
    """Names, operators, numbers and strings; docstrings are free, a formatted string is one."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    owners = (node for node in ast.walk(ast.parse(text)) if isinstance(node, documented))
    free = {(node.body[0].lineno, node.body[0].col_offset) for node in owners if has_text(node)}
    begins = {getattr(tokenize, name, -1) for name in ("FSTRING_START", "TSTRING_START")}
    ends = {getattr(tokenize, name, -1) for name in ("FSTRING_END", "TSTRING_END")}
    count = depth = 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in begins:
            count += depth == 0
            depth += 1
        elif token.type in ends:
            depth -= 1
        elif depth == 0 and token.type in COUNTED and token.start not in free:
            count += 1
    return count


def has_text(node):
    return ast.get_docstring(node, clean=False) is not None


def test_tokens_are_counted_without_what_explains():
    text = '"""Text."""\n\n\ndef f(a):\n    """Text."""\n    return f"{a} b"  # why\n'

    assert tokens_of_code(text) == len(["def", "f", "(", "a", ")", ":", "return", "text"])


def test_nothing_is_asked_for_names_that_it_may_not_have():
    assert set(offenders(sniffed)) <= set(SNIFFED)


def sniffed(module):
    """Calls of hasattr, and of getattr with a text."""
    calls = [node for node in nodes_of(module.tree) if isinstance(node, ast.Call)]
    return [
        ast.unparse(call)
        for call in calls
        if isinstance(call.func, ast.Name)
        and call.func.id in ("getattr", "hasattr")
        and (call.func.id == "hasattr" or isinstance(call.args[1], ast.Constant))
    ]

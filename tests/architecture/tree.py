"""Parsed files of the project, for the architecture tests."""

from __future__ import annotations

import ast
import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("wmr_ctrl", "wmr_proofs")
FOLDERS = (".ci", "analysis", "benchmarks", "docs", "fmu", "paper", "tests", *PACKAGES)
AT_ROOT = (
    "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md", "pyproject.toml",
)  # fmt: skip

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Module:
    """One Python file of the two packages: dotted name, path, text and syntax tree."""

    name: str
    path: Path
    text: str
    tree: ast.Module

    @property
    def room(self):
        """The folder or file right below wmr_ctrl that it belongs to, or wmr_proofs."""
        return room_of(self.name)

    def imports(self, *, typing=False):
        """Every imported module, wherever the statement is; imported names that are modules count.

        With ``typing`` also imports only for annotations, under ``if TYPE_CHECKING:``.
        """
        unused = set() if typing else for_typing(self.tree)
        for node in nodes_of(self.tree):
            if node in unused:
                continue
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                yield from self._from(node)

    def _from(self, node):
        base = self.origin(node)
        for alias in node.names:
            full = f"{base}.{alias.name}"
            yield full if full in names_of_modules() else base

    def origin(self, node):
        """The module that such a statement imports from."""
        if not node.level:
            return node.module or ""
        package = self.name if self.path.name == "__init__.py" else self.name.rpartition(".")[0]
        parents = package.split(".")[: len(package.split(".")) - node.level + 1]
        return ".".join([*parents, *([node.module] if node.module else [])])


@cache
def modules():
    """Every Python file of both packages."""
    return tuple(_parsed(path) for path in paths())


@cache
def names_of_modules():
    """Dotted names of all modules of both packages."""
    return frozenset(map(_name, paths()))


def paths():
    """Python files of both packages, sorted."""
    return sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def offenders(check):
    """For each faulty module the faults that ``check`` reports."""
    faults = {module.name: list(check(module)) for module in modules()}
    return {name: wrong for name, wrong in faults.items() if wrong}


@cache
def nodes_of(tree):
    """All nodes of a syntax tree, cached, since many tests walk the same ones."""
    return tuple(ast.walk(tree))


@cache
def for_typing(tree):
    """Nodes under ``if TYPE_CHECKING:``, which never run."""
    guards = (node for node in nodes_of(tree) if isinstance(node, ast.If))
    asked = (node for node in guards if ast.unparse(node.test).endswith("TYPE_CHECKING"))
    return {inner for node in asked for line in node.body for inner in ast.walk(line)}


def room_of(name):
    """First part of a dotted name after wmr_ctrl, ``__init__`` for the package itself."""
    package, *parts = name.split(".")
    return package if package != "wmr_ctrl" else [*parts, "__init__"][0]


def functions(tree):
    """Every function and method, nested ones too."""
    return (node for node in nodes_of(tree) if isinstance(node, Function))


def public(tree):
    """Public functions and classes of a module, and the public methods of such classes."""
    for node in tree.body:
        if isinstance(node, Function | ast.ClassDef) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from (
                    inner
                    for inner in node.body
                    if isinstance(inner, Function) and not inner.name.startswith("_")
                )


def length(function):
    """Lines of a function without its decorators and docstring."""
    body = function.body
    documented = ast.get_docstring(function, clean=False) is not None
    start = body[0]
    said = (start.end_lineno or start.lineno) - start.lineno + 1 if documented else 0
    return (function.end_lineno or function.lineno) - function.lineno + 1 - said


def text_files():
    """Files that belong to the project and are text."""
    for path in project_files():
        try:
            path.read_text(encoding="utf-8")
        except (UnicodeDecodeError, OSError):
            continue
        yield path


def project_files(root=ROOT):
    """Files that git tracks and new ones in the project's folders; without git, all files in these.

    Files that users' commands write there (reports, FMUs, scenarios) are excluded.
    """
    if shutil.which("git") and (root / ".git").exists():
        listed = (("--cached",), ("--others", "--exclude-standard", "--", *FOLDERS))
        return sorted({root / name for options in listed for name in _git(root, options)})
    inside = (path for folder in FOLDERS for path in (root / folder).rglob("*"))
    return [path for path in (*inside, *(root / name for name in AT_ROOT)) if path.is_file()]


def _git(root, options):
    command = ["git", "ls-files", "-z", *options]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    return [name for name in done.stdout.split("\0") if name]


def _parsed(path):
    text = path.read_text(encoding="utf-8")
    return Module(_name(path), path, text, ast.parse(text, filename=str(path)))


def _name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

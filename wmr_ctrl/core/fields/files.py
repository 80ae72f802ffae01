"""Reader of small text files, such as TOML, and a record of files that a command reads and writes.

Failures of reading are ScenarioErrors.  A message quotes the file's text, so a file is read only if
its suffix shows that it is meant.
"""

import os
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TypeAlias

from wmr_ctrl.core.errors import ResultFileError, ScenarioError, printable

AnyPath: TypeAlias = str | os.PathLike[str]
LARGEST_FILE = 1_000_000
"""Bytes; a scenario is far smaller."""
TOML = (".toml",)
_COMMAND = ContextVar[tuple[dict[Path, str], set[Path]] | None]("files of a command", default=None)


@contextmanager
def one_command() -> Iterator[None]:
    """Context of one command, in which no file may be both read and written.

    A nested context does nothing.
    """
    if _COMMAND.get() is not None:
        yield
        return
    token = _COMMAND.set(({}, set()))
    try:
        yield
    finally:
        _COMMAND.reset(token)


def note_input(file: AnyPath, what: str) -> None:
    """Record that the command reads ``file``; ``what`` describes it in the message.

    Raises ResultFileError if the command writes it.  Nothing is recorded outside of a command.
    """
    if (command := _COMMAND.get()) is not None:
        inputs, outputs = command
        inputs.setdefault(Path(file), what)
        for output in outputs:
            _refuse_same(output, Path(file), what)


def note_output(file: AnyPath) -> None:
    """Record that the command writes ``file``.  Raises ResultFileError if it reads it."""
    if (command := _COMMAND.get()) is not None:
        inputs, outputs = command
        outputs.add(Path(file))
        for source, what in inputs.items():
            _refuse_same(Path(file), source, what)


def _refuse_same(output: Path, source: Path, what: str) -> None:
    try:
        same = os.path.samefile(os.path.realpath(output), source)  # as it will be written
    except (OSError, ValueError):  # one of them does not exist
        return
    if same:
        raise ResultFileError(
            f"cannot write {str(output)!r}: the same command reads this file ({what}: {source}). "
            "Write to another file."
        )


def read_text(
    file: Path, what: str, suffixes: Sequence[str] = TOML, largest: int = LARGEST_FILE
) -> str:
    """Return the text of a UTF-8 file of at most ``largest`` bytes; errors start with ``what``."""
    note_input(file, what)
    try:
        if file.is_dir():
            raise ScenarioError(f"{what}: {file} is a directory. Name a file in it.")
        if file.exists() and not file.is_file():
            raise ScenarioError(f"{what}: {file} is not a regular file.")
        if file.exists() and file.suffix.lower() not in suffixes:
            raise ScenarioError(
                f"{what}: {str(file)[:200]!r} must end in {' or '.join(suffixes)}: the suffix says "
                "what the file is."
            )
        with file.open("rb") as stream:
            data = stream.read(largest + 1)
    except FileNotFoundError:
        raise ScenarioError(f"{what}: there is no file {file}. Check the path.") from None
    except (OSError, ValueError) as problem:
        if isinstance(problem, ScenarioError):
            raise
        reason = getattr(problem, "strerror", None) or str(problem)
        raise ScenarioError(f"{what}: {str(file)[:200]!r} cannot be read: {reason}.") from None
    return decode(data, f"{what}: {file}", largest)


def decode(data: bytes, what: str, largest: int = LARGEST_FILE) -> str:
    """Return UTF-8 bytes, with or without byte order mark, as text; errors start with ``what``."""
    if len(data) > largest:
        raise ScenarioError(f"{what} is larger than {largest // 10**6} MB. Is it the right file?")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise ScenarioError(
            f"{what} is not UTF-8 text (byte {problem.start + 1}). Save it as UTF-8."
        ) from None
    if "\0" in text:
        raise ScenarioError(f"{what} is not text: it has a byte 0. Is it the right file?")
    return text


def parse_toml(text: str, what: str | Path, remedy: str = "") -> dict[str, object]:
    """Return TOML text as a dictionary.

    Raises ScenarioError: ``what``, why, line and column, ``remedy``.
    """
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ScenarioError(f"{what} is not usable TOML: it is nested too deeply.") from None
    except ValueError as problem:
        why = printable(str(problem)[:200])
        raise ScenarioError(f"{what} is not valid TOML: {why}. {remedy}".rstrip()) from None

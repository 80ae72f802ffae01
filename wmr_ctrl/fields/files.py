"""Reading of small text files, with every way in which that fails turned into a ScenarioError."""

from __future__ import annotations

from pathlib import Path

from wmr_ctrl.errors import ScenarioError

LARGEST_FILE = 1_000_000
"""Bytes; a scenario is far smaller."""


def read_text(file: Path, what: str, largest: int = LARGEST_FILE) -> str:
    """Return the text of a UTF-8 file of at most ``largest`` bytes; errors start with ``what``."""
    try:
        if file.is_dir():
            raise ScenarioError(f"{what}: {file} is a directory. Name a file in it.")
        if file.exists() and not file.is_file():
            raise ScenarioError(f"{what}: {file} is not a regular file.")
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
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise ScenarioError(
            f"{what} is not UTF-8 text (byte {problem.start + 1}). Save it as UTF-8."
        ) from None

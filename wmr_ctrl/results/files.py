"""Atomic writing of files: a reader finds the whole file or none."""

import csv
import os
import secrets
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.core.fields.files import AnyPath, note_output


@contextmanager
def atomic_path(path: AnyPath) -> Iterator[Path]:
    """A scratch path beside ``path``, of the same suffix, that replaces it on success.

    For writers that need a path; see :func:`atomic_write` for those that need a file.  After any
    error the scratch file is removed and ``path`` keeps its former content. Raises ResultFileError
    if the file cannot be written; other exceptions pass unchanged.
    """
    target = check_writable(path)
    scratch = target.with_name(f".{secrets.token_hex(8)}{target.suffix}")
    try:
        yield scratch
        os.replace(scratch, target)
    except OSError as error:
        raise _refusal(path, error) from error
    finally:
        with suppress(OSError):
            scratch.unlink()


@contextmanager
def atomic_write(path: AnyPath) -> Iterator[IO[bytes]]:
    """An open binary file that becomes ``path`` on success.

    Raises ResultFileError if the file cannot be written; other exceptions pass unchanged.
    """
    with atomic_path(path) as scratch, scratch.open("wb") as file:
        yield file


@contextmanager
def atomic_text(path: AnyPath) -> Iterator[IO[str]]:
    """An open UTF-8 text file that becomes ``path`` on success."""
    with atomic_path(path) as scratch, scratch.open("w", encoding="utf-8", newline="\n") as file:
        yield file


def write_csv(path: AnyPath, header: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a header and rows atomically; None is an empty cell, a number its shortest text."""
    with atomic_text(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def make_folder(folder: Path) -> None:
    """Make a folder and its parents if they do not exist.  Raises ResultFileError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refusal(folder, error) from error


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """Context that makes a folder; if the work inside fails, the new folders are removed again."""
    missing = [item for item in (folder, *folder.parents) if not os.path.exists(item)]
    make_folder(folder)
    try:
        yield
    except BaseException:
        for item in missing:
            with suppress(OSError):  # not empty: somebody else's file
                item.rmdir()
        raise


def write_all(files: Mapping[str, str], folder: Path) -> list[Path]:
    """Write texts by name into a folder (made if need be), all or none; returns their paths.

    Raises ResultFileError.
    """
    with ExitStack() as together:
        for inner in sorted({(folder / name).parent for name in files} | {folder}):
            together.enter_context(new_folder(inner))
        for name, text in files.items():
            file = together.enter_context(atomic_text(folder / name))
            file.write(text)
            file.flush()  # a full disk shows here, before the first file gets its name
    return [folder / name for name in files]


def check_writable(path: AnyPath) -> Path:
    """The file that writing to ``path`` would replace, links resolved; nothing is changed.

    Raises ResultFileError if it clearly cannot be written, or if the same command reads it.
    """
    note_output(path)
    try:
        target = Path(os.path.realpath(path))
        reason = _objection(target)
    except (OSError, ValueError) as error:
        raise _refusal(path, error) from error
    if reason:
        raise ResultFileError(f"cannot write {os.fspath(path)!r}: {reason}")
    return target


def _objection(target: Path) -> str:
    folder = target.parent
    if target.is_dir():
        return "it is a folder. Give the name of a file."
    if target.exists() and not target.is_file():
        return "it is a device or a pipe, not a regular file. Give the name of a file."
    if target.exists() and not os.access(target, os.W_OK):
        return "it is write-protected. Choose another name, or allow writing to it."
    if not folder.is_dir():
        return f"its folder {str(folder)!r} does not exist. Create the folder first."
    if not os.access(folder, os.W_OK):
        return f"its folder {str(folder)!r} may not be written to. Choose another folder."
    return ""


def _refusal(path: AnyPath, error: OSError | ValueError) -> ResultFileError:
    number = getattr(error, "errno", None)
    reason = os.strerror(number) if number else str(error)
    return ResultFileError(
        f"cannot write {os.fspath(path)[:200]!r}: {reason}. Choose another path; nothing was left."
    )

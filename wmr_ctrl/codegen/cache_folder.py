"""Where the build cache lives: a folder that can be written, or the reason why not, logged."""

from __future__ import annotations

import functools
import logging
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

import platformdirs

from wmr_ctrl.errors import CacheError

log = logging.getLogger(__name__)

VARIABLE = "WMR_CTRL_CACHE"
"""Environment variable that names the cache folder."""

STORAGE_REMEDY = (
    f"Free some space there, or name another folder in the environment variable {VARIABLE}."
)


def cache_dir() -> Path:
    """Return the cache folder, which exists and can be written.

    It is `wanted_dir`; where that cannot be written, a private folder among the temporary files,
    with a warning in the log.
    """
    return _usable(str(wanted_dir()))


def cache_part(name: str) -> Path:
    """A folder in `cache_dir`, made if that can be; raises CacheError where everybody may write."""
    folder = cache_dir() / name
    with suppress(OSError):  # whoever writes into it says so
        if not folder.is_dir():
            folder.mkdir(exist_ok=True)
            keep_others_out(folder)
    refuse_shared(folder)
    return folder


def wanted_dir() -> Path:
    """``$WMR_CTRL_CACHE``, or the user's cache folder of this platform: it may be read-only."""
    wanted = os.environ.get(VARIABLE) or platformdirs.user_cache_dir("wmr_ctrl", appauthor=False)
    return Path(wanted).expanduser().absolute()


@functools.lru_cache(maxsize=8)
def _usable(wanted: str) -> Path:
    folder = Path(wanted).expanduser().absolute()
    problem = _why_not_writable(folder)
    if not problem:
        refuse_shared(folder)
        return folder
    substitute = _private_temporary_folder()
    log.warning(
        "the build cache %s cannot be written (%s); using %s. Name another folder in the "
        "environment variable %s to keep compiled code.",
        folder,
        problem,
        substitute,
        VARIABLE,
    )
    return substitute


def _why_not_writable(folder: Path) -> str:
    """Try it, since permission bits say little on network drives, in containers and for root."""
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True)
            keep_others_out(folder)
        os.rmdir(tempfile.mkdtemp(prefix="trial-", dir=folder))
    except OSError as error:
        return error.strerror or str(error)
    return ""


def keep_others_out(path: Path) -> None:
    """Take away everybody's right to write what was made here, whatever the umask gave."""
    path.chmod(path.stat().st_mode & ~stat.S_IWOTH)


def is_shared(path: Path) -> bool:
    """Whether everybody may write what is there."""
    return os.name == "posix" and path.exists() and bool(path.stat().st_mode & stat.S_IWOTH)


def refuse_shared(folder: Path) -> None:
    """Raise CacheError where everybody may write: code is loaded from here."""
    if is_shared(folder):
        raise CacheError(
            f"the build cache {folder} may be written by everybody, and code is loaded from it. "
            f"Take that right away (chmod o-w), or name another folder in {VARIABLE}."
        )


def _private_temporary_folder() -> Path:
    """One folder per user; a fresh one if that name was taken by somebody else.

    Code is loaded from here, so a folder that another user could have prepared is not used.
    """
    user = getattr(os, "getuid", lambda: "user")()
    folder = Path(tempfile.gettempdir()) / f"wmr_ctrl-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        if _is_private(folder) and not _why_not_writable(folder):
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="wmr_ctrl-"))


def _is_private(folder: Path) -> bool:
    if not hasattr(os, "getuid"):  # Windows: the temporary folder is the user's own
        return True
    status = os.lstat(folder)
    mine = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    return mine and not status.st_mode & 0o077

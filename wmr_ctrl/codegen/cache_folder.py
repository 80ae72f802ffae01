"""Folder of the build cache, and its write access: code is loaded from it."""

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


def wanted_dir() -> Path:
    """``$WMR_CTRL_CACHE``, or the user's cache folder of this platform: it may be read-only."""
    wanted = os.environ.get(VARIABLE) or platformdirs.user_cache_dir("wmr_ctrl", appauthor=False)
    return Path(wanted).expanduser().absolute()


def cache_dir() -> Path:
    """The cache folder, which exists and can be written: `wanted_dir`, or a substitute.

    Where that cannot be written, a private folder among the temporary files, with a warning in the
    log.  Raises CacheError where everybody may write.
    """
    return _usable(wanted_dir())


def cache_part(name: str) -> Path:
    """A folder in `cache_dir`, made if that can be; raises CacheError where everybody may write."""
    folder = cache_dir() / name
    with suppress(OSError):  # whoever writes into it says so
        if not folder.is_dir():
            folder.mkdir(exist_ok=True)
            keep_others_out(folder)
    refuse_shared(folder)
    return folder


def keep_others_out(path: Path) -> None:
    """Take away everybody's right to write what was made here, whatever the umask gave."""
    path.chmod(path.stat().st_mode & ~stat.S_IWOTH)


def is_shared(path: Path) -> bool:
    """True if everybody may write there."""
    return os.name == "posix" and path.exists() and bool(path.stat().st_mode & stat.S_IWOTH)


def refuse_shared(folder: Path) -> None:
    """Raise CacheError where everybody may write the folder, or put another one in its place."""
    remedy = f"Take that right away (chmod o-w), or name another folder in {VARIABLE}."
    if is_shared(folder):
        raise CacheError(
            f"the build cache {folder} is writable for everybody, and code is loaded from it. "
            f"{remedy}"
        )
    for above in folder.resolve().parents:
        if is_shared(above) and not above.stat().st_mode & stat.S_ISVTX:
            raise CacheError(
                f"the build cache {folder} lies in {above}, which is writable for everybody: "
                "others could replace the folder, and code is loaded from it. "
                f"{remedy}"
            )


@functools.lru_cache(maxsize=8)
def _usable(folder: Path) -> Path:
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
            folder.mkdir(parents=True, exist_ok=True)  # another process may just have made it
            keep_others_out(folder)
        os.rmdir(tempfile.mkdtemp(prefix="trial-", dir=folder))
    except OSError as error:
        return error.strerror or str(error)
    return ""


def _private_temporary_folder() -> Path:
    """One folder per user; a fresh one if another user has, or could have, prepared that."""
    user = os.getuid() if os.name == "posix" else "user"  # Windows: the user's own folder
    folder = Path(tempfile.gettempdir()) / f"wmr_ctrl-{user}"
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
        mine = stat.S_ISDIR(status.st_mode) and status.st_uid == user
        private = os.name != "posix" or (mine and not status.st_mode & 0o077)
        if private and not _why_not_writable(folder):
            return folder
    return Path(tempfile.mkdtemp(prefix="wmr_ctrl-"))

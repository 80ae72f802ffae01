"""Build cache on disk: one folder per library, named by a hash of the library's inputs.

Only its user may be able to write to the cache's folder, since code is loaded from it.  An entry is
built in a separate folder beside the others and then renamed, so a reader sees a whole entry or
none: a compiler that fails or is killed leaves nothing behind.  If several processes or threads
need one entry, the first builds it and the others wait.  On a drive without locks they all build,
and the slower ones discard their copies.

Layout: ``<cache>/kernels/<key>/{sources, library, stamp.json}``, ``<cache>/locks/<key>``,
``<cache>/text/<key>.c``, and ``<cache>/zig/`` for the files that zig keeps for itself.
"""

import errno
import functools
import hashlib
import json
import logging
import os
import platform
import shutil
import stat
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import platformdirs
from filelock import FileLock, Timeout

from wmr_ctrl.core.errors import CacheError

log = logging.getLogger(__name__)

VARIABLE = "WMR_CTRL_CACHE"
"""Environment variable that names the cache folder."""

STORAGE_REMEDY = (
    f"Free some space there, or name another folder in the environment variable {VARIABLE}."
)


def wanted_dir() -> Path:
    """``$WMR_CTRL_CACHE``, or the user's cache folder of this platform; it may be read-only."""
    wanted = os.environ.get(VARIABLE) or platformdirs.user_cache_dir("wmr_ctrl", appauthor=False)
    return Path(wanted).expanduser().absolute()


def cache_dir() -> Path:
    """The cache folder, which exists and is writable: `wanted_dir`, or a substitute.

    If that cannot be written, a temporary folder of this process, with a warning.  Raises
    CacheError if everybody may write to it.
    """
    return _usable(wanted_dir())


def cache_part(name: str) -> Path:
    """A folder in `cache_dir`, made if possible; CacheError if everybody may write to it."""
    folder = cache_dir() / name
    with suppress(OSError):  # whoever writes into it says so
        if not folder.is_dir():
            folder.mkdir(exist_ok=True)
            keep_others_out(folder)
    refuse_shared(folder)
    return folder


def keep_others_out(path: Path) -> None:
    """Remove everybody's write permission from a new path, whatever the umask is."""
    path.chmod(path.stat().st_mode & ~stat.S_IWOTH)


def is_shared(path: Path) -> bool:
    """True if everybody may write there."""
    try:
        return os.name == "posix" and bool(path.stat().st_mode & stat.S_IWOTH)
    except OSError:  # there is none, or none that this user could load anything from
        return False


def refuse_shared(folder: Path) -> None:
    """Raise CacheError if others may write to the folder or replace it."""
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
    substitute = Path(tempfile.mkdtemp(prefix="wmr_ctrl-"))
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
    """Reason why a folder is not writable, by trying, since permission bits are unreliable."""
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)  # another process may just have made it
            keep_others_out(folder)
        os.rmdir(tempfile.mkdtemp(prefix="trial-", dir=folder))
    except OSError as error:
        return error.strerror or str(error)
    return ""


Sources = Mapping[str, str | bytes]
"""Relative file name (it may have folders) to the file's text."""

_LAYOUT = "1"  # raise it when what an entry consists of changes
_STAMP = "stamp.json"
_UNFINISHED = "building-"
_DAY = 86400.0
_checked: set[tuple[str, int]] = set()
SPARE = 2**20
"""Bytes that have to be free after a build: with fewer its library may be cut off."""


def build_cached(
    sources: Sources, compile_in: Callable[[Path], Path], *, key: Sequence[str] = ()
) -> Path:
    """The library built from ``sources``, compiled only if the cache lacks it.

    ``sources``, all that the build reads, are written into the entry's folder; ``compile_in`` is
    called with that folder (absolute), compiles, and returns the library's path inside it.  ``key``
    has the other inputs: compiler, version, flags.  Its size and SHA-256 are checked once in this
    process; a damaged entry is built anew.

    Raises CompilerError if compiling fails; its kind CacheError if the folder cannot be written (a
    full disk, say).
    """
    name = content_key(sources, key)
    kernels = wanted_dir() / "kernels"
    refuse_shared(kernels.parent)
    refuse_shared(kernels)
    present = _intact(kernels / name)  # a folder that can only be read will do
    if present:
        return present
    entry = cache_part("kernels") / name
    _sweep(entry.parent)
    with _locked(entry):
        return _intact(entry) or _build(entry, sources, compile_in)


def cached_text(key: str, write: Callable[[], str]) -> str:
    """The cached C text of a key; a new one if it is missing or incomplete.

    A folder that cannot be written is not an error here.
    """
    path = cache_part("text") / f"{key}.c"
    with suppress(OSError):
        text = path.read_text(encoding="utf-8")
        if text.endswith("}\n"):
            return text
    text = write()
    with suppress(OSError):
        handle, name = tempfile.mkstemp(dir=path.parent, prefix="writing-")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(name, path)
    return text


def content_key(sources: Sources, key: Sequence[str] = ()) -> str:
    """Unambiguous SHA-256 (hex) over file names and texts, ``key`` and the platform."""
    machine = (sys.platform, platform.machine(), str(8 * struct.calcsize("P")))
    parts: list[str | bytes] = [_LAYOUT, *machine, str(len(key)), *key]
    for name in sorted(sources):
        parts += [name, sources[name]]
    digest = hashlib.sha256()
    for part in map(_as_bytes, parts):
        digest.update(struct.pack("<Q", len(part)))
        digest.update(part)
    return digest.hexdigest()


def _as_bytes(text: str | bytes) -> bytes:
    return text if isinstance(text, bytes) else text.encode()


def _intact(entry: Path) -> Path | None:
    """Return the entry's library if it equals the file that was stamped, else None."""
    try:
        stamp = json.loads((entry / _STAMP).read_bytes())
        library = entry / stamp["library"]
        status = library.stat()
        known = (str(library), status.st_mtime_ns)
        if status.st_size != stamp["size"] or is_shared(entry) or is_shared(library):
            return None
        if known not in _checked and _sha256(library) != stamp["sha256"]:
            return None
    except (OSError, ValueError, LookupError, TypeError):
        return None
    _checked.add(known)
    return library


@contextmanager
def _locked(entry: Path, timeout: float = -1.0) -> Iterator[bool]:
    """Context that locks an entry until it or the process ends; yields False if locks do not work.

    ``timeout`` is in seconds; negative: wait without limit; raises `filelock.Timeout`.
    """
    folder = entry.parent.parent / "locks"
    with ExitStack() as held:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            held.enter_context(FileLock(folder / entry.name, timeout=timeout))
        except Timeout:
            raise
        except (OSError, NotImplementedError):
            yield False  # no locks here, or no room for one: building says so if it must
        else:
            yield True


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _build(entry: Path, sources: Sources, compile_in: Callable[[Path], Path]) -> Path:
    folder: Path | None = None
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f"{_UNFINISHED}{entry.name}-", dir=entry.parent))
        folder.chmod(0o755)  # mkdtemp's 0700 would shut others out of a shared WMR_CTRL_CACHE
        for name, text in sources.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(_as_bytes(text))
        library = compile_in(folder)
        if shutil.disk_usage(folder).free < SPARE:  # a compiler may write half and say nothing
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        keep_others_out(library)
        inside, size = library.relative_to(folder), library.stat().st_size
        stamp = {"library": inside.as_posix(), "size": size, "sha256": _sha256(library)}
        (folder / _STAMP).write_text(json.dumps(stamp, indent=1) + "\n", encoding="utf-8")
        _publish(folder, entry)
        return entry / inside
    except OSError as error:
        raise CacheError(
            f"a compiled library could not be stored in {entry.parent}: {error}. {STORAGE_REMEDY}"
        ) from error
    finally:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)


def _publish(folder: Path, entry: Path) -> None:
    """Rename the finished folder to its final name, unless an intact entry is there already."""
    try:
        os.rename(folder, entry)
    except OSError:
        if not entry.exists():
            raise
        if _intact(entry) is None:
            damaged = folder.with_name(f"{folder.name}-damaged")
            os.rename(entry, damaged)
            os.rename(folder, entry)
            shutil.rmtree(damaged, ignore_errors=True)


def _sweep(parent: Path) -> None:
    """Remove unfinished entries of dead processes, whose locks are free.

    On a drive without locks, entries older than a day are removed.
    """
    for folder in parent.glob(f"{_UNFINISHED}*"):
        entry = parent / folder.name.removeprefix(_UNFINISHED).partition("-")[0]
        try:
            with _locked(entry, timeout=0.0) as alone:
                if alone or time.time() - folder.stat().st_mtime > _DAY:
                    shutil.rmtree(folder, ignore_errors=True)
        except (OSError, Timeout):
            continue  # it is being built, or another process removed it meanwhile

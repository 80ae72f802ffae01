"""Finder of a working C compiler, and builder of libraries through the cache.

Order: ``$WMR_CTRL_CC`` (it may hold arguments, as in ``zig cc``) and nothing else if it is set;
else cc, gcc, clang on PATH; else the ``ziglang`` wheel.  A candidate is accepted after it has
compiled a few lines into a library that this process can load and call.  The cache stores that, so
later trials take milliseconds.  ``$WMR_CTRL_OPTIMIZE`` (0 to 3, else 3) chooses between faster code
and faster compiling; the results have the same bits.
"""

import ctypes
import functools
import importlib.util
import logging
import os
import shlex
import shutil
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

from wmr_ctrl.core.errors import CacheError, CompilerError, install

from .cache import Sources, build_cached, cache_dir
from .compiler import (
    LEVEL,
    TIMEOUT,
    VARIABLE,
    Toolchain,
    compile_library,
    compile_object,
    default_flags,
    environment,
    is_zig,
    library_suffix,
    run_command,
)

_INSTALL = (
    f"Install one with `{install('compiler')}` (or, on Debian and Ubuntu, `apt install gcc "
    f"libc6-dev`), or name one in the environment variable {VARIABLE}; `--engine numpy` runs "
    "without a compiler."
)
_ON_PATH = ("cc", "gcc", "clang")
BUILDS = logging.getLogger(__name__)
"""Log of libraries that the cache lacks and that are compiled."""
_PROBE = (files("wmr_ctrl.codegen") / "probe.c").read_text(encoding="utf-8")


def find_toolchain(extra: Sequence[str] = (), *, native: bool = False) -> Toolchain:
    """Return the first C compiler that works on this machine, with ``extra`` flags.

    ``native``: with every instruction of this processor, as `Toolchain.for_this_processor`.  Raises
    CompilerError if none works; the message names what was tried and what to install.
    """
    named = os.environ.get(VARIABLE, "").strip()
    toolchain = _find(named, os.environ.get("PATH"), cache_dir())
    if native:
        toolchain = toolchain.for_this_processor()
    return toolchain.with_flags(*level_flags(), *extra)


def build_library(
    sources: Sources,
    toolchain: Toolchain | None = None,
    *,
    name: str = "kernels",
    flags: Sequence[str] = (),
    timeout: float = TIMEOUT,
) -> Path:
    """Compile the ``.c`` files among ``sources`` into one shared library, unless cached.

    Headers are found by their names relative to the mapping's root; ``toolchain`` is by default
    that of `find_toolchain`, ``name`` the library's without suffix, ``timeout`` in seconds.  Raises
    CompilerError if there is no compiler, it fails, or the cache cannot be written.
    """
    chosen = (toolchain or find_toolchain()).with_flags(*flags)

    def compile_in(folder: Path) -> Path:
        BUILDS.info("compiling %s with %s", name, chosen.name)
        out = folder / f"{name}{library_suffix()}"
        paths = [folder / unit for unit in sources if unit.endswith(".c")]
        return compile_library(chosen, paths, out, include=[folder], timeout=timeout)

    return build_cached(sources, compile_in, key=(*chosen.key, name))


@dataclass(frozen=True)
class Unit:
    """A C file compiled with further ``flags`` under the object's ``name``.

    If the compiler does not know the flags of an ``optional`` unit, the library is built without
    it.
    """

    name: str
    source: str
    flags: tuple[str, ...] = ()
    optional: bool = False


def build_units(
    sources: Sources, units: Sequence[Unit], last: Unit, toolchain: Toolchain, *, name: str
) -> Path:
    """Compile ``units``, then ``last``, into one library, unless it is in the cache.

    ``last`` gets a flag -DWMR_HAS_<name> for each unit that could be compiled.  Raises
    CompilerError, as `build_cached` and required units do.
    """

    def compile_in(folder: Path) -> Path:
        made = dict(zip(units, _objects(toolchain, units, folder), strict=True))
        objects = [path for path in made.values() if path]
        known = tuple(f"-DWMR_HAS_{unit.name}" for unit, path in made.items() if path)
        joint = Unit(last.name, last.source, (*last.flags, *known))
        objects += filter(None, [_object(toolchain, joint, folder)])
        library = compile_library(toolchain, objects, folder / f"{name}{library_suffix()}")
        for path in objects:
            path.unlink()
        return library

    told = [part for unit in (*units, last)
            for part in (unit.name, unit.source, str(len(unit.flags)), *unit.flags)]  # fmt: skip
    return build_cached(sources, compile_in, key=(*toolchain.key, name, *told))


def _objects(toolchain: Toolchain, units: Sequence[Unit], folder: Path) -> list[Path | None]:
    """Compile all units in parallel; an interrupt or an error kills the running compilers."""
    stop = threading.Event()
    with ThreadPoolExecutor(len(units)) as pool:
        try:
            return list(pool.map(lambda unit: _object(toolchain, unit, folder, stop), units))
        except BaseException:
            stop.set()
            raise


def _object(
    toolchain: Toolchain, unit: Unit, folder: Path, stop: threading.Event | None = None
) -> Path | None:
    source, out = folder / unit.source, folder / f"{unit.name}.o"
    try:
        return compile_object(toolchain, source, out, include=[folder], flags=unit.flags, stop=stop)
    except CacheError:
        raise
    except CompilerError:
        stopped = stop is not None and stop.is_set()
        if unit.optional and not stopped and not _knows(toolchain, unit.flags, folder, stop):
            return None
        raise  # the compiler was killed, say: a library without this unit must not be kept


def _knows(
    toolchain: Toolchain, flags: tuple[str, ...], folder: Path, stop: threading.Event | None
) -> bool:
    """True if the compiler accepts ``flags`` at all."""
    with TemporaryDirectory(dir=folder) as trial:
        probe = Path(trial) / "probe.c"
        probe.write_text("int wmr_probe(void) { return 0; }\n", encoding="utf-8")
        try:
            compile_object(toolchain, probe, probe.with_suffix(".o"), flags=flags, stop=stop)
        except CacheError:
            raise
        except CompilerError:
            return False
        return True


def level_flags() -> tuple[str, ...]:
    """Optimisation flag from the environment; results have the same bits at every level."""
    level = os.environ.get(LEVEL, "").strip()
    if level not in ("", "0", "1", "2", "3"):
        raise CompilerError(
            f"the environment variable {LEVEL} is {level!r}; it takes 0, 1, 2 or 3, the compiler's "
            "level of optimisation. Without it libraries are compiled for speed, at level 3."
        )
    return (f"-O{level}",) if level else ()


@functools.lru_cache(maxsize=8)
def _find(named: str, path: str | None, cache: Path) -> Toolchain:
    """Search for a compiler; the arguments are all inputs of the search."""
    if named:
        return _named(named)
    found = [(name,) for name in (shutil.which(name, path=path) for name in _ON_PATH) if name]
    commands: list[tuple[str, ...]] = [*found]
    if zig_command():
        commands.append((*zig_command(), "cc"))
    reasons = []
    for command in commands:
        try:
            return _working(command)
        except CacheError:
            raise
        except CompilerError as error:
            reasons.append(str(error).partition(" The command was")[0])
    tried = f" What they said: {' '.join(reasons)}" if reasons else ""
    raise CompilerError(
        f"no working C compiler was found: looked for {', '.join(_ON_PATH)} on PATH and for the "
        f"Python package ziglang. {_INSTALL}{tried}"
    )


def _named(text: str) -> Toolchain:
    command = shlex.split(text, posix=os.name != "nt")
    if command[0] == "zig" and shutil.which("zig") is None and zig_command():
        command = [*zig_command(), *command[1:]]
    try:
        return _working(tuple(command))
    except CacheError:
        raise
    except CompilerError as error:
        raise CompilerError(
            f"the C compiler named in the environment variable {VARIABLE} ({text!r}) does not "
            f"work: {error} {_INSTALL}"
        ) from error


def zig_command() -> tuple[str, ...]:
    """Return the command of the ziglang wheel, () without it; -P ignores the working folder."""
    if importlib.util.find_spec("ziglang") is None:
        return ()
    return (sys.executable, "-P", "-m", "ziglang")


def _working(command: tuple[str, ...]) -> Toolchain:
    """Return the toolchain of ``command`` once its probe has been compiled, loaded and called."""
    name = "zig cc" if is_zig(command) else Path(command[0]).name
    version = _first_line((*command, "--version"))
    if is_zig(command):  # whose cc does not say zig's number
        version = f"zig {_first_line((*command[:-1], 'version'))}, {version}"
    toolchain = Toolchain(command, name, version, default_flags(command))
    library = build_library({"probe.c": _PROBE}, toolchain, name="probe", timeout=120.0)
    try:
        answer = ctypes.CDLL(str(library)).wmr_probe(41)
    except (OSError, AttributeError) as error:
        raise CompilerError(f"What {name} compiled cannot be loaded: {error}.") from error
    if answer != 42:
        raise CompilerError(f"What {name} compiled computes 41 + 1 as {answer}.")
    return toolchain


def _first_line(command: tuple[str, ...]) -> str:
    try:
        finished = run_command(command, timeout=20.0, environment=environment(cache_dir()))
    except OSError as error:
        raise CompilerError(f"`{shlex.join(command)}` cannot be started: {error}.") from error
    if finished.timed_out:
        raise CompilerError(f"`{shlex.join(command)}` gave no answer within 20 s.")
    lines = finished.output.strip().splitlines()
    return lines[0].strip() if lines and not finished.code else "of unknown version"

"""One library from units that are compiled with flags of their own, side by side."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from wmr_ctrl.codegen.cache import Sources, build_cached
from wmr_ctrl.codegen.compiler import Toolchain, compile_library, compile_object, library_suffix
from wmr_ctrl.errors import CacheError, CompilerError


@dataclass(frozen=True)
class Unit:
    """A C file compiled with further ``flags`` under the object's ``name``.

    Where the compiler does not know the flags of an ``optional`` one, the library goes without it.
    """

    name: str
    source: str
    flags: tuple[str, ...] = ()
    optional: bool = False


def build_units(
    sources: Sources, units: Sequence[Unit], last: Unit, toolchain: Toolchain, *, name: str
) -> Path:
    """Compile ``units``, then ``last``, into one library, unless it is in the cache.

    ``last`` gets a flag -DWMR_HAS_<name> for each unit that the compiler could do.  Raises
    CompilerError for what `build_cached` and a unit that is not optional raise.
    """

    def compile_in(folder: Path) -> Path:
        made = dict(zip(units, _objects(toolchain, units, folder), strict=True))
        objects = [path for path in made.values() if path]
        known = tuple(f"-DWMR_HAS_{unit.name}" for unit, path in made.items() if path)
        joint = Unit(last.name, last.source, (*last.flags, *known))
        objects += [path for path in [_object(toolchain, joint, folder)] if path]
        library = compile_library(toolchain, objects, folder / f"{name}{library_suffix()}")
        for path in objects:
            path.unlink()
        return library

    return build_cached(sources, compile_in, key=(*toolchain.key, name, *_key((*units, last))))


def _objects(toolchain: Toolchain, units: Sequence[Unit], folder: Path) -> list[Path | None]:
    """All units side by side; an interrupt or an error kills the compilers that still run."""
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
    """Whether the compiler accepts ``flags`` at all."""
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


def _key(units: Sequence[Unit]) -> Iterator[str]:
    for unit in units:
        yield from (unit.name, unit.source, str(len(unit.flags)), *unit.flags)

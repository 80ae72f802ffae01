"""Caller of a C compiler: flags, temporary files, and messages if it fails.

The flags keep every floating-point value as written: no fast-math, no contraction to fused
multiply-add, no reassociation.  ``errno`` and exception flags are not maintained, since nobody
reads them.  A command runs to its end, or is killed with everything that it started.
"""

import contextlib
import functools
import os
import platform
import re
import shlex
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

from wmr_ctrl.core.errors import CacheError, CompilerError, install

from .cache import STORAGE_REMEDY, cache_part

_PATIENCE = 0.2
"""Longest time until a thread notices that it shall stop [s]."""


@dataclass(frozen=True, slots=True)
class Finished:
    """Result of a command: exit code (negative: the signal), output, timeout."""

    code: int
    output: str
    timed_out: bool = False

    @property
    def how(self) -> str:
        """Text on how the command ended, empty if it succeeded."""
        if self.timed_out:
            return "did not finish in time"
        if self.code < 0:
            with contextlib.suppress(ValueError):
                return f"was killed by {signal.Signals(-self.code).name}"
            return f"was killed by signal {-self.code}"
        return f"ended with exit code {self.code}" if self.code else ""


def run_command(
    command: Sequence[str],
    *,
    timeout: float,
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
    stop: threading.Event | None = None,
) -> Finished:
    """Run ``command`` in ``folder`` without input and return how it ended.

    ``environment`` is added to the process's own; messages come in English.  After ``timeout``
    seconds, when this process is interrupted, or when ``stop`` is set (in threads, which interrupts
    do not reach), the command's whole process group is killed: compiler drivers start children
    which would outlive them.

    Raises OSError if the command cannot be started.
    """
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, "LC_ALL": "C", **(environment or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        output = _output(process, timeout, stop or threading.Event())
    except subprocess.TimeoutExpired:
        return Finished(-int(signal.SIGTERM), _kill(process), timed_out=True)
    except BaseException:
        _kill(process)
        raise
    return Finished(process.returncode, output)


def _output(process: subprocess.Popen[str], timeout: float, stop: threading.Event) -> str:
    """All output; raises TimeoutExpired after ``timeout``, or as soon as ``stop`` is set."""
    end = time.monotonic() + timeout
    while True:
        try:
            return process.communicate(timeout=min(_PATIENCE, max(end - time.monotonic(), 0.0)))[0]
        except subprocess.TimeoutExpired:
            if stop.is_set() or time.monotonic() >= end:
                raise


def _kill(process: subprocess.Popen[str]) -> str:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        if os.name == "posix":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    try:
        return process.communicate(timeout=10.0)[0] or ""
    except subprocess.TimeoutExpired:
        return ""


VARIABLE = "WMR_CTRL_CC"
"""Environment variable that names the C compiler."""
LEVEL = "WMR_CTRL_OPTIMIZE"
"""Environment variable that says how much the compiler optimises, 0 to 3; without it 3."""
TIMEOUT = 600.0
"""Seconds that one call of the compiler may take."""

_REMEDY = (
    f"Another compiler can be named in the environment variable {VARIABLE} (`zig cc` after "
    f"`{install('compiler')}`); `--engine numpy` runs without one."
)
_FULL = re.compile("no space left|nospaceleft|disk quota exceeded", re.IGNORECASE)
_VALUE_SAFE = ("-fno-fast-math", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
UNFUSED = "-fno-tree-slp-vectorize"
"""Keeps GCC from fusing: from 12 on it makes one vfmaddsub of two stores side by side, a product
with a sum and a product with a difference, whatever -ffp-contract says.  Of loops it can make the
same only where they take every other number, and generated loops take one after the other."""
WITHOUT_RUNTIME = ("-nostdlib", "-lc", "-lm")
"""Linker flags for loops; without them zig compiles its own functions first, six seconds for each
target. For Windows it does so with MinGW's C library: a minute, once per cache."""
_TELLING_OF_A_PROCESSOR = ("model name", "flags", "Features", "CPU part")


@dataclass(frozen=True, slots=True)
class Toolchain:
    """A C compiler: its command, its version, and the flags for every library."""

    command: tuple[str, ...]
    name: str
    version: str
    flags: tuple[str, ...]

    @property
    def misaligns_vectors(self) -> bool:
        """True for GCC for Windows, whose stack alignment of 16 bytes is too small for vectors."""
        return os.name == "nt" and not (is_zig(self.command) or "clang" in self.name)

    @property
    def fuses_pairs(self) -> bool:
        """True for GCC, which fuses pairs of operations by default."""
        return not (is_zig(self.command) or "clang" in f"{self.name} {self.version}")

    @property
    def key(self) -> tuple[str, ...]:
        """Build-cache key: everything about the compiler that affects its output."""
        native = any(flag.endswith("=native") for flag in self.flags)
        processor = (_processor(),) if native else ()
        linking = WITHOUT_RUNTIME if is_zig(self.command) else ()
        return (*self.command, self.version, *self.flags, *processor, *linking)

    def with_flags(self, *flags: str) -> "Toolchain":
        """Return the same compiler with further flags; if flags contradict each other, the last one
        wins.
        """
        return replace(self, flags=(*self.flags, *flags))

    def for_this_processor(self) -> "Toolchain":
        """Return the same compiler using every instruction of this machine's processor.

        Values stay the same.  The library may not run elsewhere; the cache tells such builds
        of different processors apart.
        """
        kept = tuple(flag for flag in self.flags if flag != "-mcpu=baseline")
        mcpu = is_zig(self.command) or platform.machine().lower() in ("arm64", "aarch64")
        unfused = (UNFUSED,) if self.fuses_pairs else ()
        return replace(self, flags=(*kept, "-mcpu=native" if mcpu else "-march=native", *unfused))


def is_zig(command: Sequence[str]) -> bool:
    """Return whether a compiler's command calls ``zig cc`` in some way."""
    return command[-1] == "cc" and len(command) > 1 and "zig" in Path(command[-2]).stem


def default_flags(command: Sequence[str]) -> tuple[str, ...]:
    """Return the flags for a shared library that runs on every machine of this kind."""
    flags: tuple[str, ...] = ("-std=c99", "-O3", *_VALUE_SAFE, "-shared", "-fvisibility=hidden")
    if os.name != "nt":
        flags = (*flags, "-fPIC")
    if is_zig(command):  # its defaults are this very processor, and traps on overflow
        flags = (*flags, "-mcpu=baseline", "-fno-sanitize=undefined")
    return flags


def library_suffix() -> str:
    """Return the suffix of shared libraries on this platform: .so, .dylib or .dll."""
    return {"win32": ".dll", "cygwin": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def compile_library(
    toolchain: Toolchain,
    sources: Sequence[Path],
    out: Path,
    *,
    include: Sequence[Path] = (),
    flags: Sequence[str] = (),
    timeout: float = TIMEOUT,
) -> Path:
    """Compile C files into the shared library ``out`` and return its absolute path.

    Its folder must exist and also takes the compiler's temporary files; ``include`` are folders
    searched for headers, ``flags`` come after the toolchain's own, ``timeout`` is in seconds.

    Raises CompilerError if the compiler cannot be started, fails, is killed or runs out of time
    (CacheError: of space); ``out`` does not exist then.
    """
    given = (*toolchain.flags, *flags)
    tail: tuple[str, ...] = () if os.name == "nt" or "-nostdlib" in given else ("-lm",)
    if is_zig(toolchain.command) and out.suffix != ".dll" and "-nostdlib" not in given:
        tail = (*WITHOUT_RUNTIME, *("-Wl,-z,defs",) * (out.suffix == ".so"))
    return _compiled(toolchain, given, sources, out, include, timeout, tail)


def compile_object(
    toolchain: Toolchain,
    source: Path,
    out: Path,
    *,
    include: Sequence[Path] = (),
    flags: Sequence[str] = (),
    timeout: float = TIMEOUT,
    stop: threading.Event | None = None,
) -> Path:
    """Compile one C file into the object file ``out``, to be linked by `compile_library`.

    Parameters and errors are those of `compile_library`; the compiler is killed when ``stop`` is
    set.
    """
    kept = tuple(flag for flag in toolchain.flags if flag != "-shared")
    return _compiled(toolchain, (*kept, "-c", *flags), (source,), out, include, timeout, stop=stop)


def _compiled(
    toolchain: Toolchain,
    flags: Sequence[str],
    sources: Sequence[Path],
    out: Path,
    include: Sequence[Path],
    timeout: float,
    tail: Sequence[str] = (),
    stop: threading.Event | None = None,
) -> Path:
    out = out.absolute()
    folder = out.parent
    command = [*toolchain.command, *flags, *(f"-I{path.absolute()}" for path in include)]
    command += [str(source.absolute()) for source in sources]
    command += ["-o", str(out), *tail]
    own = environment(folder)
    try:
        finished = run_command(command, timeout=timeout, folder=folder, environment=own, stop=stop)
    except OSError as error:
        finished = Finished(127, str(error))
    if finished.how or not out.is_file():
        out.unlink(missing_ok=True)
        if _FULL.search(finished.output):
            raise CacheError(
                f"the C compiler {toolchain.name} found no space left in {folder}. {STORAGE_REMEDY}"
            )
        raise CompilerError(_failure(toolchain, finished, command, timeout))
    return out


def environment(folder: Path) -> Mapping[str, str]:
    """Return variables that keep a compiler's own files in ``folder`` and the cache.

    HOME and the temporary folder may be read-only.
    """
    caches = ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR")
    own = dict.fromkeys(("TMPDIR", "TMP", "TEMP"), str(folder))
    return own | dict.fromkeys(caches, str(cache_part("zig")))


def _failure(
    toolchain: Toolchain, finished: Finished, command: Sequence[str], timeout: float
) -> str:
    """Error message with up to three informative lines of the compiler's output."""
    how = finished.how or "reported success but wrote no library"
    if finished.timed_out:
        how = f"did not finish within {timeout:g} s"
    lines = [line.strip() for line in finished.output.splitlines() if line.strip()]
    telling = [line for line in lines if "error" in line.lower()] or lines
    said = _shortened(" | ".join(telling[:3]), 500).rstrip(".")
    what = f"{how}: {said}" if said else how
    return (
        f"the C compiler {toolchain.name} ({toolchain.version}) {what}. "
        f"The command was `{_shortened(shlex.join(command), 600)}`. {_REMEDY}"
    )


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 4]} ..."


@functools.cache
def _processor() -> str:
    """Hash of this processor, since other processors may not run code made for it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        told = sorted({line for line in lines if line.startswith(_TELLING_OF_A_PROCESSOR)})
    except OSError:
        told = [platform.processor(), platform.node()]
    return sha256("\n".join(told).encode()).hexdigest()

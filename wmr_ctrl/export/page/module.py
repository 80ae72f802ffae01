"""The module of the page: the loops of several structures, compiled to one WebAssembly file."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from wmr_ctrl.codegen.build import LOOP, Program, digest, program_of, unity
from wmr_ctrl.codegen.cache import build_cached
from wmr_ctrl.codegen.compiler import Toolchain, compile_library, compile_object, default_flags
from wmr_ctrl.codegen.toolchain import level_flags, zig_command
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.compiled import LoopLayout
from wmr_ctrl.core.errors import CompilerError, install
from wmr_ctrl.core.signals import PLANT_STATE

UNIT = ("page.c", *LOOP[1:], "seed.c", "seed.h")
FLAGS = (
    "-O2", "-Xclang", "-O1", "-g0", "-fno-inline", "-fno-stack-protector", "-U__SIZEOF_INT128__",
    "-target", "wasm32-wasi",
)  # fmt: skip
"""Compiler flags that avoid 128-bit numbers, whose product -O2 introduces and for which zig
compiles its own library; zig by itself makes -O2 of -O1."""
LINKING = (
    "-target", "wasm32-freestanding", "-nostdlib", "-s", "-Wl,--no-entry", "-Wl,--strip-all",
)  # fmt: skip
"""Linker flags without a C library, which zig would compile for half a minute; loops need its
headers only."""
_HOST_ONLY = ("-shared", "-fPIC", "-fvisibility=hidden", "-mcpu=baseline", "-O3")
WORKERS = 2
"""Compilers side by side: each takes some 300 MB."""


@dataclass(frozen=True)
class PageLoop:
    """A loop of the module: its name, C text, layout, and its state at t = 0.

    The plant's state, which is first in ``start``, comes from a scene.
    """

    name: str
    text: dict[str, str]
    layout: LoopLayout
    start: tuple[float, ...]


@dataclass(frozen=True)
class Room:
    """Maximum numbers of parameter rows and of plant steps of delay for a robot of the module."""

    phases: int
    delay_steps: int


class PageLoops:
    """The distinct loops of requested setups, numbered in order of request."""

    def __init__(self) -> None:
        self._loops: dict[str, PageLoop] = {}
        self._by_program: dict[Program, PageLoop] = {}

    def of(self, setup: Setup) -> PageLoop:
        """The loop of a setup; setups with equal C text share it."""
        program = program_of(setup)
        if program not in self._by_program:
            text, start = program.generated, tuple(program.loop.x0)
            key = f"{digest(text)} {start[len(PLANT_STATE) :]} {program.layout}"
            new = PageLoop(f"k{len(self._loops)}", text, program.layout, start)
            self._by_program[program] = self._loops.setdefault(key, new)
        return self._by_program[program]

    def __iter__(self) -> Iterator[PageLoop]:
        return iter(self._loops.values())

    def __len__(self) -> int:
        return len(self._loops)


def build_module(loops: Sequence[PageLoop], room: Room, progress: Callable[[float], None]) -> bytes:
    """Compile loops with this room into one module.

    ``progress`` is called with the share done.  Raises CompilerError without zig, or if it fails.
    """
    most = (f"-DWMR_PHASES_MOST={room.phases}", f"-DWMR_DELAY_MOST={room.delay_steps}")
    chain = toolchain().with_flags(*most)
    with ThreadPoolExecutor(WORKERS) as pool:
        jobs = [pool.submit(_object, chain, loop) for loop in loops]
        try:
            for count, job in enumerate(as_completed(jobs), 1):
                job.result()
                progress(count / (len(jobs) + 1))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    objects = [job.result() for job in jobs]
    return _linked(chain, objects).read_bytes()


def toolchain() -> Toolchain:
    """The compiler of modules; CompilerError without zig."""
    command = zig_command()
    if not command:
        raise CompilerError(
            "the page's loops are compiled to WebAssembly by zig, and the Python package ziglang "
            f"is not installed. Install it with `{install('compiler')}`."
        )
    command = (*command, "cc")
    flags = tuple(flag for flag in default_flags(command) if flag not in _HOST_ONLY)
    flags = (*flags, *FLAGS, *level_flags())
    try:
        own = version("ziglang")
    except PackageNotFoundError:
        own = "of unknown version"
    return Toolchain(command, "zig cc", f"zig {own}", flags)


def _object(chain: Toolchain, loop: PageLoop) -> Path:
    own = chain.with_flags(f"-DWMR_SET={loop.name}")

    def compile_in(folder: Path) -> Path:
        return compile_object(own, folder / UNIT[0], folder / f"{loop.name}.o", include=[folder])

    return build_cached(unity(loop.text, UNIT), compile_in, key=(*own.key, "page object"))


def _linked(chain: Toolchain, objects: Sequence[Path]) -> Path:
    files = {f"{path.stem}.o": path.read_bytes() for path in objects}

    def compile_in(folder: Path) -> Path:
        linking = chain.with_flags(*LINKING)
        paths = [folder / name for name in files]
        return compile_library(linking, paths, folder / "page.wasm")

    return build_cached(files, compile_in, key=(*chain.key, "page module"))

"""The bits of all elementary functions, equal for compilers, optimisation, processors, systems."""

import os
from pathlib import Path

import pytest

from tests.arithmetic.functions import EVERY, SOURCE, files, hashes, library
from tests.commands import finished
from tests.compilers import (
    ARM,
    BESIDE_QEMU,
    FLAGS,
    NODE,
    QEMU,
    WASM,
    WINE,
    ZIG,
    compile_program,
    needs_compiler,
    processor,
    where,
    wine,
)  # fmt: skip

SCRIPT = Path(__file__).with_name("hashes.mjs")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wdouble-promotion", "-Werror")
BOARD = (*ZIG, "-target", ARM, "-DWMR_LANES=2", "-O2")
WINDOWS = (*ZIG, "-target", "x86_64-windows-gnu", "-O2")
BUILDS = {
    "gcc": (("gcc", "-O1", *WARNINGS), ()),
    "clang": (("clang", "-O1", *WARNINGS), ()),
    "gcc native": (("gcc", "-O2", "-march=native"), ()),
    "clang 8 lanes": (("clang", "-O3", "-march=native", "-DWMR_LANES=8"), ()),
    "aarch64": (BOARD, QEMU),
    "windows": (WINDOWS, WINE),
    "webassembly": ((*WASM, "-Wl,--export=hash_of"), NODE),
}
"""Command of the compiler, without a warning where it gives any, and what runs its program."""


def shown(folder, command, runner=(), flags=FLAGS):
    """Hashes by the program that a command builds."""
    needs_compiler(command)
    run = [where(*runner)] if runner else []
    for name, text in files().items():
        (folder / name).write_text(str(text), encoding="utf-8")
    own = ["-DWMR_PRINT"] if runner != NODE else []
    out = {NODE: "each.wasm", WINE: "each.exe"}.get(runner, "each")
    compile_program(folder, [*command, *own, *flags, f"-I{folder}"], [SOURCE.name], out)
    environment = {**os.environ, **BESIDE_QEMU, **(wine() if runner == WINE else {})}
    command = [*run, *([SCRIPT] if runner == NODE else []), folder / out]
    printed = finished(command, env=environment).stdout
    return dict(zip(EVERY, printed.split(), strict=True))


@pytest.mark.parametrize("name", BUILDS)
@pytest.mark.slow_but("gcc")
def test_compilers_processors_and_systems_give_the_same_bits(name, tmp_path):
    assert shown(tmp_path, *BUILDS[name]) == hashes(library())


@pytest.mark.slow
def test_fused_operations_would_be_seen(tmp_path):
    """Hashes change with the last digit: contraction changes them on a processor with fused
    operations.
    """
    if "fma" not in processor():
        pytest.skip("NOT RUN: no x86 processor with fused operations")
    fused = shown(tmp_path, ("gcc", "-O2", "-march=native"), flags=("-ffp-contract=fast",))

    assert fused["exp"] != hashes(library())["exp"]

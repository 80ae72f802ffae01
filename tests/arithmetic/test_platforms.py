"""The bits of all elementary functions, equal for compilers, optimisation, processors, systems."""

import os
import subprocess
from pathlib import Path

import pytest

from tests.arithmetic.functions import EVERY, SOURCE, files, hashes, library
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
HERE = (("gcc", "-O2", "-march=native"), ("clang", "-O3", "-march=native", "-DWMR_LANES=8"))


def built(folder, command, out="each", flags=FLAGS):
    needs_compiler(command)
    for name, text in files().items():
        (folder / name).write_text(str(text), encoding="utf-8")
    compile_program(folder, [*command, *flags, f"-I{folder}"], [SOURCE.name], out)
    return folder / out


def assert_equal_bits(*command, **more):
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False,
        timeout=300, env={**os.environ, **{name: str(value) for name, value in more.items()}},
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert dict(zip(EVERY, done.stdout.split(), strict=True)) == hashes(library())


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.slow_but("clang")
def test_it_is_c99_without_a_warning(compiler, tmp_path):
    assert_equal_bits(built(tmp_path, (compiler, "-O1", "-DWMR_PRINT", *WARNINGS)))


@pytest.mark.slow
@pytest.mark.parametrize("command", HERE, ids=" ".join)
def test_compilers_and_flags_give_the_same_bits(command, tmp_path):
    assert_equal_bits(built(tmp_path, (*command, "-DWMR_PRINT")))


@pytest.mark.slow
def test_aarch64_gives_the_same_bits(tmp_path):
    emulator = where(*QEMU)
    target = ("-target", ARM, "-DWMR_LANES=2", "-DWMR_PRINT", "-O2")

    assert_equal_bits(emulator, built(tmp_path, (*ZIG, *target)), **BESIDE_QEMU)


@pytest.mark.slow
def test_windows_gives_the_same_bits(tmp_path):
    emulator = where(*WINE)
    program = built(tmp_path, (*ZIG, "-target", "x86_64-windows-gnu", "-DWMR_PRINT", "-O2"),
                    "each.exe")  # fmt: skip

    assert_equal_bits(emulator, program, **wine())


@pytest.mark.slow
def test_webassembly_gives_the_same_bits(tmp_path):
    node = where(*NODE)
    command = (*WASM, "-Wl,--export=hash_of")

    assert_equal_bits(node, SCRIPT, built(tmp_path, command, "each.wasm"))


@pytest.mark.slow
def test_fused_operations_would_be_seen(tmp_path):
    """The hashes tell a last digit: with contraction, where the processor can, they differ."""
    if "fma" not in processor():
        pytest.skip("NOT RUN: no x86 processor with fused operations")
    fused = ("-ffp-contract=fast",)
    program = built(tmp_path, ("gcc", "-O2", "-march=native", "-DWMR_PRINT"), flags=fused)

    with pytest.raises(AssertionError, match="exp"):
        assert_equal_bits(program)

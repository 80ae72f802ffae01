"""Libraries of loops for Windows, which zig links without MinGW's C library: wine loads them."""

import os

import pytest

from tests.commands import finished
from tests.compilers import WINE, ZIG, compile_program, needs_compiler, processor, where, wine
from wmr_ctrl.codegen.build import LOOP, X86, flags_of, program_of, unity, vector_sets
from wmr_ctrl.codegen.compiler import compile_library, compile_object
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.control.setup import settle
from wmr_ctrl.export.fmi.targets import targets_of, toolchain_for
from wmr_ctrl.world.scenario import load_scenario

pytestmark = pytest.mark.slow

TARGET = ("-target", "x86_64-windows-gnu")
WHO = """
#include <stdio.h>
#include <windows.h>

int main(int count, char **words)
{
    HMODULE library = count > 1 ? LoadLibraryA(words[1]) : 0;
    const char *(*name)(int) =
        library ? (const char *(*)(int))(void *)GetProcAddress(library, "wmr_set_name") : 0;
    for (int k = 0; name && name(k); ++k) {
        printf("%s\\n", name(k));
    }
    return !name;
}
"""


def test_the_loop_for_lanes_has_every_set_of_this_processor(tmp_path):
    emulator = where(*WINE)
    needs_compiler(ZIG)
    chain = toolchain_for(*targets_of("x86_64-windows"))
    program = program_of(settle(load_scenario("paper-simulation"), "nn"))
    for name, text in {**unity(program.generated_lanes, LOOP), "who.c": WHO}.items():
        (tmp_path / name).write_text(str(text), "utf-8")
    units, known = [runtime_dir() / "dispatch.c"], []
    for item in vector_sets():
        out, flags = tmp_path / f"{item.name}.o", tuple(flags_of(item, chain))
        given = {"include": [tmp_path], "flags": flags}
        units.append(compile_object(chain, tmp_path / LOOP[0], out, **given))
        known.append(f"-DWMR_HAS_{item.name}")

    out = tmp_path / "batch.dll"
    library = compile_library(chain, units, out, include=[tmp_path], flags=known)

    compile_program(tmp_path, [*ZIG, *TARGET, "-O1"], ["who.c"], "who.exe")
    who = [emulator, tmp_path / "who.exe", library]
    said = finished(who, timeout=300, env={**os.environ, **wine()}).stdout.split()
    has = {"avx512": "avx512vl", "avx2": "avx2"}
    assert said == [*(item.name for item in X86 if has[item.name] in processor()), "baseline"]
    assert not list(tmp_path.glob("*.c.o"))

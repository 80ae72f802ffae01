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


@pytest.fixture
def chain():
    needs_compiler(ZIG)
    return toolchain_for(*targets_of("x86_64-windows"))


def sets_in(library):
    """What the library says that it can run, under wine."""
    emulator, program = where(*WINE), library.with_name("who.exe")
    (library.parent / "who.c").write_text(WHO, "utf-8")
    compile_program(library.parent, [*ZIG, *TARGET, "-O1"], ["who.c"], str(program))
    done = finished(
        [emulator, str(program), str(library)], timeout=300, env={**os.environ, **wine()}
    )
    return done.stdout.split()


def write(folder, files):
    for name, text in files.items():
        (folder / name).write_text(str(text), "utf-8")


def test_the_loop_for_lanes_has_every_set_of_this_processor(chain, tmp_path):
    write(
        tmp_path,
        unity(program_of(settle(load_scenario("paper-simulation"), "nn")).generated_lanes, LOOP),
    )
    known = [f"-DWMR_HAS_{item.name}" for item in vector_sets()]
    objects = [
        compile_object(
            chain, tmp_path / LOOP[0], tmp_path / f"{item.name}.o", include=[tmp_path],
            flags=tuple(flags_of(item, chain)),
        )
        for item in vector_sets()
    ]  # fmt: skip
    units = [runtime_dir() / "dispatch.c", *objects]

    library = compile_library(chain, units, tmp_path / "batch.dll", include=[tmp_path], flags=known)

    has = {"avx512": "avx512vl", "avx2": "avx2"}
    mine = [item.name for item in X86 if has[item.name] in processor()]
    assert sets_in(library) == [*mine, "baseline"]

"""Libraries: their exports and needs, and whether they run on other platforms."""

import importlib.util
import os
import re
import struct
import subprocess
import sys
import zipfile

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from tests.commands import finished
from tests.compilers import ARM_LIBRARIES, QEMU, WINE, ZIG, compile_program, where, wine
from wmr_ctrl.codegen.resources import fmu_dir
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import CompilerError, UnknownNameError
from wmr_ctrl.export.fmi import targets
from wmr_ctrl.export.fmi.fmu_files import export_fmu, joined

WHAT = ("plant", "reference", "guard", "closed-loop", *LAWS)
HEADERS = fmu_dir() / "fmi" / "headers"
zig = pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="ziglang is not there")
linux = pytest.mark.skipif(sys.platform != "linux", reason="reads ELF files")


def wanted_functions(version):
    text = (HEADERS / f"fmi{version}Functions.h").read_text("utf-8")
    return {*re.findall(rf"^#define\s+(fmi{version}\w+)\s+fmi{version}FullName", text, re.M)}


@pytest.fixture
def library_by(monkeypatch, tmp_path):
    """A function (compiler, what, version) -> the FMU's library by that compiler, or by zig."""

    def built(compiler, what, version):
        monkeypatch.setenv("WMR_CTRL_FMU_CC", compiler and where(compiler))
        (path,) = export_fmu(what, fmi=version, out=tmp_path)
        with zipfile.ZipFile(path) as archive:
            (name,) = [name for name in archive.namelist() if name.startswith("binaries/")]
            return archive.extract(name, tmp_path)

    return built


@linux
@pytest.mark.parametrize("what, version", [("plant", 2), ("closed-loop", 3)])
def test_the_standards_functions_and_the_scenarios_hash_are_exported(library_by, what, version):
    listed = finished([where("nm"), "-D", "--defined-only", library_by("cc", what, version)])
    names = {line.split()[-1].partition("@")[0] for line in listed.stdout.splitlines()}
    names ^= {f"wmr_{what.replace('-', '_')}_scenario_hash"}
    assert names - {"_init", "_fini"} == wanted_functions(version)


@linux
@zig
def test_glibc_217_is_enough_and_nothing_else_is_needed(library_by):
    said = finished([where("objdump"), "-p", "-T", library_by("", "closed-loop", 2)]).stdout
    versions = {tuple(map(int, v.split("."))) for v in re.findall(r"GLIBC_([\d.]+)", said)}
    assert versions
    assert max(versions) <= (2, 17)
    assert set(re.findall(r"NEEDED\s+(\S+)", said)) <= {"libc.so.6", "libm.so.6"}


@zig
@pytest.mark.slow
def test_five_platforms_in_one_file(tmp_path, monkeypatch):
    monkeypatch.delenv("WMR_CTRL_FMU_CC", raising=False)
    (path,) = export_fmu("plant", target="all", fmi=3, out=tmp_path)
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        heads = {name.split("/")[1]: archive.read(name)[:2] for name in names}
    linux, mac = b"\x7fE", b"\xcf\xfa"
    assert heads == {
        "x86_64-linux": linux, "aarch64-linux": linux, "x86_64-windows": b"MZ",
        "x86_64-darwin": mac, "aarch64-darwin": mac,
    }  # fmt: skip


@zig
@pytest.mark.slow
@pytest.mark.parametrize("target, suffix", [("x86_64-windows", ".exe"), ("aarch64-linux", "")])
def test_libraries_of_other_platforms_compute_the_same_bits(tmp_path, target, suffix):
    """Under wine, and under qemu if that processor's dynamic linker and C library are available."""
    run = [where(*WINE)] if suffix else [where(*QEMU), "-L", str(ARM_LIBRARIES)]
    if not suffix and not ARM_LIBRARIES.is_dir():
        pytest.skip("NOT RUN: libc6-arm64-cross is not there")
    there = stepped(tmp_path / "there", target, suffix, run)
    assert there == stepped(tmp_path / "here", "x86_64-linux")


def stepped(folder, target, suffix="", run=()):
    """Output of a C program on a platform that makes 200 steps of a closed loop.

    Then its message about a number out of range, with all digits.
    """
    (path,) = export_fmu("closed-loop", fmi=2, target=target, out=folder)
    with zipfile.ZipFile(path) as archive:
        place = "binaries/win64/" if suffix else "binaries/linux64/"
        name = next(n for n in archive.namelist() if n.startswith(place))
        archive.extract(name, folder)
    program = folder / f"step{suffix}"
    triple = targets.targets_of(target)[0].triple
    # The platform as the FMU has it, unsanitised: zig builds no second runtime for the program.
    own = ("-target", triple, "-fno-sanitize=undefined", "-Wall", "-Werror", f"-I{HEADERS}")
    source = str(fmu_dir() / "examples" / "fmi2_step.c")
    compile_program(folder, [*ZIG, *own], [source], str(program))
    described = read_model_description(str(path), validate=False)
    refs = {v.name: v.valueReference for v in described.modelVariables}
    limited = next(v.name for v in described.modelVariables if float(v.max or 6.0) < 6.0)
    shown = []
    for held in ("disturbance.std", limited):
        numbers = refs[held], refs["omega"], 200
        done = subprocess.run(
            [*run, program, folder / name, described.guid, *map(str, numbers)],
            capture_output=True, text=True, timeout=300, check=False,
            env={**os.environ, **(wine() if suffix else {})},
        )  # fmt: skip
        values = [float.fromhex(line) for line in done.stdout.split()]
        shown.append((done.returncode, values, done.stderr.splitlines()))
    assert (shown[0][0], len(shown[0][1]), shown[1][0]) == (0, 200, 1)
    assert "= 6 is outside of" in str(shown[1])
    return shown


def test_nothing_is_written_where_a_platform_fails(tmp_path, monkeypatch):
    real = targets.compile_for

    def broken(target, *given):
        if target.name != targets.host():
            raise CompilerError("zig found no memory. The command was `zig cc`.")
        return real(target, *given)

    monkeypatch.setattr(targets, "compile_for", broken)
    with pytest.raises(CompilerError, match="no memory"):
        export_fmu("reference", target="all", fmi=2, out=tmp_path)
    with pytest.raises(UnknownNameError, match="x86_64-linux"):
        export_fmu("plant", target="x86_64-linus", out=tmp_path)
    assert not list(tmp_path.iterdir())


def test_universal_libraries_hold_each_slice_on_a_page():
    parts = [
        b"\xcf\xfa\xed\xfe" + struct.pack("<II", cpu, 3) + bytes(100)
        for cpu in (0x01000007, 0x0100000C)
    ]
    whole = joined(parts)
    assert struct.unpack_from(">II", whole) == (0xCAFEBABE, 2)
    for i, part in enumerate(parts):
        cpu, _sub, offset, size, align = struct.unpack_from(">IIIII", whole, 8 + 20 * i)
        assert whole[offset : offset + size] == part
        assert (offset % (1 << align), cpu) == (0, struct.unpack_from("<I", part, 4)[0])

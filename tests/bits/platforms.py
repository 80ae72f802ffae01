"""Build the cases of a law for a platform, and run them there."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.bits.cases import bits_of, case, different, numbers
from tests.compilers import (
    BESIDE_QEMU,
    FLAGS,
    WINE,
    compile_program,
    needs_compiler,
    processor,
    where,
    wine,
)
from wmr_ctrl.codegen.build import LOOP, unity

HERE = Path(__file__).parent
INSTRUCTIONS = {"-march=x86-64-v3": "avx2", "-march=x86-64-v4": "avx512dq"}


@dataclass(frozen=True)
class Platform:
    """A compiler's command with flags, robots in a vector (0: one by itself), what runs it.

    ``runner``: names of a program; with ``script`` that is its first argument.
    """

    name: str
    command: tuple[str, ...]
    lanes: int = 0
    runner: tuple[str, ...] = ()
    script: Path | None = None
    suffix: str = ""


def check_tools(platform):
    """Skip if a tool that the platform's programs need is missing."""
    needs_compiler(platform.command)
    for flag, name in INSTRUCTIONS.items():
        if flag in platform.command and name not in processor():
            pytest.skip(f"NOT RUN: this processor has no {name}")
    runner = [where(*platform.runner)] if platform.runner else []
    return [*runner, *([str(platform.script)] if platform.script else [])]


def differences(platform, law, names, folder):
    """Differences between a platform's bits and those of our library here, as texts."""
    runner = check_tools(platform)
    shown = ran([*runner, str(built(platform, law, names, folder))], folder)
    texts = []
    for name in names:
        size = len(bits_of(law, name))
        texts.append(different(law, name, shown[:size]))
        shown = shown[size:]
    return [text for text in texts if text] + [f"{law}: more bytes"] * bool(shown)


def built(platform, law, names, folder):
    """The program of a law's cases; every case has a folder of its own there."""
    units = [str(HERE / "main.c")]
    for name in names:
        one, own = case(law, name), folder / name
        text = one.program.generated_lanes if platform.lanes else one.program.generated_watched
        files = {**unity(text, LOOP), "numbers.h": numbers(one)}
        own.mkdir(parents=True)
        for file, content in {**files, "case.c": (HERE / "case.c").read_text("utf-8")}.items():
            (own / file).write_text(str(content), encoding="utf-8")
        units.append(str(own / "case.c"))
    cases = " ".join(f"X({name})" for name in names)
    (folder / "cases.h").write_text(f"#define CASES(X) {cases}\n", encoding="utf-8")
    out, own = folder / f"cases{platform.suffix}", (f"-DWMR_LANES={platform.lanes}", f"-I{folder}")
    compile_program(folder, [*platform.command, *FLAGS, *own, f"-I{HERE}"], units, str(out))
    return out


def ran(command, folder):
    """Output of a program, through a file, since not every platform can wait for a pipe."""
    out = folder / "bits"
    own = wine() if Path(command[0]).name in map(os.path.basename, WINE) else {}
    with out.open("wb") as file:
        done = subprocess.run(
            command, stdout=file, stderr=subprocess.PIPE, check=False, timeout=300,
            env={**os.environ, **BESIDE_QEMU, **own},
        )  # fmt: skip
    assert done.returncode == 0, f"{done.returncode}: {done.stderr.decode(errors='replace')}"
    return out.read_bytes()

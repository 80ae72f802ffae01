"""Build a package for an emulated Arm board, run it there, and talk to it sample by sample."""

from __future__ import annotations

import ctypes as ct
import shutil
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.codegen.packages import write_package
from tests.commands import finished

HERE = Path(__file__).parent
COMPILER, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
INSTRUCTIONS_PER_TICK = 40
"""The board's clock is 25 MHz; the emulator is told that one instruction takes 1 ns."""


@dataclass(frozen=True)
class Board:
    """An emulated board: the emulator's machine and the compiler's flags."""

    machine: str
    flags: tuple[str, ...]


BOARDS = {
    "cortex-m4f": Board("mps2-an386", ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16")),
    "cortex-m7": Board("mps2-an500", ("-mcpu=cortex-m7", "-mfpu=fpv5-d16")),
}


def missing():
    """Sentence that names missing tools; empty if both tools are there."""
    absent = [name for name in (COMPILER, EMULATOR) if shutil.which(name) is None]
    return f"NOT RUN: {' and '.join(absent)} not installed" if absent else ""


def built(law, scenario, board, folder, *, float32):
    """The firmware of a package for a board."""
    write_package(law, folder, scenario, float32=float32)
    names = ("parameters", "state", "inputs", "outputs", "step", "defaults", "start")
    (folder / "law.h").write_text(f'#include "wmr_{law}.h"\n', encoding="utf-8")
    out = folder / "board.elf"
    command = [
        COMPILER, "-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic",
        "-Werror", "-mthumb", "-mfloat-abi=hard", *board.flags,
        *(f"-DLAW_{name.upper()}=wmr_{law}_{name}" for name in names), f"-I{folder}",
        "-nostartfiles", "-ffreestanding", "-fno-tree-loop-distribute-patterns",
        "--specs=nosys.specs", f"-T{HERE / 'board.ld'}", HERE / "board.c",
        folder / f"wmr_{law}.c", "-lm", "-o", out,
    ]  # fmt: skip
    finished(command)
    return out


def packed(inputs, counts, real):
    """The struct of a sample's inputs: numbers, then counters of 32 bits that wrap."""
    return np.asarray(inputs, real).tobytes() + np.asarray(counts, np.int64).astype("i4").tobytes()


class Emulated:
    """A board that runs a law; use it as a context."""

    def __init__(self, firmware, board, *, float32):
        self.real = np.float32 if float32 else np.float64
        header = next(firmware.parent.glob("wmr_*.h")).read_text(encoding="utf-8")
        acted = "wmr_real guard_acted;" in header
        self.reply = struct.Struct(f"<i{2 + acted}{'f' if float32 else 'd'}I")
        self.process = subprocess.Popen(
            [EMULATOR, "-M", board.machine, "-kernel", str(firmware), "-icount", "shift=0",
             "-serial", "stdio", "-monitor", "none", "-display", "none"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            pipe.close()

    def step(self, inputs, counts=()):
        """Status, torques [N m], and instructions of one sample."""
        self._write(b"S" + packed(inputs, counts, self.real))
        status, right, left, *_, ticks = self.reply.unpack(self._read(self.reply.size))
        return status, np.array([right, left]), ticks * INSTRUCTIONS_PER_TICK

    def deepest_stack(self):
        """Bytes of stack that were ever in use; ends the program."""
        self._write(b"Q")
        return int(struct.unpack("<I", self._read(4))[0])

    def _write(self, data):
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def _read(self, count):
        data = self.process.stdout.read(count)
        if len(data) != count:
            raise RuntimeError("the emulated board ended early")
        return data


class HostBuild:
    """The package compiled for this machine, called through ctypes."""

    def __init__(self, law, scenario, folder, *, float32):
        write_package(law, folder, scenario, float32=float32)
        library, source = folder / "host.so", folder / f"wmr_{law}.c"
        flags = ["-std=c99", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
        finished(["cc", *flags, source, "-lm", "-o", library])
        self.library = loaded = ct.CDLL(str(library))
        self.real = np.float32 if float32 else np.float64
        self._step = loaded[f"wmr_{law}_step"]
        self.parameters, self.memory = np.zeros(2048, self.real), np.zeros(1024, self.real)
        self.outputs = np.zeros(4, self.real)  # what is sent, and what flags there are behind it
        self._start = loaded[f"wmr_{law}_start"]
        loaded[f"wmr_{law}_defaults"](_pointer(self.parameters))
        self.reset()

    def reset(self):
        """Memory of the first sample."""
        self._start(_pointer(self.memory))

    def step(self, inputs, counts=()):
        """Status and torques [N m], or velocities, of one sample."""
        given = np.frombuffer(packed(inputs, counts, self.real), np.uint8)
        arrays = (self.parameters, self.memory, given, self.outputs)
        status = self._step(*(_pointer(item) for item in arrays))
        return status, self.outputs[:2].astype(float)


def _pointer(array):
    return ct.c_void_p(array.ctypes.data)

"""A graphics processor for tests: the same text compiled as C++, one robot after the other."""

import ctypes as ct
import hashlib
import shutil
import subprocess
from pathlib import Path

from filelock import FileLock

PRELUDE = """\
#define __global__
#define __launch_bounds__(threads, blocks)
#define __longlong_as_double(bits) __builtin_bit_cast(double, bits)
#define memcpy __builtin_memcpy
#define memset __builtin_memset
#define sqrt __builtin_sqrt
#define fabs __builtin_fabs
#define copysign __builtin_copysign
using size_t = decltype(sizeof 0);
static thread_local struct { unsigned x; } blockIdx, threadIdx;
"""
DRIVER = """
extern "C" void wmr_every_robot(const wmr_batch *b)
{
    for (int64_t robot = 0; robot < b->robots; ++robot) {
        blockIdx.x = (unsigned)(robot / WMR_BLOCK);
        threadIdx.x = (unsigned)(robot % WMR_BLOCK);
        wmr_runs(b);
    }
}
"""
COMPILER = next((name for name in ("g++", "clang++") if shutil.which(name)), None)
FLAGS = ("-std=c++17", "-O0", "-ffp-contract=off", "-w", "-shared", "-fPIC")
COMMAND = (str(COMPILER), *FLAGS)


class Stand:
    """Stand-in for a graphics processor that holds ``most`` robots."""

    def __init__(self, folder, most=64, memory=2**30):
        self.folder, self.most, self.memory = folder, most, memory
        self.launches = []

    def threads(self):
        """Robots at a time."""
        return self.most

    def free_memory(self):
        """Bytes."""
        return self.memory

    def run(self, path, defines, batch, arrays, cancelled):
        """All robots of a launch."""
        self.launches.append(batch.robots)
        for name, array in arrays.items():
            setattr(batch, name, array.ctypes.data)
        batch.cancelled = ct.addressof(cancelled)
        self._compiled(path, defines).wmr_every_robot(ct.byref(batch))

    def _compiled(self, path, defines):
        text = PRELUDE + Path(path).read_text(encoding="utf-8") + DRIVER
        flags = [f"-D{name}={value}" for name, value in defines]
        name = hashlib.sha256(repr((text, flags)).encode()).hexdigest()[:24]
        made = self.folder / f"{name}.so"
        with FileLock(self.folder / f"{name}.lock"):
            if not made.exists():
                source, fresh = self.folder / f"{name}.cpp", self.folder / f"{name}.new"
                source.write_text(text, encoding="utf-8")
                subprocess.run([*COMMAND, *flags, str(source), "-o", str(fresh)], check=True)
                fresh.rename(made)
        return ct.CDLL(str(made))

"""Many runs on a graphics processor: one robot per thread, bit-identical to the loop for lanes.

A CompiledLoop's ``library`` is then the CUDA text of its loop, which CuPy (extra gpu) compiles for
the processor at hand when it is first run, and keeps in a cache of its own.
"""

import ctypes as ct
import threading
import time
from collections.abc import Callable, Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import CompilerError, DeviceError, library
from wmr_ctrl.core.signals import PLANT_STATE, elements

from .memory import LONG, Results, Task

SUFFIX = ".cu"
"""Suffix of CUDA sources."""
BLOCK = 128
"""Threads of a block."""
MOST_LOGGED = 2**30
"""Bytes of the logs of one launch."""
LAUNCHES = 2
"""Launches at a time: one is computed while the other's results are read."""
PATIENCE = 0.002
"""Seconds between two looks at a launch."""
OPTIONS = ("--fmad=false", "--device-as-default-execution-space", "-w")
"""Options of the compiler: no multiplication is fused with an addition."""
Defines = tuple[tuple[str, int], ...]
Arrays = dict[str, NDArray[Any]]


class Batch(ct.Structure):
    """``wmr_batch`` of gpu.c; its pointers are device addresses."""

    _fields_ = tuple(
        (name, LONG)
        for name in (
            "robots", "samples", "phase_start", "window", "cancelled", "parameters", "starts",
            "case_of", "seeds", "own_starts", "findings", "state", "sums", "logs",
        )
    )  # fmt: skip


LEFT = ("findings", "state", "sums", "logs")
"""Arrays that a launch fills."""


class Cuda:
    """The first CUDA device allowed by CUDA_VISIBLE_DEVICES."""

    def __init__(self) -> None:
        self.cupy = library("cupy", "gpu")
        try:
            facts = self.cupy.cuda.runtime.getDeviceProperties(self.cupy.cuda.Device().id)
        except self.cupy.cuda.runtime.CUDARuntimeError as error:
            raise DeviceError(
                f"device = 'gpu': no CUDA device answers ({error}). Leave the device out, or use a "
                "machine with an NVIDIA processor and its driver; `nvidia-smi` lists them."
            ) from None
        self.most = facts["multiProcessorCount"] * facts["maxThreadsPerMultiProcessor"]
        self.lock = threading.Lock()
        self.kernels: dict[tuple[str, Defines], Callable[..., object]] = {}

    def threads(self) -> int:
        """Number of threads that it runs simultaneously."""
        return int(self.most)

    def free_memory(self) -> int:
        """Free memory for arrays [bytes]."""
        return int(self.cupy.cuda.runtime.memGetInfo()[0]) + int(
            self.cupy.get_default_memory_pool().free_bytes()
        )

    def run(
        self, path: str, defines: Defines, batch: Batch, arrays: Arrays, cancelled: ct.c_int32
    ) -> None:
        """Run the text at ``path``; the arrays of `LEFT` among ``arrays`` are filled.

        The numbers of ``batch`` are set; its pointers are set here, to copies of the arrays.
        Raises CompilerError and DeviceError.
        """
        kernel, cuda = self._kernel(path, defines), self.cupy.cuda
        try:
            with cuda.Stream(non_blocking=True) as stream:
                device = {name: self.cupy.asarray(array) for name, array in arrays.items()}
                device["cancelled"] = self.cupy.zeros(1, dtype=np.int32)
                for name, array in device.items():
                    setattr(batch, name, array.data.ptr)
                numbers = self.cupy.asarray(np.frombuffer(bytes(batch), dtype=np.uint8))
                kernel((-(-batch.robots // BLOCK),), (BLOCK,), (numbers,))
                self._wait(stream, device["cancelled"], cancelled)
                for name in LEFT:
                    if name in arrays:
                        device[name].get(stream=stream, out=arrays[name])
                stream.synchronize()
        except (cuda.memory.OutOfMemoryError, cuda.runtime.CUDARuntimeError) as error:
            raise DeviceError(
                f"the graphics processor did not finish a launch of {batch.robots} robots "
                f"({error}). Close what else uses it; `nvidia-smi` shows its memory and faults."
            ) from error

    def _wait(self, stream: Any, flag: Any, cancelled: ct.c_int32) -> None:
        """Wait until the stream's work is done; a cancellation is passed on meanwhile."""
        ended = self.cupy.cuda.Event(disable_timing=True)
        ended.record(stream)
        while not ended.done:
            if cancelled.value:
                with self.cupy.cuda.Stream(non_blocking=True) as other:
                    flag.fill(1)
                    other.synchronize()
            time.sleep(PATIENCE)

    def _kernel(self, path: str, defines: Defines) -> Callable[..., object]:
        """The kernel of a text, compiled once; CuPy caches it for the next process."""
        with self.lock:
            if (path, defines) not in self.kernels:
                options = (*OPTIONS, *(f"-D{name}={value}" for name, value in defines))
                text = Path(path).read_text(encoding="utf-8")
                try:
                    module = self.cupy.RawModule(code=text, options=options)
                    self.kernels[path, defines] = module.get_function("wmr_runs")
                except Exception as error:  # CuPy has no one class for what NVRTC may say
                    raise CompilerError(
                        f"the compiler of graphics processors does not compile {path} "
                        f'({str(error)[:500]}). `python -c "import cupy; cupy.show_config()"` '
                        "names the CUDA toolkit that CuPy found; it needs that of its own version."
                    ) from error
            return self.kernels[path, defines]


@cache
def processor() -> Cuda:
    """The graphics processor; MissingExtraError without CuPy, DeviceError without a device.

    Tests replace it by an ordinary processor.
    """
    return Cuda()


def is_for_gpu(task: Task) -> bool:
    """True if the task's loop is a text for a graphics processor."""
    return task.loop.compiled.library.endswith(SUFFIX)


def robots_of(task: Task, windows: int, *, log: bool) -> int:
    """Robots per launch: as many as the processor runs, fewer if its memory is short."""
    device, layout = processor(), task.loop.compiled.layout
    if log:
        row = 8 * task.loop.scenario.clock.samples * len(elements(layout.columns))
        return max(1, min(MOST_LOGGED, device.free_memory() // (2 * LAUNCHES)) // row)
    numbers = len(layout.findings) + len(elements(layout.state)) + windows * len(layout.sums)
    each = 8 * (numbers + len(elements(layout.parameters)) * len(task.loop.compiled.phase_start))
    return max(1, min(device.threads(), device.free_memory() // (2 * LAUNCHES * each)))


def launched(
    runs: Sequence[Task], windows: Sequence[tuple[int, int]], log: bool, cancelled: ct.c_int32
) -> Results | None:
    """Run all together; None if that was cancelled.  Errors as `Cuda.run` raises."""
    compiled, samples = runs[0].loop.compiled, runs[0].loop.scenario.clock.samples
    layout, count = compiled.layout, len(runs)
    cases: dict[int, int] = {}
    case_of = np.array([cases.setdefault(id(run.loop), len(cases)) for run in runs], np.int32)
    several = {id(run.loop): run.loop.compiled for run in runs}.values()
    arrays: Arrays = {
        "phase_start": np.array(compiled.phase_start, dtype=np.int64),
        "window": np.array([*windows, (0, 0)], dtype=np.int64),
        "parameters": np.array([[*chain(*one.parameters)] for one in several], dtype=float),
        "starts": np.array([one.start for one in several], dtype=float),
        "case_of": case_of,
        "seeds": np.array([run.seed for run in runs], dtype=np.uint64),
        "findings": np.empty((len(layout.findings), count)),
        "state": np.empty((len(elements(layout.state)), count)),
        "sums": np.empty((len(windows), len(layout.sums), count)),
    }
    if any(run.start for run in runs):
        own = [run.start or run.loop.compiled.start[: len(PLANT_STATE)] for run in runs]
        arrays["own_starts"] = np.array(own, dtype=float).T.copy()
    if log:
        arrays["logs"] = np.empty((count, samples, len(elements(layout.columns))))
    defines = (
        ("WMR_BLOCK", BLOCK),
        ("WMR_OWN", len(PLANT_STATE)),
        ("WMR_PHASES", len(compiled.phase_start)),
        ("WMR_QUEUE", compiled.delay_steps),
        ("WMR_WINDOWS", len(windows)),
        *([("WMR_LOGS", 1)] if log else []),
        *([("WMR_OWN_PARAMETERS", 1)] if len(cases) > count // 32 else []),
    )
    processor().run(
        compiled.library, defines, Batch(robots=count, samples=samples), arrays, cancelled
    )
    if cancelled.value:
        return None
    logs = [*arrays.get("logs", ())]
    return Results(layout, arrays["findings"], arrays["state"], arrays["sums"], logs, count)

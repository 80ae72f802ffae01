"""One FMU in co-simulation, through FMPy: read, write and step with arrays made once."""

from __future__ import annotations

import ctypes as ct
import hashlib
import os
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave

from wmr_ctrl.errors import ArgumentError, UnknownNameError, WmrError
from wmr_ctrl.fields.limits import may_unpack
from wmr_ctrl.fmi.units import BASE, NamedUnit

_WARNING = 1  # the highest status of a call that did what it should
Read = Callable[[], list[float]]
Write = Callable[[Sequence[float]], None]


class FmuError(WmrError, RuntimeError):
    """An FMU refused a call or could not be loaded; the message names it and says when."""


class FmuFile:
    """What an FMU says of itself: variables, units, name.  Raises FmuError for a file that is none.

    ``name`` is how messages call it.
    """

    def __init__(self, path: str | Path, name: str) -> None:
        """Read the model description of ``path``."""
        self.name, self.path = name, os.fspath(path)
        try:
            _check_size(self.path)
            self.description = read_model_description(self.path)
        except Exception as error:  # FMPy raises bare Exceptions
            raise FmuError(f"the FMU {self.path} ({name}) cannot be used: {error}") from error
        self.variables = {v.name: v for v in self.description.modelVariables}

    @property
    def label(self) -> str:
        """Its model's name, its file, version of FMI and the beginning of the file's SHA-256."""
        digest = hashlib.sha256(Path(self.path).read_bytes()).hexdigest()[:16]
        said = self.description
        return f"{said.modelName} ({Path(self.path).name}, FMI {said.fmiVersion}, sha256 {digest})"

    def unit(self, name: str) -> NamedUnit | str | None:
        """Unit that the model description gives a variable: as it defines it, by name, or None."""
        variable = self.variable(name)
        declared = variable.declaredType
        own = variable.unit or (declared.unit if declared is not None else None)
        return self._defined.get(own, own) if own else None

    @cached_property
    def _defined(self) -> dict[str, NamedUnit]:
        """Units that the model description defines by base units."""
        bases = {item.name: item.baseUnit for item in self.description.unitDefinitions}
        return {
            str(name): NamedUnit(
                str(name),
                float(base.factor),
                {key: int(getattr(base, key)) for key in BASE if getattr(base, key)},
                float(base.offset),
            )
            for name, base in bases.items()
            if base is not None
        }

    def variable(self, name: str) -> Any:
        """A real variable's description; raises UnknownNameError or ArgumentError."""
        if name not in self.variables:
            raise UnknownNameError(f"variable of the FMU {self.path}", name, self.variables)
        variable = self.variables[name]
        if variable.type not in ("Real", "Float64"):
            raise ArgumentError(
                f"{name} of the FMU {self.path} is of type {variable.type}; only real ones can be "
                "used. Map another variable."
            )
        return variable


def _check_size(path: str) -> None:
    """Raise ArgumentError for an archive that says to be far larger than its file, unpacked."""
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(item.file_size for item in archive.infolist())
    if not may_unpack(os.path.getsize(path), unpacked):
        raise ArgumentError(
            f"it is {unpacked / 1e6:.0f} MB unpacked, which its own size cannot be true of. Check "
            "where it is from."
        )


class Slave(FmuFile):
    """An FMU for co-simulation, version 2.0 or 3.0, ready to be initialised.

    ``name`` is how messages call it.  Raises FmuError where it cannot be loaded.
    """

    def __init__(self, path: str | Path, name: str, folder: str | Path) -> None:
        """Unpack ``path`` below ``folder`` and create one instance."""
        super().__init__(path, name)
        self.time = 0.0
        self.messages: list[str] = []
        self._flags, last = [ct.c_bool() for _ in range(3)], ct.c_double()
        self._answers = [*map(ct.byref, self._flags), ct.byref(last)]
        self._keep = last
        try:
            self.version = 2 if self.description.fmiVersion == "2.0" else 3
            self._fmu = self._loaded(extract(self.path, str(folder)))
        except Exception as error:  # FMPy raises bare Exceptions
            raise FmuError(f"the FMU {self.path} ({name}) cannot be used: {error}") from error

    def _loaded(self, folder: str) -> Any:
        if self.description.coSimulation is None:
            raise ArgumentError("it has no co-simulation interface. Export it for co-simulation.")
        kind = FMU2Slave if self.version == 2 else FMU3Slave
        fmu = kind(
            guid=self.description.guid,
            unzipDirectory=folder,
            instanceName=self.name,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )
        self._instantiate(fmu)
        return fmu

    def _instantiate(self, fmu: Any) -> None:
        if self.version == 3:
            fmu.instantiate(logMessage=self._hear3)
            return
        from fmpy.fmi2 import defaultCallbacks

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(self._hear2)
        callbacks.allocateMemory = defaultCallbacks.allocateMemory
        callbacks.freeMemory = defaultCallbacks.freeMemory
        self._callbacks = callbacks
        fmu.instantiate(callbacks=callbacks)

    def _hear2(
        self, _env: Any, _name: bytes, _status: int, _category: bytes, message: bytes
    ) -> None:
        self.messages.append((message or b"").decode(errors="replace"))

    def _hear3(self, _env: Any, _status: int, _category: bytes, message: bytes) -> None:
        self.messages.append((message or b"").decode(errors="replace"))

    def begin(self, stop: float, values: Mapping[str, float]) -> None:
        """Set start values and initialise at t = 0 s."""
        with _Telling(self, "initialisation"):
            if self.version == 2:
                self._fmu.setupExperiment(startTime=0.0, stopTime=stop)
                self.set(values)
                self._fmu.enterInitializationMode()
            else:
                self.set(values)
                self._fmu.enterInitializationMode(startTime=0.0, stopTime=stop)
            self._fmu.exitInitializationMode()

    def set(self, values: Mapping[str, float]) -> None:
        """Set variables by name."""
        for name, value in values.items():
            self.writer([name])([value])

    def reader(self, names: Iterable[str]) -> Read:
        """A function that reads these variables at once."""
        count, refs, buffer = self._buffers(names)
        get, instance = self._function("Get"), self._fmu.component
        length = () if self.version == 2 else (count,)

        def read() -> list[float]:
            if get(instance, refs, count, buffer, *length) > _WARNING:
                raise self.failure("reading its outputs")
            return buffer[:]

        return read if count else list

    def writer(self, names: Iterable[str]) -> Write:
        """A function that writes these variables at once."""
        count, refs, buffer = self._buffers(names)
        put, instance = self._function("Set"), self._fmu.component
        length = () if self.version == 2 else (count,)

        def write(values: Sequence[float]) -> None:
            buffer[:] = values
            if put(instance, refs, count, buffer, *length) > _WARNING:
                raise self.failure("setting its inputs")

        return write if count else _nothing

    def _function(self, verb: str) -> Any:
        """The C function itself: FMPy set its types when it loaded the library."""
        name = f"fmi2{verb}Real" if self.version == 2 else f"fmi3{verb}Float64"
        return getattr(self._fmu.dll, name)

    def _buffers(self, names: Iterable[str]) -> tuple[int, Any, Any]:
        refs = [self.variable(name).valueReference for name in names]
        return len(refs), (ct.c_uint32 * len(refs))(*refs), (ct.c_double * len(refs))()

    def step(self, t: float, h: float) -> None:
        """One communication step from t [s] over h [s]."""
        self.time = t
        if self.version == 3:
            self._step3(t, h)
        elif self._fmu.dll.fmi2DoStep(self._fmu.component, t, h, 1) > _WARNING:
            raise self.failure("doStep")

    def _step3(self, t: float, h: float) -> None:
        call, answers = self._fmu.dll.fmi3DoStep, self._answers
        if call(self._fmu.component, t, h, True, *answers) > _WARNING:
            raise self.failure("doStep")
        if self._flags[1].value or self._flags[2].value:
            raise self.failure("doStep, which it ended early")

    def failure(self, what: str, error: Exception | None = None) -> FmuError:
        """What to raise where it fails in ``what``: a sentence with file, part and time."""
        reason = str(error) if error is not None else "; ".join(self.messages[-1:])
        cause = f"{': ' if reason else ''}{reason.strip()}".rstrip(".")
        return FmuError(
            f"the FMU {self.path} ({self.name}) failed at t = {self.time:.9g} s in {what}{cause}."
        )

    def end(self) -> None:
        """Terminate and free the instance, whatever state it is in."""
        for call in (self._fmu.terminate, self._fmu.freeInstance):
            try:
                call()
            except Exception:  # an FMU that failed may refuse to terminate
                continue


class _Telling:
    """Turns whatever an FMU raises into an FmuError that names it."""

    def __init__(self, slave: Slave, what: str) -> None:
        self.slave, self.what = slave, what

    def __enter__(self) -> None:
        """Nothing to prepare."""

    def __exit__(self, kind: Any, error: Exception | None, _trace: Any) -> None:
        """Rename what FMPy raised."""
        if error is not None and not isinstance(error, WmrError):
            raise self.slave.failure(self.what, error) from error


def _nothing(values: Sequence[float]) -> None:
    """Write no variable."""

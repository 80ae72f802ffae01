"""One FMU in co-simulation, through FMPy: read, write and step with arrays made once."""

import ctypes as ct
import hashlib
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import chdir, suppress
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, UnknownNameError, WmrError
from wmr_ctrl.core.fields.files import note_input
from wmr_ctrl.core.fields.named_units import BASE, NamedUnit
from wmr_ctrl.core.fields.values import may_unpack
from wmr_ctrl.export.fmi.targets import TARGETS, host

try:
    import fmpy
    from fmpy import fmi2, fmi3
except (ImportError, OSError) as error:
    raise MissingExtraError(
        f"this needs FMPy, which cannot be imported ({error}): pip install --force-reinstall fmpy."
    ) from None

_WARNING = 1  # the highest status of a call that did what it should
_NEAR = 1e-3
"""Share of a step by which the time that an FMU says it reached may be off."""
Read = Callable[[], list[float]]
Write = Callable[[Sequence[float]], None]


_HEARERS: "WeakValueDictionary[int, Slave]" = WeakValueDictionary()
"""Instances of FMI 2 by the environment that their messages name."""


def _heard(environment: int | None, *logged: Any) -> None:
    """Pass a message on to its instance, or to FMPy: the library knows one logger for all."""
    slave = _HEARERS.get(environment or 0)
    if slave is None:
        fmi2.printLogMessage(environment, *logged)
    else:
        slave._hear(*logged)


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_heard)


class FmuError(WmrError, RuntimeError):
    """An FMU refused a call or could not be loaded; the message names it and says when."""


class FmuFile:
    """Variables, units and name of an FMU.  Raises FmuError for a file that is none.

    ``name`` is how messages call it; ``checked``: against FMI's schema.
    """

    def __init__(self, path: str | Path, name: str, *, checked: bool = True) -> None:
        self.name, self.path = name, os.fspath(path)
        if checked:  # others this command wrote
            note_input(path, name)
        try:
            with zipfile.ZipFile(self.path) as archive:
                unpacked = sum(item.file_size for item in archive.infolist())
            if not may_unpack(os.path.getsize(self.path), unpacked):
                raise ArgumentError(
                    f"it is {unpacked / 1e6:.0f} MB unpacked, which is implausible for its size. "
                    "Check where it comes from."
                )
            self.description = fmpy.read_model_description(self.path, validate=checked)
        except Exception as error:  # FMPy raises bare Exceptions
            raise self.unusable(error) from error
        self.variables = {v.name: v for v in self.description.modelVariables}

    def unusable(self, error: Exception) -> FmuError:
        """Error to raise for a file that cannot be loaded."""
        return FmuError(f"the FMU {self.path} ({self.name}) cannot be used: {_reason(error)}")

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
        units = {}
        for item in self.description.unitDefinitions:
            name, base = str(item.name), item.baseUnit
            if base is not None:
                exponents = {key: int(getattr(base, key)) for key in BASE if getattr(base, key)}
                units[name] = NamedUnit(name, float(base.factor), exponents, float(base.offset))
        return units

    def variable(self, name: str) -> Any:
        """A real variable's description; raises UnknownNameError or ArgumentError."""
        if name not in self.variables:
            raise UnknownNameError(f"variable of the FMU {self.path}", name, self.variables)
        variable = self.variables[name]
        if variable.type not in ("Real", "Float64"):
            raise ArgumentError(
                f"{name} of the FMU {self.path} is of type {variable.type}; only real "
                "variables can be used. Map another variable."
            )
        if variable.dimensions:
            raise ArgumentError(
                f"{name} of the FMU {self.path} is an array; only single numbers can be used. Map "
                "another variable."
            )
        return variable


def _reason(error: Exception) -> str:
    """Fault of a file that cannot be loaded, and its remedy; our own errors name both."""
    if isinstance(error, WmrError):
        return str(error)
    if isinstance(error, FileNotFoundError):
        return "there is no such file. Check the path."
    if isinstance(error, IsADirectoryError):
        return "it is a folder. Name the file, which ends in .fmu."
    if isinstance(error, zipfile.BadZipFile):
        return f"it is no whole zip archive, which every FMU is ({error}). Copy or export it again."
    if isinstance(error, KeyError):
        return f"it lacks a part ({error.args[0]}). Export it again."
    if isinstance(error, (AttributeError, TypeError)):
        return "its modelDescription.xml is none of FMI 2.0 or 3.0. Export it again."
    said = str(error).rstrip(".")
    return f"{said}. Export it again, for co-simulation by FMI 2.0 or 3.0 on this platform."


def _place(folder: Path, version: int, model: str) -> Path:
    """Place of this machine's library in an unpacked FMU.

    In FMI 2 a processor's own folder comes before the one that FMPy takes, which may hold another
    processor's library.
    """
    name = model + fmpy.sharedLibraryExtension
    if version == 3:
        return Path("binaries", fmpy.platform_tuple, name)
    own = (Path("binaries", target.fmi2, name) for target in TARGETS if target.name == host())
    there = (place for place in own if (folder / place).is_file())
    return next(there, Path("binaries", fmpy.platform, name))


def _try_to_load(folder: Path, inside: Path) -> None:
    """Raise ArgumentError unless a process of its own can load an unpacked FMU's library.

    One that is cut off or overwritten ends the process that loads it instead of raising.
    """
    here, library = inside.parent.name, folder.absolute() / inside
    if not library.is_file():
        others = sorted(item.name for item in folder.glob("binaries/*") if any(item.iterdir()))
        raise ArgumentError(
            f"it has no {inside.as_posix()}, and this platform is {here}; it is built for "
            f"{', '.join(others) or 'no platform'}. Export it for {here}."
        )
    load = [sys.executable, "-I", "-S", "-c", "import ctypes as c, sys; c.CDLL(sys.argv[1])"]
    done = subprocess.run(
        [*load, str(library)], cwd=library.parent, capture_output=True, text=True, check=False
    )
    if done.returncode:
        *_, said = ("", *done.stderr.strip().splitlines())
        _, ours, why = said.removeprefix("OSError: ").rpartition(f"{library}: ")
        if done.returncode != 1:
            why = "the process that tried was ended by it, so it is damaged or cut off"
        elif ours and "No such file" in why:  # the loader's word for another processor's
            why = "it is for another processor"
        raise ArgumentError(
            f"its library {inside.as_posix()} cannot be loaded on this machine: {why}. "
            f"Copy the file again, or export it again for {here}."
        )


class Slave(FmuFile):
    """An FMU for co-simulation, version 2.0 or 3.0, ready to be initialised.

    ``name`` is how messages call it.  Raises FmuError where it cannot be loaded.
    """

    def __init__(
        self, path: str | Path, name: str, folder: str | Path, *, ours: bool = False
    ) -> None:
        """Unpack ``path`` below ``folder`` and create one instance.

        ``ours``: this process wrote it, so that it is neither compared with FMI's schema nor loaded
        by another process first.
        """
        super().__init__(path, name, checked=not ours)
        self.time = 0.0
        self.messages: list[str] = []
        self._warned, self._first = 0, ""
        self.version = 2 if self.description.fmiVersion == "2.0" else 3
        self._flags, self._last = [ct.c_bool() for _ in range(3)], ct.c_double()
        self._answers = [*map(ct.byref, self._flags), ct.byref(self._last)]
        try:
            interface = self.description.coSimulation
            if interface is None:
                text = "it has no co-simulation interface. Export it for co-simulation."
                raise ArgumentError(text)
            model = interface.modelIdentifier
            fmpy.extract(self.path, str(folder))
            place = _place(Path(folder), self.version, model)
            if not ours and sys.executable:
                _try_to_load(Path(folder), place)
            with chdir("."):  # FMPy stays in another folder if it cannot load the library
                self._fmu = (fmi2.FMU2Slave if self.version == 2 else fmi3.FMU3Slave)(
                    guid=self.description.guid,
                    unzipDirectory=str(folder),
                    instanceName=self.name,
                    modelIdentifier=model,
                    libraryPath=str(Path(folder).absolute() / place),
                )
            self._instantiate()
        except AttributeError as error:  # a symbol that FMPy looks for
            raise self.unusable(
                ArgumentError(
                    f"its library lacks a function of FMI {self.description.fmiVersion} "
                    f"({str(error).rpartition(': ')[2]}). Export it again, for co-simulation."
                )
            ) from error
        except Exception as error:  # FMPy raises bare Exceptions
            raise self.unusable(error) from error

    def _instantiate(self) -> None:
        if self.version == 3:
            self._fmu.instantiate(logMessage=self._hear)
            return
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.componentEnvironment = id(self)
        _HEARERS[id(self)] = self
        callbacks.allocateMemory = fmi2.defaultCallbacks.allocateMemory
        callbacks.freeMemory = fmi2.defaultCallbacks.freeMemory
        with suppress(Exception):  # FMPy's library that puts a message's values into its text
            import_module("fmpy.logging").addLoggerProxy(ct.byref(callbacks))
        self._callbacks = callbacks
        self._fmu.instantiate(callbacks=callbacks)

    def _hear(self, *logged: Any) -> None:
        """Keep a message, which both versions of FMI give last."""
        self.messages.append((logged[-1] or b"").decode(errors="replace"))

    def begin(self, stop: float, values: Mapping[str, float]) -> None:
        """Set start values and initialise at t = 0 s."""
        try:
            if self.version == 2:
                self._fmu.setupExperiment(startTime=0.0, stopTime=stop)
                self.set(values)
                self._fmu.enterInitializationMode()
            else:
                self.set(values)
                self._fmu.enterInitializationMode(startTime=0.0, stopTime=stop)
            self._fmu.exitInitializationMode()
        except WmrError:
            raise
        except Exception as error:  # FMPy raises bare Exceptions
            raise self.failure("initialisation", error) from error

    def set(self, values: Mapping[str, float]) -> None:
        """Set variables by name."""
        for name, value in values.items():
            self.writer([name])([value])

    def reader(self, names: Iterable[str]) -> Read:
        """A function that reads these variables at once."""
        get, buffer = self._bound("Get", names)

        def read() -> list[float]:
            if get() > _WARNING:
                raise self.failure("reading its outputs")
            return buffer[:]

        return read

    def writer(self, names: Iterable[str]) -> Write:
        """A function that writes these variables at once."""
        put, buffer = self._bound("Set", names)

        def write(values: Sequence[float]) -> None:
            buffer[:] = values
            if put() > _WARNING:
                raise self.failure("setting its inputs")

        return write

    def _bound(self, verb: str, names: Iterable[str]) -> tuple[Callable[[], int], Any]:
        """The C function itself, whose types FMPy has set, on these variables; their buffer."""
        refs = [self.variable(name).valueReference for name in names]
        count, buffer = len(refs), (ct.c_double * len(refs))()
        name = f"fmi2{verb}Real" if self.version == 2 else f"fmi3{verb}Float64"
        given = (self._fmu.component, (ct.c_uint32 * count)(*refs), count, buffer)
        length = () if self.version == 2 else (count,)
        return partial(getattr(self._fmu.dll, name), *given, *length), buffer

    def step(self, t: float, h: float) -> None:
        """One communication step from t [s] over h [s]."""
        self.time = t
        dll, instance = self._fmu.dll, self._fmu.component
        if self.version == 2:
            status = dll.fmi2DoStep(instance, t, h, 1)
        else:
            self._last.value = t + h
            status = dll.fmi3DoStep(instance, t, h, True, *self._answers)
        if status > _WARNING:
            raise self.failure("doStep")
        if status == _WARNING:
            self._warned += 1
            self._first = self._first or f"t = {t:.9g} s: {'; '.join(self.messages[-1:])}"
        if self._flags[1].value or self._flags[2].value:
            raise self.failure("doStep, which it ended early")
        reached, end = self._last.value, t + h
        if self.version == 3 and not abs(reached - end) <= _NEAR * h:
            raise self.failure(f"doStep to {end:.9g} s, of which it reached {reached:.9g}")

    @property
    def takes_any_step(self) -> bool:
        """Whether its communication steps may differ in size, as its description says."""
        return bool(self.description.coSimulation.canHandleVariableCommunicationStepSize)

    @property
    def warnings(self) -> str:
        """In how many steps it warned, and when and of what first; empty if it never did."""
        return f"{self._warned} steps, first at {self._first}" if self._warned else ""

    def failure(self, what: str, error: Exception | None = None) -> FmuError:
        """Error to raise where it fails in ``what``: a sentence with file, part and time."""
        reason = str(error) if error is not None else "; ".join(self.messages[-1:])
        cause = f"{': ' if reason else ''}{reason.strip()}".rstrip(".")
        return FmuError(
            f"the FMU {self.path} ({self.name}) failed at t = {self.time:.9g} s in {what}{cause}."
        )

    def end(self) -> None:
        """Terminate and free the instance, whatever state it is in."""
        for call in (self._fmu.terminate, self._fmu.freeInstance):
            with suppress(Exception):  # an FMU that failed may refuse to terminate
                call()

"""One FMU in co-simulation, through FMPy: read, write and step with preallocated arrays."""

import ctypes as ct
import math
import sys
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import chdir, suppress
from functools import partial
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import fmpy
import numpy as np
from fmpy import fmi2, fmi3
from fmpy.simulation import apply_start_values

from wmr_ctrl.core.errors import ArgumentError, WmrError, show

from .fmu_file import FLOATS, FmuError, FmuFile
from .library_file import build_sources, place_of, try_to_load

_WARNING = 1  # the highest status of a call that did what it should
_NEAR = 1e-3
"""Share of a step by which the time that an FMU says it reached may be off."""
_MOST_HEARD = 3
"""Messages that an error repeats."""
_TYPES: Mapping[str, str] = {
    "Real": "double", "Float64": "double", "Float32": "float", "Integer": "int32",
}  # fmt: skip
"""C types of numbers whose names in FMI are others."""
Read = Callable[[], list[float]]
Write = Callable[[Sequence[float]], None]


_HEARERS: "WeakValueDictionary[int, Slave]" = WeakValueDictionary()
"""Instances of FMI 2 by the environment that their messages name."""


def _heard(environment: int | None, *logged: Any) -> None:
    """Pass a message on to its instance, or to FMPy, since the library has only one logger."""
    slave = _HEARERS.get(environment or 0)
    if slave is None:
        fmi2.printLogMessage(environment, *logged)
    else:
        slave._hear(*logged)


_LOGGER = fmi2.fmi2CallbackLoggerTYPE(_heard)


class Values:
    """Variables of one type, each once, as arrays for the FMU's functions.

    ``begins``: index of each variable's first number, by its value reference.
    """

    def __init__(self, fmu: Any, version: int, kind: str, variables: Iterable[Any]) -> None:
        own = {v.valueReference: v for v in variables}
        sizes = [math.prod(v.shape or ()) for v in own.values()]
        self.begins = dict(zip(own, np.cumsum([0, *sizes]).tolist(), strict=False))
        self.arrays = any(v.shape for v in own.values())
        count, length = len(own), sum(sizes)
        enumerated = {2: "Integer", 3: "Int64"}[version]
        name = enumerated if kind == "Enumeration" else kind
        boolean = {2: "int32", 3: "bool"}[version]
        c_type = boolean if kind == "Boolean" else _TYPES.get(name, name.lower())
        self.numbers = (getattr(ct, f"c_{c_type}") * length)()
        self.kind, self.whole = kind, name not in FLOATS
        if self.arrays:  # of which an element may be written before another can be read
            for place, start in enumerate(chain(*map(_starts, own.values(), sizes))):
                self.assign(place, start)
        given = fmu.component, (ct.c_uint32 * count)(*own), count, self.numbers
        size = () if version == 2 else (length,)
        verbs = (getattr(fmu.dll, f"fmi{version}{verb}{name}") for verb in ("Get", "Set"))
        self.get, self.put = (partial(call, *given, *size) for call in verbs)

    def assign(self, place: int, value: float) -> None:
        """Store a number: rounded for integers; for a Boolean, whether it is at least 0.5.

        Raises ValueError or OverflowError if the type cannot represent it.
        """
        wanted = value >= 0.5 if self.kind == "Boolean" else round(value) if self.whole else value
        self.numbers[place] = wanted
        if self.whole and self.numbers[place] != wanted:
            raise ValueError(f"{wanted} does not fit into type {self.kind}")


def _starts(variable: Any, size: int) -> list[float]:
    """Start values of a variable's elements from its description; 0 if it has none."""
    words = str(variable.start or "").split()
    named = {"true": 1.0, "false": 0.0}
    numbers = [named[word] if word in named else float(word) for word in words]
    return numbers if len(numbers) == size else numbers[:1] * size or [0.0] * size


class Slave(FmuFile):
    """An FMU for co-simulation, version 2.0 or 3.0, ready to be initialised.

    ``name`` is its name in messages.  Raises FmuError if it cannot be loaded.
    """

    def __init__(
        self,
        path: str | Path,
        name: str,
        folder: str | Path,
        *,
        ours: bool = False,
        compiled: bool = False,
    ) -> None:
        """Unpack ``path`` below ``folder`` and create one instance.

        ``ours``: this process wrote it, so it is neither validated against FMI's schema nor
        test-loaded in another process; ``compiled``: its sources are built if it has no library for
        this machine.
        """
        super().__init__(path, name, checked=not ours)
        self.time, self._begun = 0.0, False
        self.messages: deque[str] = deque(maxlen=10 * _MOST_HEARD)
        self._faults: dict[str, tuple[int, str]] = {}
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
            place = place_of(Path(folder), self.version, model)
            if compiled:
                build_sources(Path(folder), place, self.description)
            if not ours and sys.executable:
                try_to_load(Path(folder), place)
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
            raise self.unusable(error, self._refusal) from error

    @property
    def _refusal(self) -> str:
        """Messages of an FMU that refused, and its clocks, which may be the cause."""
        said = "; ".join(dict.fromkeys([*self.messages][-_MOST_HEARD:]))
        clocks = [v.name for v in self.variables.values() if v.type == "Clock"]
        parts = [f" It said: {said.rstrip('.')}."] if said else []
        if clocks:
            parts.append(
                f" It has clocks ({', '.join(clocks[:_MOST_HEARD])}), which need event mode, and "
                "this master has none: export it without clocks."
            )
        return "".join(parts)

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
        """Store a message, which is the last argument in both versions of FMI."""
        self.messages.append((logged[-1] or b"").decode(errors="replace"))

    def begin(self, stop: float, values: Mapping[str, object]) -> None:
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
            self._begun = True
        except WmrError:
            raise
        except Exception as error:  # FMPy raises bare Exceptions
            raise self.failure("initialisation", error) from error

    def set(self, values: Mapping[str, object]) -> None:
        """Set variables by name, of any type; arrays also as lists."""
        for name, value in values.items():
            known = self.variables.get(name)
            try:
                if known is None:
                    self.writer([name])([float(str(value))])
                    continue
                if known.type not in FLOATS and isinstance(value, float) and value % 1:
                    raise ValueError(f"it is of type {known.type}, and {value} is no whole number")
                apply_start_values(self._fmu, self.description, {name: value})
            except WmrError:
                raise
            except Exception as error:  # FMPy raises bare Exceptions
                raise self.failure(f"setting {name} to {show(value)}", error) from error

    def reader(self, names: Iterable[str]) -> Read:
        """Function that reads these numbers in one call."""
        parts, places = self._bound(names)
        found = [(part.numbers, place) for part, place in places]

        def read() -> list[float]:
            if any(part.get() > _WARNING for part in parts):
                raise self.failure("reading its outputs")
            return [float(numbers[place]) for numbers, place in found]

        return read

    def writer(self, names: Iterable[str]) -> Write:
        """Function that writes these numbers in one call; other array elements are unchanged."""
        listed = tuple(names)
        parts, places = self._bound(listed)
        unread = [part for part in parts if part.arrays]

        def write(values: Sequence[float]) -> None:
            while unread and self._begun:
                if unread.pop().get() > _WARNING:
                    raise self.failure("reading its arrays")
            for name, (part, place), value in zip(listed, places, values, strict=True):
                try:
                    part.assign(place, value)
                except (ValueError, OverflowError) as error:
                    raise self.failure(f"setting {name}", error) from error
            if any(part.put() > _WARNING for part in parts):
                raise self.failure("setting its inputs")

        return write

    def _bound(self, names: Iterable[str]) -> tuple[list[Values], list[tuple[Values, int]]]:
        """Arrays of these numbers by type, and array and index of each number."""
        wanted = [self.number(name) for name in names]
        parts = {
            kind: Values(self._fmu, self.version, kind, [v for v, _ in wanted if v.type == kind])
            for kind in dict.fromkeys(v.type for v, _ in wanted)
        }
        places = [(parts[v.type], parts[v.type].begins[v.valueReference] + i) for v, i in wanted]
        return list(parts.values()), places

    def step(self, t: float, h: float) -> None:
        """One communication step from t [s] over h [s]."""
        self.time = t
        self.messages.clear()
        dll, instance = self._fmu.dll, self._fmu.component
        if self.version == 2:
            status = dll.fmi2DoStep(instance, t, h, 1)
        else:
            self._last.value = t + h
            status = dll.fmi3DoStep(instance, t, h, True, *self._answers)
        if status > _WARNING:
            raise self.failure("doStep")
        if status == _WARNING:
            self._told("warned", t, "; ".join([*self.messages][-1:]))
        if self._flags[1].value or self._flags[2].value:
            raise self.failure("doStep, which it ended early")
        behind = t + h - self._last.value
        if self.version == 3 and behind > _NEAR * h:
            self._told("lagged", t, f"{behind:.9g} s behind the step's end")

    def _told(self, what: str, t: float, words: str) -> None:
        """Count a step with a non-fatal fault; the first one is recorded with ``words``."""
        count, first = self._faults.get(what, (0, f"first at t = {t:.9g} s: {words}"))
        self._faults[what] = count + 1, first

    @property
    def faults(self) -> Mapping[str, str]:
        """Non-fatal faults: numbers of steps with a warning or a lag, each with its first message.

        It also has violations of the schema if the file is ``invalid``.
        """
        told = {what: f"{count} steps, {first}" for what, (count, first) in self._faults.items()}
        return told | ({"invalid": self.invalid} if self.invalid else {})

    @property
    def takes_any_step(self) -> bool:
        """True if its description allows communication steps of different sizes."""
        return bool(self.description.coSimulation.canHandleVariableCommunicationStepSize)

    def failure(self, what: str, error: Exception | None = None) -> FmuError:
        """Error to raise if the call ``what`` fails: a sentence with file, part and time."""
        said = dict.fromkeys([*self.messages][-_MOST_HEARD:])
        reason = "; ".join([*([str(error).rstrip(".")] if error is not None else []), *said])
        cause = f"{': ' if reason else ''}{reason.strip()}".rstrip(".")
        return FmuError(
            f"the FMU {self.path} ({self.name}) failed at t = {self.time:.9g} s in {what}{cause}."
        )

    def end(self) -> None:
        """Terminate and free the instance, in any state."""
        for call in (self._fmu.terminate, self._fmu.freeInstance):
            with suppress(Exception):  # an FMU that failed may refuse to terminate
                call()

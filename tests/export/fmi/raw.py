"""An FMU's C functions through ctypes, for calls that no importer would make."""

from __future__ import annotations

import ctypes as ct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmpy import fmi2, fmi3, platform, platform_tuple, read_model_description

OK, WARNING, DISCARD, ERROR = range(4)
REFUSED = (DISCARD, ERROR)
CS, ME = "CoSimulation", "ModelExchange"
ONE = ct.c_size_t(1)


def reals(*values):
    return (ct.c_double * len(values))(*values)


def refs(*values):
    return (ct.c_uint32 * len(values))(*values)


class Fmu:
    """A library and its description."""

    def __init__(self, path, folder, version):
        self.path, self.folder, self.version = path, Path(folder), version
        self.description = read_model_description(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.outputs = [n for n, v in self.variables.items() if v.causality == "output"]
        self.inputs = [n for n, v in self.variables.items() if v.causality == "input"]
        self.interfaces = [CS] if self.description.modelExchange is None else [CS, ME]
        name = self.description.coSimulation.modelIdentifier
        where = platform if version == 2 else platform_tuple
        self.library = self.folder / "binaries" / where / f"{name}.so"
        self.dll = ct.CDLL(str(self.library))
        self.real, self.int64, self.state = (
            ("Real", "Integer", "FMUstate") if version == 2 else ("Float64", "Int64", "FMUState")
        )
        self.messages, self.categories = [], set()

        def hear(*said):
            status, category, text = said[-3:]
            self.messages.append(text.decode())
            self.categories.add((status, category.decode()))

        self._log = fmi3.fmi3LogMessageCallback(hear)
        self._callbacks = fmi2.fmi2CallbackFunctions(logger=fmi2.fmi2CallbackLoggerTYPE(hear))

    def __getattr__(self, name):
        function = getattr(self.dll, f"fmi{self.version}{name}")
        function.restype = ct.c_void_p if name.startswith("Instantiate") else ct.c_int
        return function

    def length(self, count):
        """The number of values, as FMI 3 counts them."""
        return () if self.version == 2 else (ct.c_size_t(count),)

    def ref(self, name):
        return self.variables[name].valueReference

    def instantiate(self, interface=CS, **given):
        """A handle, or None; keywords replace single arguments."""
        usual = {"name": b"one", "token": self.description.guid.encode(), "resources": b"file:///r"}
        named = tuple((usual | given)[key] for key in usual)
        if self.version == 2:
            callbacks = given.get("callbacks", ct.byref(self._callbacks))
            name, *others = named
            return self.Instantiate(name, int(interface == CS), *others, callbacks, 0, 0)
        log = given.get("log", self._log)
        if interface == ME:
            return self.InstantiateModelExchange(*named, False, False, None, log)
        flags = (False, False, given.get("events", False), given.get("early", False))
        update = None, ct.c_size_t(0), None, log, given.get("update")
        return self.InstantiateCoSimulation(*named, *flags, *update)

    def new(self, interface=CS, **given):
        handle = self.instantiate(interface, **given)
        assert handle
        return Instance(self, ct.c_void_p(handle))


@dataclass
class Instance:
    """One instance with the calls that both versions share."""

    fmu: Fmu
    handle: Any

    def setup(self, start=0.0, stop=None, tolerance=None):
        """Start time, stop time, tolerance, then initialization mode."""
        told = (int(tolerance is not None), ct.c_double(tolerance or 0.0))
        times = (ct.c_double(start), int(stop is not None), ct.c_double(stop or 0.0))
        if self.fmu.version == 3:
            return self.fmu.EnterInitializationMode(self.handle, *told, *times)
        return max(
            self.fmu.SetupExperiment(self.handle, *told, *times),
            self.fmu.EnterInitializationMode(self.handle),
        )

    def leave(self):
        return self.fmu.ExitInitializationMode(self.handle)

    def begin(self, start=0.0, stop=None):
        assert self.setup(start, stop) == self.leave() == OK
        return self

    def step(self, t, h):
        return self.stepped(t, h)[0]

    def stepped(self, t, h):
        """Status, and in FMI 3 its three flags and the time that was reached."""
        told = [] if self.fmu.version == 2 else [*(ct.c_bool() for _ in range(3)), ct.c_double()]
        times = ct.c_double(t), ct.c_double(h)
        status = self.fmu.DoStep(self.handle, *times, True, *map(ct.byref, told))
        return status, *(item.value for item in told)

    def put(self, values):
        return self.put_refs([self.fmu.ref(name) for name in values], list(values.values()))

    def put_refs(self, listed, values):
        return self._values("Set", listed, reals(*values))

    def get_refs(self, listed, count=None):
        buffer = reals(*[0.0] * (count or len(listed)))
        return self._values("Get", listed, buffer), buffer[:]

    def _values(self, verb, listed, buffer):
        call, length = getattr(self.fmu, verb + self.fmu.real), self.fmu.length(len(buffer))
        return call(self.handle, refs(*listed), ct.c_size_t(len(listed)), buffer, *length)

    def get(self, *names):
        status, values = self.get_refs([self.fmu.ref(name) for name in names])
        assert status == OK
        return values

    def integer(self, verb, name, value=0):
        """Status of a function of integers, and the number behind its pointer."""
        call = getattr(self.fmu, verb + self.fmu.int64)
        place = ((ct.c_int32 if self.fmu.version == 2 else ct.c_int64) * 1)(value)
        status = call(self.handle, refs(self.fmu.ref(name)), ONE, place, *self.fmu.length(1))
        return status, place[0]

    def all(self):
        """Every real variable's elements."""
        found = []
        for v in self.fmu.description.modelVariables:
            if v.type == self.fmu.real:
                size = int(v.dimensions[0].start) if v.dimensions else 1
                status, values = self.get_refs([v.valueReference], size)
                assert status == OK, v.name
                found += values
        return found

    def reset(self):
        return self.fmu.Reset(self.handle)

    def free(self):
        self.fmu.FreeInstance(self.handle)

    def bytes_of_state(self):
        """The state now, serialised."""
        kept, size = ct.c_void_p(), ct.c_size_t()
        assert self.of_state("Get", ct.byref(kept)) == OK
        assert self.of_state("Serialized", kept, ct.byref(size), end="Size") == OK
        buffer = (ct.c_ubyte * size.value)()
        short = ct.c_size_t(size.value - 1)
        assert self.of_state("Serialize", kept, buffer, short) == ERROR
        assert self.of_state("Serialize", kept, buffer, size) == OK
        assert self.of_state("Free", ct.byref(kept)) == OK
        assert not kept.value
        return bytes(buffer)

    def of_state(self, verb, *given, end=""):
        """Status of a function of states: its verb, arguments, and the end of its name."""
        return getattr(self.fmu, f"{verb}{self.fmu.state}{end}")(self.handle, *given)

    def restore(self, content):
        """Restore a serialised state."""
        kept = ct.c_void_p()
        read = "DeSerialize" if self.fmu.version == 2 else "Deserialize"
        buffer = (ct.c_ubyte * len(content)).from_buffer_copy(content)
        status = self.of_state(read, buffer, ct.c_size_t(len(content)), ct.byref(kept))
        if status == OK:
            status = self.of_state("Set", kept)
            self.of_state("Free", ct.byref(kept))
        return status

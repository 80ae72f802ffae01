"""An FMU's C functions through ctypes, for calls that no importer would make."""

from __future__ import annotations

import ctypes as ct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmpy import platform, platform_tuple, read_model_description

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
REFUSED = (DISCARD, ERROR)
CS, ME = "CoSimulation", "ModelExchange"
LOGGER2 = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_char_p, ct.c_int, ct.c_char_p, ct.c_char_p)
ONE = ct.c_size_t(1)
LOGGER3 = ct.CFUNCTYPE(None, ct.c_void_p, ct.c_int, ct.c_char_p, ct.c_char_p)


class Callbacks(ct.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOGGER2),
        ("allocate", ct.c_void_p),
        ("free", ct.c_void_p),
        ("finished", ct.c_void_p),
        ("environment", ct.c_void_p),
    )


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
        name = self.description.coSimulation.modelIdentifier
        where = platform if version == 2 else platform_tuple
        self.library = self.folder / "binaries" / where / f"{name}.so"
        self.dll = ct.CDLL(str(self.library))
        self.prefix = f"fmi{version}"
        self.real, self.int64 = ("Real", "Integer") if version == 2 else ("Float64", "Int64")
        self.state = "FMUstate" if version == 2 else "FMUState"
        self.messages = []
        self.categories = set()

        def hear(status, category, text):
            self.messages.append(text.decode())
            self.categories.add((status, category.decode()))

        self._log2 = LOGGER2(lambda _e, _n, *said: hear(*said))
        self._log3 = LOGGER3(lambda _e, *said: hear(*said))
        self._callbacks = Callbacks(logger=self._log2)

    @property
    def interfaces(self):
        return [CS, ME] if self.description.modelExchange is not None else [CS]

    def __getattr__(self, name):
        function = getattr(self.dll, self.prefix + name)
        function.restype = ct.c_void_p if name.startswith("Instantiate") else ct.c_int
        return function

    def length(self, count):
        """The number of values as FMI 3 has it."""
        return () if self.version == 2 else (ct.c_size_t(count),)

    def ref(self, name):
        return self.variables[name].valueReference

    def instantiate(self, interface=CS, **given):
        """A handle, or None; keywords replace single arguments."""
        name = given.get("name", b"one")
        token = given.get("token", self.description.guid.encode())
        resources = given.get("resources", b"file:///somewhere")
        if self.version == 2:
            callbacks = given.get("callbacks", ct.byref(self._callbacks))
            return self.Instantiate(name, int(interface == CS), token, resources, callbacks, 0, 0)
        log = given.get("log", self._log3)
        if interface == ME:
            return self.InstantiateModelExchange(name, token, resources, False, False, None, log)
        flags = (False, False, given.get("events", False), given.get("early", False))
        update = None, ct.c_size_t(0), None, log, given.get("update")
        return self.InstantiateCoSimulation(name, token, resources, *flags, *update)

    def new(self, interface=CS, **given):
        handle = self.instantiate(interface, **given)
        assert handle
        return Instance(self, ct.c_void_p(handle), interface)


@dataclass
class Instance:
    """One instance with the calls that both versions share."""

    fmu: Fmu
    handle: Any
    interface: str

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
        assert self.setup(start, stop) == OK
        assert self.leave() == OK
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
        call, length = getattr(self.fmu, f"Set{self.fmu.real}"), self.fmu.length(len(values))
        return call(self.handle, refs(*listed), ct.c_size_t(len(listed)), reals(*values), *length)

    def get_refs(self, listed, count=None):
        number = len(listed) if count is None else count
        buffer = reals(*[0.0] * number)
        call, length = getattr(self.fmu, f"Get{self.fmu.real}"), self.fmu.length(number)
        status = call(self.handle, refs(*listed), ct.c_size_t(len(listed)), buffer, *length)
        return status, buffer[:]

    def get(self, *names):
        status, values = self.get_refs([self.fmu.ref(name) for name in names])
        assert status == OK
        return values

    def integer(self, name):
        status, value = self._whole("Get", name, 0)
        assert status == OK
        return value

    def put_integer(self, name, value):
        return self._whole("Set", name, value)[0]

    def _whole(self, verb, name, value):
        """Status of a function of integers, and the number behind its pointer."""
        call = getattr(self.fmu, f"{verb}{self.fmu.int64}")
        place = ((ct.c_int32 if self.fmu.version == 2 else ct.c_int64) * 1)(value)
        status = call(self.handle, refs(self.fmu.ref(name)), ONE, place, *self.fmu.length(1))
        return status, place[0]

    def all(self):
        """Every real variable's elements."""
        found = []
        for v in self.fmu.description.modelVariables:
            if v.type in ("Real", "Float64"):
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
        """Status of a function of states: its verb, arguments, and what its name ends in."""
        return getattr(self.fmu, f"{verb}{self.fmu.state}{end}")(self.handle, *given)

    def restore(self, content):
        """Put a serialised state in place."""
        kept = ct.c_void_p()
        read = "DeSerialize" if self.fmu.version == 2 else "Deserialize"
        buffer = (ct.c_ubyte * len(content)).from_buffer_copy(content)
        status = self.of_state(read, buffer, ct.c_size_t(len(content)), ct.byref(kept))
        if status == OK:
            status = self.of_state("Set", kept)
            self.of_state("Free", ct.byref(kept))
        return status

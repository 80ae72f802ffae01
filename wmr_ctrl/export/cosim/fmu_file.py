"""An FMU's file: its variables with types and units, and reasons why it cannot be used."""

import hashlib
import os
import re
import zipfile
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import fmpy
import numpy as np
from fmpy.model_description import ModelVariable, ValidationError
from lxml import etree

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, WmrError
from wmr_ctrl.core.fields.files import note_input
from wmr_ctrl.core.fields.named_units import BASE, NamedUnit
from wmr_ctrl.core.fields.values import may_unpack

_READ = re.compile(r"2\.0|3\.0(\.\d+)?")
"""Versions of FMI."""
_ELEMENT = re.compile(r"(.+)\[(\d+(?:,\d+)*)\]")
_MOST_LISTED = 64
"""Elements of an array that a list of names has at most."""
FLOATS = ("Real", "Float64", "Float32")
NO_NUMBERS = ("String", "Binary", "Clock")


class FmuError(WmrError, RuntimeError):
    """An FMU refused a call or could not be loaded; the message names it and the time."""


class FmuFile:
    """Variables, units and name of an FMU.  Raises FmuError if the file is not an FMU.

    ``name`` is its name in messages; ``checked``: validate against FMI's schema; ``invalid``: where
    and how it violates the schema.
    """

    def __init__(self, path: str | Path, name: str, *, checked: bool = True) -> None:
        self.name, self.path, self.invalid = name, os.fspath(path), ""
        if checked:  # others this command wrote
            note_input(path, name)
        try:
            with zipfile.ZipFile(self.path) as archive:
                unpacked = sum(item.file_size for item in archive.infolist())
                if not may_unpack(os.path.getsize(self.path), unpacked):
                    raise ArgumentError(
                        f"it is {unpacked / 1e6:.0f} MB unpacked, which is implausible for its "
                        "size. Check where it comes from."
                    )
                root = etree.fromstring(archive.read("modelDescription.xml"))
            _check_version(root.get("fmiVersion"))
            try:
                self.description = fmpy.read_model_description(self.path, validate=checked)
            except ValidationError as error:  # as exporters write it, and importers accept it
                self.invalid = f"its modelDescription.xml, read all the same: {error.problems[0]}"
                self.description = fmpy.read_model_description(self.path, validate=False)
        except Exception as error:  # FMPy raises bare Exceptions
            raise self.unusable(error) from error
        self.variables = {v.name: v for v in self.description.modelVariables}

    def unusable(self, error: Exception, further: str = "") -> FmuError:
        """Error to raise for a file that cannot be loaded; ``further`` sentences end it."""
        reason = f"{_reason(error)}{further}"
        return FmuError(f"the FMU {self.path} ({self.name}) cannot be used: {reason}")

    @property
    def label(self) -> str:
        """Its model's name, file, FMI version and the beginning of the file's SHA-256."""
        digest = hashlib.sha256(Path(self.path).read_bytes()).hexdigest()[:16]
        said = self.description
        return f"{said.modelName} ({Path(self.path).name}, FMI {said.fmiVersion}, sha256 {digest})"

    def unit(self, name: str) -> NamedUnit | str | None:
        """A variable's unit in the model description: as defined there, by name, or None."""
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

    def variable(self, name: str) -> ModelVariable:
        """Description of the variable behind a `number`."""
        return self.number(name)[0]

    def number(self, name: str) -> tuple[ModelVariable, int]:
        """A number's variable, and its index from 0 in an array's ``name[1]``, ``name[1,2]``.

        Raises UnknownNameError, or ArgumentError for an array or a variable that is not a number.
        """
        part = _ELEMENT.fullmatch(name) if name not in self.variables else None
        owner = part[1] if part else name
        if owner not in self.variables:
            raise UnknownNameError(f"variable of the FMU {self.path}", name, self.variables)
        variable = self.variables[owner]
        if variable.type in NO_NUMBERS:
            raise ArgumentError(
                f"{name} of the FMU {self.path} is of type {variable.type}, which is no number. "
                "Map another variable."
            )
        shape = tuple(variable.shape or ())
        place = tuple(int(i) - 1 for i in part[2].split(",")) if part else ()
        if place not in np.ndindex(*shape):
            first, last = (",".join(map(str, side)) for side in ((1,) * len(shape), shape))
            hint = f"an array: name {owner}[{first}] to {owner}[{last}]" if shape else "one number"
            raise ArgumentError(f"{name} of the FMU {self.path}: {owner} is {hint}.")
        return variable, int(np.ravel_multi_index(place, shape)) if shape else 0

    @property
    def numbers(self) -> Iterator[tuple[str, ModelVariable]]:
        """Names for `number`, with their variables; of long arrays the first elements."""
        for name, variable in self.variables.items():
            if variable.type not in NO_NUMBERS and variable.causality != "independent":
                shape = tuple(variable.shape or ())
                for place in list(np.ndindex(*shape))[:_MOST_LISTED]:
                    tail = f"[{','.join(str(i + 1) for i in place)}]" if shape else ""
                    yield f"{name}{tail}", variable


def _check_version(version: str | None) -> None:
    """Raise ArgumentError for an unsupported version of FMI."""
    if version is not None and not _READ.fullmatch(version):
        raise ArgumentError(
            f"it is of FMI {version}, and only 2.0 and 3.0 are read. Export it by one of these, "
            "for co-simulation."
        )


def _reason(error: Exception) -> str:
    """Why a file cannot be loaded, with the remedy; our own errors state both."""
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

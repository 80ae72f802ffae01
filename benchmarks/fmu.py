"""One step of the plant FMU by FMPy, and the same call into a library that does nothing."""

from __future__ import annotations

import tempfile
from functools import cache, partial
from pathlib import Path
from shutil import copyfile, unpack_archive
from typing import Any

from wmr_ctrl.codegen.toolchain import build_library

from .timing import Candidate

_STEP = 1e-3
_FUNCTIONS = """
GetVersion SetDebugLogging FreeInstance SetupExperiment EnterInitializationMode
ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger
SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate
DeSerializeFMUstate GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives
DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus
EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime
SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates
GetNominalsOfContinuousStates
"""
_EXPORTED = '__attribute__((visibility("default")))'


def plant(steps: int) -> Candidate:
    """Steps of the plant FMU."""
    from wmr_ctrl.export.fmi.fmu_files import export_fmu

    folder = Path(_temporary().name)
    (archive,) = export_fmu("plant", fmi=2, out=folder)
    unpack_archive(archive, folder / "plant", "zip")
    text = (folder / "plant" / "modelDescription.xml").read_text(encoding="utf-8")
    return _candidate(folder / "plant", steps, text.split('guid="')[1].split('"')[0])


def empty(steps: int) -> Candidate:
    """Steps of an FMU all of whose functions return at once."""
    import fmpy

    lines = [f"{_EXPORTED} int fmi2{name}(void) {{ return 0; }}" for name in _FUNCTIONS.split()]
    lines.append(f"{_EXPORTED} void *fmi2Instantiate(void) {{ static int one; return &one; }}")
    lines.append(f'{_EXPORTED} const char *fmi2GetTypesPlatform(void) {{ return "default"; }}')
    library = build_library({"empty.c": "\n".join(lines) + "\n"}, name="empty")
    folder = Path(_temporary().name) / "empty"
    place = folder / "binaries" / fmpy.platform / f"empty{fmpy.sharedLibraryExtension}"
    place.parent.mkdir(parents=True)
    copyfile(library, place)
    return _candidate(folder, steps)


@cache
def _temporary() -> tempfile.TemporaryDirectory[str]:
    """Folder that is deleted when this process ends."""
    return tempfile.TemporaryDirectory(prefix="wmr_ctrl-bench-", ignore_cleanup_errors=True)


def _candidate(folder: Path, steps: int, guid: str = "") -> Candidate:
    from fmpy.fmi2 import FMU2Slave

    library = next((folder / "binaries").rglob("*.*"))
    slave = FMU2Slave(
        guid=guid, unzipDirectory=str(folder), modelIdentifier=library.stem, instanceName="one"
    )
    return Candidate(partial(_steps, slave, steps), steps)


def _steps(slave: Any, steps: int) -> None:
    """A run of ``steps`` steps from a fresh start."""
    if not getattr(slave, "wmr_started", False):
        slave.instantiate()
        slave.wmr_started = True
    else:
        slave.reset()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    for k in range(steps):
        slave.doStep(currentCommunicationPoint=k * _STEP, communicationStepSize=_STEP)

"""Export: from a scenario to self-contained FMU files.

Some tools look for an Apple processor's library in FMI 2's folder darwin64; a universal one
(several libraries in one file, each for its own processor) serves them and Intel alike. Some look
for an ARM processor's library in linux64, which is x86_64's: it is there if that folder is free.
"""

import struct
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from wmr_ctrl.control.given import law_of
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.outside import check_takes_torques
from wmr_ctrl.control.setup import check_gains, settle
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.version import __version__
from wmr_ctrl.world.scenario import Scenario, load_scenario, to_toml

from . import blocks, extra, xml
from .closed_loop import closed_loop_model
from .files import LEVEL, render, sources_of, write_archive
from .model_description import FmuModel
from .targets import TARGETS, Target, build_for, host, targets_of

TOOL = f"wmr_ctrl {__version__}"
VERSIONS = {"2": (2,), "3": (3,), "both": (2, 3)}

Progress = Callable[[str], None]
_MAGIC = 0xCAFEBABE
_ALIGNMENT = 14  # of each slice, as a power of two: 16 KiB pages


def export_fmu(
    what: str,
    *,
    law: str | None = None,
    scenario: str | Path | Scenario = "paper-simulation",
    fmi: str | int = "both",
    target: str = "host",
    out: str | Path = ".",
    arrays: bool = True,
    progress: Progress | None = None,
) -> list[Path]:
    """Write ``wmr_<what>.fmi2.fmu`` and ``wmr_<what>.fmi3.fmu`` into ``out``; returns their paths.

    ``what``: "plant", "reference", "guard", "filter", a law's name; or, of ``law``, "corridor" or
    "closed-loop" (None: the scenario's own, else kanayama).  ``fmi``: "2", "3" or "both".
    ``target``: "host", "all", or a platform such as "aarch64-linux".  ``arrays``: whether long
    vectors are arrays in FMI 3; False gives flat names there too.  ``progress`` is called with a
    line for each file.

    Raises UnknownNameError, ScenarioError, or CompilerError if a platform cannot be built.
    """
    case = scenario_given(scenario)
    if what in ("plant", "guard", "corridor"):
        check_takes_torques(case, f"the {what} is exported")
    model = model_of(what, law_of(case, law), case)
    paths = []
    for version in versions_of(fmi):
        path = Path(out) / f"wmr_{what}.fmi{version}.fmu"
        paths.append(write_fmu(model, version, targets_of(target), path, arrays=arrays))
        if progress:
            progress(f"{path}: {model.title}, FMI {version}.0, {target}")
    return paths


def scenario_given(scenario: str | Path | Scenario) -> Scenario:
    """The scenario itself, loaded if a name or path was given, with its gains checked."""
    loaded = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    check_gains(loaded)
    return loaded


def versions_of(fmi: str | int) -> tuple[int, ...]:
    """Versions behind "2", "3" or "both"; raises UnknownNameError otherwise."""
    if str(fmi) not in VERSIONS:
        raise UnknownNameError("version of FMI", str(fmi), VERSIONS)
    return VERSIONS[str(fmi)]


def model_of(what: str, law: str, scenario: Scenario) -> FmuModel:
    """The model called ``what``; raises UnknownNameError with the near names."""
    match what:
        case "plant":
            return blocks.plant_model(scenario)
        case "reference":
            return blocks.reference_model(scenario)
        case "guard":
            return blocks.guard_model(settle(scenario, None))
        case "filter":
            return blocks.filter_model(scenario)
        case "corridor":
            return blocks.corridor_model(scenario, law)
        case "closed-loop":
            return closed_loop_model(settle(scenario, law))
        case _ if what in LAWS:
            return blocks.law_model(settle(scenario, what))
    parts = ("plant", "reference", "guard", "filter", "corridor", "closed-loop")
    raise UnknownNameError("FMU", what, (*parts, *LAWS))


def write_fmu(
    model: FmuModel,
    version: int,
    targets: tuple[Target, ...],
    path: Path,
    *,
    arrays: bool = True,
    result: bool = True,
    level: int = LEVEL,
) -> Path:
    """Build and pack one file; ``result``: with a reference result, if this machine's library is
    built, and for a law its plain C; ``level`` of compression.

    Warns if FMPy cannot run it for the reference result, and omits that.
    """
    sources = sources_of(model, version, arrays=arrays)
    code = extra.plain_code(model) if result else {}
    note = extra.NOTE if code else ""
    text = xml.description(model, sources, version, TOOL, arrays=arrays, note=note)
    files = {"modelDescription.xml": text, **code}
    if version == 3:
        built_from = {"identifier": model.identifier, "units": sources.units}
        files["sources/buildDescription.xml"] = render("buildDescription.xml", m=built_from)
    files["documentation/index.html"] = xml.documentation(model, TOOL)
    files[f"{extra.EXTRA}/scenario.toml"] = to_toml(model.scenario)
    files |= {extra.GRAPH: model.graph} if model.graph else {}
    files |= {f"sources/{name}": text for name, text in sources.files.items()}
    packed = {name: text.encode() for name, text in files.items()}
    built = build_for(targets, sources, model.identifier)
    packed |= binaries(model, version, built)
    if result and host() in built:
        run = binaries(model, version, {host(): built[host()]})
        run["modelDescription.xml"] = text.encode()
        try:
            packed[extra.RESULT] = extra.reference_result(model, run)
        except Exception as error:  # FMPy raises bare Exceptions
            said = str(error).rstrip(".")
            note = f"{path} has no reference result: FMPy could not run it here ({said})."
            warnings.warn(note, stacklevel=2)
        else:
            packed |= {name: text.encode() for name, text in extra.references(model, TOOL).items()}
    write_archive(path, packed, level=level)
    return path


def binaries(model: FmuModel, version: int, built: Mapping[str, bytes]) -> dict[str, bytes]:
    """Paths in the FMU and contents of libraries, given by platform."""
    folders = {target: target.fmi2 if version == 2 else target.name for target in TARGETS}
    packed = {
        f"binaries/{folder}/{model.identifier}{target.suffix}": built[target.name]
        for target, folder in folders.items()
        if target.name in built
    }
    both = [built[name] for name in ("x86_64-darwin", "aarch64-darwin") if name in built]
    if version == 2 and both:
        packed[f"binaries/darwin64/{model.identifier}.dylib"] = joined(both)
    if "aarch64-linux" in built and "x86_64-linux" not in built:  # FMPy looks there, in FMI 3 too
        packed[f"binaries/linux64/{model.identifier}.so"] = built["aarch64-linux"]
    return packed


def joined(libraries: Sequence[bytes]) -> bytes:
    """One universal library from Mach-O libraries; a single one is unchanged."""
    if len(libraries) == 1:
        return libraries[0]
    page = 1 << _ALIGNMENT
    header, body, offset = struct.pack(">II", _MAGIC, len(libraries)), b"", page
    for library in libraries:
        cpu, subtype = struct.unpack_from("<II", library, 4)
        header += struct.pack(">IIIII", cpu, subtype, offset, len(library), _ALIGNMENT)
        padded = library + b"\0" * (-len(library) % page)
        body += padded
        offset += len(padded)
    return header + b"\0" * (page - len(header)) + body

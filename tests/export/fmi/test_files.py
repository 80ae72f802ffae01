"""C sources: warnings, sanitizers, rebuilding an FMU from its contents, the example."""

import os
import re
import subprocess
import sys
import zipfile
from itertools import product
from pathlib import Path

import pytest
from fmpy import simulate_fmu

from tests.commands import finished
from tests.compilers import where
from tests.export.conftest import MADE
from tests.export.fmi.test_targets import HEADERS, WHAT, linux
from tests.languages import compile_all
from wmr_ctrl.export.fmi.files import sources_of
from wmr_ctrl.export.fmi.fmu_files import model_of, scenario_given, write_fmu
from wmr_ctrl.export.fmi.targets import targets_of

ROOT = Path(__file__).resolve().parents[3]
WATCHED = (("plant", 2), ("plant", 3), ("reference", 3), ("closed-loop", 3))
"""FMUs of the battery of calls, and those whose states they refuse; the loop's law is mb."""


@pytest.mark.parametrize("language", ["g++-c++98", "clang-c99"])
@pytest.mark.slow
def test_sources_are_c_and_cpp_for_every_compiler(tmp_path, language):
    """Sources of all FMUs are compiled, each text once.

    The header of FMI 3.0 ends a list with a comma, which C++98 does not allow.
    """
    seen = set()
    for what, version in product(WHAT, (3, 2)):
        (folder := tmp_path / f"{what}-{version}").mkdir()
        model = model_of(what, "nn", scenario_given("paper-simulation"))
        found = sources_of(model, version)
        own = {name: text for name, text in found.files.items() if not (HEADERS / name).is_file()}
        for name, text in own.items():
            (folder / name).write_text(text, "utf-8")
        new = [unit for unit in found.units if own[unit] not in seen]
        seen.update(own.values())
        if new:
            compile_all(language, folder, new, "-isystem", str(HEADERS))
    assert len(seen) > 2 * len(WHAT)


@linux
@pytest.mark.slow
@pytest.mark.parametrize(
    "what, version, compiler, flags, most",
    [
        ("nn", 3, "cc", "-std=c99 -O0 -ffp-contract=off", 1e-9),
        ("plant", 2, "g++", "-x c++ -std=c++98 -O0 -ffp-contract=off", 0.0),
        ("closed-loop", 3, "clang", "-std=c99 -O2 -funsafe-math-optimizations", 1e-6),
        # Clang has no macro for these, so that the sources cannot refuse them, as with GCC.
        ("closed-loop", 3, "clang",
         "-std=c99 -O2 -fassociative-math -fno-signed-zeros -fno-trapping-math", 1e-6),
    ],
)  # fmt: skip
def test_rebuilt_from_its_own_sources(exported, tmp_path, what, version, compiler, flags, most):
    """Unpack, compile the files in the build description, put the library in place: the same FMU.

    It is linked without the flags; otherwise the library makes its whole process flush denormal
    numbers.
    """
    path = exported(what, version, scenario="safe-simulation")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    name = "sources/buildDescription.xml" if version == 3 else "modelDescription.xml"
    told = (tmp_path / name).read_text("utf-8")
    units = sorted(set(re.findall(r'File name="(\w+\.c)"', told)))
    library = next(tmp_path.glob("binaries/*/*.so"))
    before = library.read_bytes()
    objects = [unit.replace(".c", ".o") for unit in units]
    compiled = [*flags.split(), "-Wall", "-Werror", "-fPIC", "-fvisibility=hidden", "-c", *units]
    for words in (compiled, ["-shared", "-o", library, *objects, "-lm"]):
        finished([where(compiler), *words], cwd=tmp_path / "sources")
    assert library.read_bytes() != before
    first, second = (
        simulate_fmu(str(where), stop_time=3.0, output_interval=0.01, fmi_type="CoSimulation")
        for where in (path, tmp_path)
    )
    assert len(first) == 301
    for name in first.dtype.names:
        assert abs(first[name] - second[name]).max() <= most, name


SHALLOW = """
#define _GNU_SOURCE
#include <dlfcn.h>
void *dlopen(const char *file, int flags) {
    void *(*next)(const char *, int) = (void *(*)(const char *, int))dlsym(RTLD_NEXT, "dlopen");
    return next(file, flags & ~RTLD_DEEPBIND);
}
"""
"""CasADi loads its plugins with RTLD_DEEPBIND, at which AddressSanitizer ends the process."""


@pytest.mark.slow
@linux
def test_the_battery_runs_clean_under_sanitizers(tmp_path, monkeypatch):
    """AddressSanitizer and UndefinedBehaviorSanitizer with all calls.

    FMUs are written here, since a process under a sanitizer takes three times as long.
    """
    shallow = tmp_path / "shallow.so"
    command = [where("gcc"), "-shared", "-fPIC", "-x", "c", "-o", shallow, "-", "-ldl"]
    finished(command, input=SHALLOW)
    runtime = finished([where("gcc"), "-print-file-name=libasan.so"]).stdout.strip()
    flags = "-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer"
    # The compiler needs no watch itself.
    monkeypatch.setenv("WMR_CTRL_FMU_CC", f"env -u LD_PRELOAD gcc {flags} -g1")
    environment = {
        **os.environ,
        "LD_PRELOAD": f"{shallow} {runtime}",
        "ASAN_OPTIONS": f"verify_asan_link_order=0:detect_leaks=0:log_path={tmp_path}/found",
        "UBSAN_OPTIONS": f"log_path={tmp_path}/found",
        "PYTHONMALLOC": "malloc",
        MADE: str(tmp_path),
    }
    for what, version in WATCHED:
        model = model_of(what, "mb", scenario_given("paper-simulation"))
        path = tmp_path / f"wmr_{what}.fmi{version}.fmu"
        write_fmu(model, version, targets_of("host"), path, result=False)
    files = [f"tests/export/fmi/test_fmi_{name}.py" for name in ("hostile", "state", "derivatives")]
    chosen = " or ".join(f"{what}-{version}" for what, version in WATCHED)
    command = f"{sys.executable} -m pytest -q -x -n 0 --timeout 600 -p no:cacheprovider -k".split()
    done = subprocess.run(
        [*command, chosen, *files],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    found = "".join(path.read_text() for path in tmp_path.glob("found.*"))  # pytest keeps stderr
    assert (done.returncode, found) == (0, ""), done.stdout[-3000:] + done.stderr[-3000:]

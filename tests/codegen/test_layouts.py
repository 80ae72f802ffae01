"""Packages in one project or file, and as libraries of Arduino, PlatformIO, ESP-IDF and Zephyr.

ESP-IDF and Zephyr are stubs of their CMake functions here; the others are the tools themselves.
"""

import json
import re
import shlex
import shutil
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.codegen.measured import FILTERS
from tests.codegen.test_package import WARNINGS, needs, run
from tests.commands import flat
from wmr_ctrl.cli import root
from wmr_ctrl.codegen.layouts import VERSION
from wmr_ctrl.codegen.package import CORRIDOR, FILTER, files_of, package_files
from wmr_ctrl.codegen.reference_package import reference_files
from wmr_ctrl.codegen.resources import LAYOUTS
from wmr_ctrl.results import write_all
from wmr_ctrl.theory.corridor import corridor_monitor
from wmr_ctrl.world.scenario import load_scenario, override

SAFE = load_scenario("safe-simulation")
FILTERED = load_scenario("paper-simulation", FILTERS["governor"])
BURGER = load_scenario("turtlebot3-burger")
PACKAGES = {"prox": SAFE, "nn": SAFE, "kanayama": BURGER, FILTER: FILTERED, "reference": SAFE}
GIVEN = {"library.properties", "library.json", "CMakeLists.txt", "idf_component.yml", "module.yml",
         "Kconfig"}  # fmt: skip
"""Names that a tool looks for."""
BOTH = """#include <string.h>
#include "wmr_prox.h"
#include "wmr_filter.h"
int main(void)
{
    static wmr_prox_parameters p;
    static wmr_filter_parameters q;
    wmr_prox_state memory;
    wmr_prox_inputs in;
    wmr_prox_outputs torque;
    wmr_filter_state before;
    wmr_filter_inputs asked;
    wmr_filter_outputs out;
    memset(&in, 0, sizeof in);
    memset(&asked, 0, sizeof asked);
    wmr_prox_defaults(&p), wmr_prox_start(&memory);
    wmr_filter_defaults(&q), wmr_filter_start(&before);
    in.v1_d = asked.v_asked[0] = 1;
    if (sizeof in.x != 8 || sizeof asked.elapsed != 4 || sizeof(wmr_real) != 8) {
        return 1;
    }
    return wmr_prox_step(&p, &memory, &in, &torque) + wmr_filter_step(&q, &before, &asked, &out)
         + (torque.tau_right > 0 ? 0 : 2) + (out.v_sent[0] > 0 ? 0 : 4);
}
"""
PROJECT = """cmake_minimum_required(VERSION 3.16)
project(both C)
set(CMAKE_UNITY_BUILD ON)
add_custom_target(check)
add_custom_target(example)
add_subdirectory(wmr_prox)
add_subdirectory(wmr_filter)
add_executable(both both.c)
target_link_libraries(both wmr_prox wmr_filter)
"""
IDF = """cmake_minimum_required(VERSION 3.10)
project(stub C)
function(idf_component_register)
  cmake_parse_arguments(GIVEN "" "" "SRCS;INCLUDE_DIRS" ${ARGN})
  get_filename_component(name ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  add_library(__idf_${name} STATIC ${GIVEN_SRCS})
  target_include_directories(__idf_${name} PUBLIC ${GIVEN_INCLUDE_DIRS})
  set(COMPONENT_LIB __idf_${name} PARENT_SCOPE)
endfunction()
set(prefix __idf_)
"""
ZEPHYR = """cmake_minimum_required(VERSION 3.10)
project(stub C)
macro(zephyr_library_named name)
  set(ZEPHYR_CURRENT_LIBRARY ${name})
  add_library(${name} STATIC)
endmacro()
function(zephyr_library_sources)
  target_sources(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_include_directories)
  target_include_directories(${ZEPHYR_CURRENT_LIBRARY} PUBLIC ${ARGN})
endfunction()
function(zephyr_library_compile_options)
  target_compile_options(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
"""


@cache
def texts(law, layout, float32=False):
    if law == CORRIDOR:
        still = override(SAFE, {"changes": []})
        return files_of(CORRIDOR, corridor_monitor(still, "prox"), still, layout=layout)
    if law == "reference":
        return reference_files(SAFE, float32=float32, layout=layout)
    return package_files(law, PACKAGES[law], float32=float32, layout=layout)


def written(law, folder, layout=None, float32=False):
    write_all(texts(law, layout, float32), folder / f"wmr_{law}")
    return folder / f"wmr_{law}"


def two_packages(folder, layout=None):
    """A law in double and the filter in single precision."""
    written("prox", folder, layout)
    written(FILTER, folder, layout, float32=True)


def with_main(folder):
    (folder / "both.c").write_text(BOTH, "utf-8")


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("language", ["gcc -std=c99", "g++ -std=c++11 -x c++"])
def test_packages_of_both_precisions_are_in_one_file(language, order, tmp_path):
    """Numbers have the precision of the package that is included first."""
    needs("g++")
    two_packages(tmp_path)
    headers = ['#include "wmr_prox.h"\n', '#include "wmr_filter.h"\n']
    text = BOTH.replace("".join(headers), "".join(headers[::order]))
    real = "sizeof(wmr_real) != "
    (tmp_path / "both.c").write_text(text.replace(f"{real}8", f"{real}{8 if order > 0 else 4}"))
    command = [*language.split(), *WARNINGS[1:], "-Iwmr_prox", "-Iwmr_filter", "-c"]
    run([*command, "both.c", "wmr_prox/wmr_prox.c", "wmr_filter/wmr_filter.c"], tmp_path)
    run(["g++", "both.o", "wmr_prox.o", "wmr_filter.o", "-lm", "-o", "both"], tmp_path)
    run(["./both"], tmp_path)


def test_packages_are_in_one_cmake_project(tmp_path):
    """Its own targets may have the names of a package's, and it may compile the package's sources
    itself.
    """
    needs("cmake", "cc")
    two_packages(tmp_path)
    with_main(tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(PROJECT, "utf-8")
    built(tmp_path)
    run(["build/both"], tmp_path)
    assert not list((tmp_path / "build").glob("wmr_*/check"))


def built(folder):
    run(["cmake", "-S", ".", "-B", "build"], folder)
    run(["cmake", "--build", "build"], folder)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("law", [*PACKAGES, CORRIDOR])
def test_names_of_a_layout_begin_with_the_packages(law, layout):
    files = texts(law, layout)
    assert f"src/wmr_{law}.h" in files
    for place, text in files.items():
        name = place.rpartition("/")[2]
        assert name.startswith(f"wmr_{law}") or name in GIVEN
        for included in re.findall(r'#include "(.*)"', text):
            assert any(own.endswith(f"/{included}") for own in files), (place, included)


@pytest.mark.parametrize("layout", [None, *LAYOUTS])
@pytest.mark.parametrize("law", [*PACKAGES, CORRIDOR])
@pytest.mark.slow_but("prox-None", "reference-arduino", "nn-platformio", "kanayama-esp-idf",
                      "filter-None", "corridor-zephyr")  # fmt: skip
def test_commands_of_the_readme_run_as_written(law, layout, tmp_path):
    needs("cc", "cmake", "ctest")
    folder = written(law, tmp_path, layout)
    (readme,) = folder.glob("*README*")
    blocks = re.findall(r"```sh\n(.*?)```", readme.read_text("utf-8"), re.S)
    lines = [line for block in blocks for line in block.splitlines()]
    assert len(lines) == 1 + (layout is None and law != "reference")
    for line in lines:
        run(["bash", "-e", "-c", line], folder)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_readme_tells_refusal_cost_and_guard(layout):
    for law in [*PACKAGES, CORRIDOR]:
        readme = flat(texts(law, layout)[f"wmr_{law}_README.md"]).lower()
        assert "what to do" in readme
        assert re.search(r"at most \d+ operations", readme)
        acted = {FILTER: "`filter_flags` contains 1", "reference": "", CORRIDOR: ""}
        assert acted.get(law, "the output `guard_acted` is 1") in readme


def test_arduino_builds_the_sketch_with_two_libraries(tmp_path):
    """The tool arduino-builder builds a law's example with the filter for an ATmega2560."""
    libraries = tmp_path / "libraries"
    for law in ("nn", FILTER):
        written(law, libraries, "arduino", float32=True)
    properties = (libraries / "wmr_nn/library.properties").read_text("utf-8")
    assert re.search(r"^name=wmr_nn$", properties, re.M)
    assert re.search(r"^version=\d+\.\d+\.\d+$", properties, re.M)
    needs("arduino-builder", "avr-gcc", "arduino-ctags")
    tools = Path(shutil.which("arduino-builder") or "").parent
    share = tools.parent / "share"
    (sketch,) = (libraries / "wmr_nn").glob("examples/*/*.ino")
    sketch.write_text(f"#include <wmr_filter.h>\n{sketch.read_text('utf-8')}", "utf-8")
    ctags = (share / "arduino-builder/platform.txt").read_text("utf-8")
    pattern = re.search(r"^tools.ctags.pattern=(.*)", ctags, re.M)
    preferences = (
        f"compiler.path={tools}/", "compiler.cpp.extra_flags=-DDECIMAL_DIG=17",
        f"tools.ctags.cmd.path={tools}/arduino-ctags", f"tools.ctags.pattern={pattern[1]}",
    )  # fmt: skip
    words = f"-compile -hardware {share}/arduino/hardware -tools {tools} -libraries {libraries}"
    prefs = [word for item in preferences for word in ("-prefs", item)]
    command = ["arduino-builder", *words.split(), "-fqbn", "arduino:avr:mega:cpu=atmega2560"]
    assert "Sketch uses" in run([*command, *prefs, str(sketch)], tmp_path)


def test_platformio_packs_it_and_the_pack_compiles(tmp_path, monkeypatch):
    """PlatformIO packs it if installed; manifest and sources are tested in any case."""
    needs("cc")
    folder = written("nn", tmp_path, "platformio", float32=True)
    manifest = json.loads((folder / "library.json").read_text("utf-8"))
    assert (manifest["name"], manifest["build"]["flags"]) == ("wmr_nn", ["-ffp-contract=off"])
    needs("cc", "pio")
    monkeypatch.setenv("PLATFORMIO_CORE_DIR", str(tmp_path / "core"))
    run(["pio", "pkg", "pack", "-o", str(tmp_path), str(folder)], tmp_path)
    (pack,) = tmp_path.glob("*.tar.gz")
    shutil.unpack_archive(pack, tmp_path / "packed", filter="data")
    source = tmp_path / "packed" / manifest["build"]["srcDir"]
    units = [source / "wmr_nn.c", tmp_path / "packed/extras/wmr_nn_check.c"]
    run(
        ["cc", "-std=c99", "-ffp-contract=off", f"-I{source}", *units, "-lm", "-o", "check"],
        tmp_path,
    )
    assert "largest error" in run(["./check"], tmp_path)


@pytest.mark.parametrize("layout, stub", [("esp-idf", IDF), ("zephyr", ZEPHYR)])
def test_cmake_of_a_layout_builds_with_stubs_of_its_functions(layout, stub, tmp_path):
    """Two components; the executable stands for the user's application."""
    needs("cmake", "cc")
    two_packages(tmp_path, layout)
    with_main(tmp_path)
    lines = [stub]
    for law in ("prox", FILTER):
        folder = tmp_path / f"wmr_{law}"
        if layout == "esp-idf":
            assert re.search(
                r'version: "\d+\.\d+\.\d+"', (folder / "idf_component.yml").read_text()
            )
            lines.append(f"add_subdirectory(wmr_{law})")
        else:
            option = f"WMR_{law.upper()}"
            told = f"name: wmr_{law}\nbuild:\n  cmake: zephyr\n  kconfig: zephyr/Kconfig\n"
            assert f"config {option}\n" in (folder / "zephyr/Kconfig").read_text("utf-8")
            assert (folder / "zephyr/module.yml").read_text("utf-8") == told
            lines += [f"set(CONFIG_{option} y)", f"add_subdirectory(wmr_{law}/zephyr)"]
    prefix = "__idf_" if layout == "esp-idf" else ""
    linked = " ".join(f"{prefix}wmr_{law}" for law in ("prox", FILTER))
    lines += ["add_executable(both both.c)", f"target_link_libraries(both {linked} m)"]
    (tmp_path / "CMakeLists.txt").write_text("\n".join(lines), "utf-8")
    built(tmp_path)
    run(["build/both"], tmp_path)
    flags = [path.read_text("utf-8") for path in (tmp_path / "build").rglob("flags.make")]
    assert sum("ffp-contract=off" in text for text in flags) == 2


def test_a_layout_needs_a_folder_of_its_own(tmp_path):
    words = f"codegen LAW --scenario turtlebot3-burger --layout zephyr --out {tmp_path / 'libs'}"
    for law, code in ((FILTER, 0), (FILTER, 0), ("kanayama", 2)):
        done = CliRunner().invoke(root, shlex.split(words.replace("LAW", law)))
        assert done.exit_code == code, done.output
    assert "wmr_kanayama" in done.output
    assert not (tmp_path / "libs/src/wmr_kanayama.h").exists()
    assert re.fullmatch(r"\d+\.\d+\.\d+", VERSION)

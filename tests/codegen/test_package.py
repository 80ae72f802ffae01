"""The stand-alone C packages: they build anywhere, compute the law, and need nothing."""

import re
import shutil
from dataclasses import replace

import casadi as ca
import pytest

from tests.codegen import measured
from tests.codegen.packages import write_package
from tests.commands import finished
from tests.languages import compile_all
from wmr_ctrl.codegen.package import footprint_key, known_footprint, package_files
from wmr_ctrl.codegen.single_precision import MARGIN
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.world.scenario import load_scenario

SCENARIO = load_scenario("paper-simulation")
WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
HASH = re.compile(r'(?<=scenario_hash\[17\] = ")[0-9a-f]{16}')


def run(command, folder):
    return finished(command, cwd=folder).stdout


def needs(*tools):
    absent = [tool for tool in tools if shutil.which(tool) is None]
    if absent:
        pytest.skip(f"NOT RUN: {', '.join(absent)} not on this machine")


def written(law, folder, float32, guarded=False):
    write_package(law, folder, load_scenario(measured.SCENARIOS[guarded]), float32=float32)


def programs(law, folder, compiler="gcc"):
    """Build a package's check and example without a warning; return what they print."""
    needs(compiler)
    command = [compiler, *WARNINGS, "-O2", "-ffp-contract=off"]
    run([*command, "-Wdouble-promotion", "-c", f"wmr_{law}.c"], folder)
    for program in ("check", "example"):
        run([*command, f"{program}.c", f"wmr_{law}.o", "-lm", "-o", program], folder)
    return [run([f"./{program}"], folder) for program in ("check", "example")]


@pytest.mark.parametrize(
    "law, float32, guarded, compiler",
    [
        ("nn", False, False, "gcc"),
        ("mb", True, True, "gcc"),
        ("pursuit", False, True, "clang"),
    ],
)
@pytest.mark.slow_but("nn-False-False-gcc")
def test_vectors_pass_and_nothing_warns(law, float32, guarded, compiler, tmp_path):
    written(law, tmp_path, float32, guarded)
    checked, example = programs(law, tmp_path, compiler)

    assert "largest error" in checked
    distance = float(example.split()[1])
    assert distance < (0.3 if law == "pid" else 0.1)  # pid hangs behind with gains for prox


@pytest.mark.parametrize(
    "law, language, float32",
    [
        ("pid", "gcc-c99", False),
        ("mb", "clang-c99", False),
        ("nn", "g++-c++98", False),
        ("kanayama", "clang++-c++11", True),
        ("prox", "tcc", True),
    ],
)
@pytest.mark.slow_but("pid-gcc-c99-False", "mb-clang-c99-False")
def test_it_is_c_and_cpp_for_every_compiler(law, language, float32, tmp_path):
    written(law, tmp_path, float32)
    compile_all(language, tmp_path, [f"wmr_{law}.c", "example.c", "check.c"])


@pytest.mark.parametrize(
    "law, float32, guarded", [("pid", True, False), ("mb", True, True), ("prox", False, False)]
)
@pytest.mark.slow_but("pid-True-False")
def test_a_microcontroller_takes_it(law, float32, guarded, tmp_path):
    needs(measured.COMPILER)
    written(law, tmp_path, float32, guarded)
    for unit in (f"wmr_{law}.c", "example.c", "check.c"):
        run([measured.COMPILER, *WARNINGS, "-O2", *measured.TARGET, "-c", unit], tmp_path)
    listed = run(["arm-none-eabi-nm", f"wmr_{law}.o"], tmp_path).splitlines()
    symbols = [line.split()[-2:] for line in listed]
    wanted = {name for kind, name in symbols if kind == "U"}
    support = {name for name in wanted if name.startswith("__aeabi_")}
    readme = (tmp_path / "README.md").read_text("utf-8")
    (told,) = re.findall(r"from the C library: ([^.]*)\.", readme)

    assert not {kind for kind, _ in symbols} & set("BbDdCS"), "writable data"
    assert wanted - support <= set(told.replace("\n ", "").split(", "))
    assert not (float32 and "__aeabi_d" in str(support)), "double arithmetic"


@pytest.mark.parametrize(
    "law, float32, preset",
    [
        ("pid", True, measured.SCENARIOS[False]), ("mb", True, measured.SCENARIOS[True]),
        ("prox", False, "robot-10ms"), ("nn", False, "robot-100ms"),
    ],
)  # fmt: skip
@pytest.mark.slow_but("pid-True-paper-simulation")
def test_documented_footprint_holds(law, float32, preset, tmp_path):
    """Renew by ``python -m tests.codegen.measured`` and look at the difference."""
    needs(measured.COMPILER)
    found = measured.sizes(law, float32, preset, tmp_path)
    told = known_footprint(law, float32, preset != measured.SCENARIOS[False], found.operations)
    readme = (tmp_path / "README.md").read_text("utf-8")

    assert found.code <= 1.1 * told.code
    assert found.data == told.data == 0
    assert found.stack <= 1.1 * told.stack + 32
    if preset in measured.ROBOTS:
        assert f"at most {told.stack} bytes of stack" in readme
        assert "instructions a sample" not in readme
    else:
        assert f"{told.deepest} bytes" in readme


def test_another_kernel_does_not_borrow_a_footprint():
    late = load_scenario("safe-simulation", {"actuator.lag": 0.02})

    assert "Cortex" in package_files("mb", SCENARIO)["README.md"]
    assert "were not measured" in package_files("mb", late)["README.md"]


@pytest.mark.parametrize("law, float32", measured.COPIES)
def test_committed_copy_is_what_is_generated(law, float32):
    """Renew by ``python -m tests.codegen.measured`` and look at the difference.

    A new key of scenarios changes the hash alone, for which nothing has to be renewed.
    """
    version = (measured.GOLDEN / measured.VERSION).read_text("utf-8").strip()
    if version != ca.__version__:
        pytest.skip(f"NOT RUN: the copy was made with casadi {version}, whose order may differ")
    folder = measured.GOLDEN / footprint_key(law, float32)
    for name, text in package_files(law, SCENARIO, float32=float32).items():
        copy = (folder / name).read_text("utf-8")
        assert HASH.sub("", copy) == HASH.sub("", text), name


@pytest.mark.parametrize(
    "law, guarded",
    [("prox", False), ("nn", True), ("pid", True), ("mb", False), ("kanayama", False)],
)
@pytest.mark.slow_but("prox-False", "nn-True")
def test_every_member_says_unit_and_meaning(law, guarded):
    files = package_files(law, load_scenario(measured.SCENARIOS[guarded]), float32=True)
    lines = files[f"wmr_{law}.h"].splitlines()
    members = [line for line in lines if line.startswith("    wmr_real")]

    assert len(members) > 20
    assert all("[" in line.partition("/*")[2] or "nothing" in line for line in members)
    assert len(files["example.c"].splitlines()) <= 46
    assert len(files["README.md"].splitlines()) <= 75


def test_one_file_that_cannot_be_written_leaves_none_of_the_others(tmp_path):
    (tmp_path / "check.c").mkdir()

    with pytest.raises(ResultFileError, match=r"check\.c"):
        write_package("mb", tmp_path, SCENARIO)

    assert [path.name for path in tmp_path.iterdir()] == ["check.c"]


@pytest.mark.parametrize(
    "name", ["two\nlines", "a */ int x; /*", 'a "b" \\', "a ```\n# b", "<b>&", "a\u2028b"]
)
@pytest.mark.slow_but("a */ int x; /*", "a\\u2028b")
def test_a_name_of_a_scenario_stands_in_comments_alone(name):
    plain, named = (package_files("mb", replace(SCENARIO, name=each)) for each in ("wmr", name))
    assert sum(plain[file] != named[file] for file in plain) == 2
    for file, text in plain.items():
        assert len(text.splitlines()) == len(named[file].splitlines())
        assert text.count("`") == named[file].count("`")
        code, other = (re.sub(r"(?s)/\*.*?\*/", "", item) for item in (text, named[file]))
        assert code == other


def test_guarded_limits_leave_room_for_the_rounding_of_a_float():
    guarded = load_scenario(measured.SCENARIOS[True])
    for scenario, float32, share in (
        (guarded, True, 1 - MARGIN), (guarded, False, 1.0), (SCENARIO, True, 1.0)
    ):  # fmt: skip
        text = package_files("mb", scenario, float32=float32)["wmr_mb.c"]
        told = re.findall(r"limits_v_u1\[\d\] = ([\d.]+)f?;", text)
        assert [*map(float, told)] == [share, 1.5 * share]

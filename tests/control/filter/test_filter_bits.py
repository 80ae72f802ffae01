"""The command filter's package has the same bits on every platform, odd inputs included."""

from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tests.bits.platforms import HERE as BESIDE
from tests.bits.platforms import check_tools, ran
from tests.bits.test_same_bits import ELSEWHERE, HERE_NOW
from tests.codegen.measured import FILTERS
from tests.compilers import FLAGS, compile_program
from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.world.scenario import load_scenario

PLATFORMS = {item.name: item for item in (*HERE_NOW, *ELSEWHERE)}
PROGRAM = Path(__file__).with_name("bits.c")


@cache
def written(name, float32):
    scenario = load_scenario("paper-simulation", FILTERS[name])
    return package_files("filter", scenario, float32=float32)


def shown(platform, name, folder, float32=False):
    """Digest of all that the filter sends and stores."""
    runner = check_tools(platform)
    for file, text in written(name, float32).items():
        (folder / file).write_text(text, encoding="utf-8")
    kind = load_scenario("paper-simulation", FILTERS[name]).filter.kind
    governs = ["-DGOVERNS"] if kind == "governor" else []
    command = [*platform.command, *FLAGS, *governs, f"-I{folder}", f"-I{BESIDE}"]
    out = folder / f"filtered{platform.suffix}"
    compile_program(folder, command, [str(PROGRAM), str(folder / "wmr_filter.c")], str(out))
    return sha256(ran([*runner, str(out)], folder)).hexdigest()


@cache
def here(name, float32=False):
    with TemporaryDirectory() as folder:
        return shown(PLATFORMS["gcc -O2"], name, Path(folder), float32)


@pytest.mark.parametrize("name", ["clip", "band of 50 commands"])
@pytest.mark.slow_but("clip")
def test_compilers_agree(name, tmp_path):
    assert shown(PLATFORMS["clang -O3"], name, tmp_path) == here(name)


@pytest.mark.parametrize("name", ["clip", "band of 50 commands"])
@pytest.mark.slow_but("clip")
def test_compilers_agree_in_single_precision(name, tmp_path):
    found = shown(PLATFORMS["clang -O3"], name, tmp_path, float32=True)
    assert found == here(name, float32=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    "platform, name",
    [
        ("gcc -O3 native", "clip"),
        ("clang -O3", "clip of slow commands"),
        ("zig -O3", "band of 50 commands"),
        ("aarch64", "governor, delay of 0 to 30 ms"),
        ("wasm", "governor"),
    ],
)
def test_platforms_agree(platform, name, tmp_path):
    assert shown(PLATFORMS[platform], name, tmp_path) == here(name)

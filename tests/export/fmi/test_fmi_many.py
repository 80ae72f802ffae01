"""Many instances, many threads, odd places, and no growth."""

import ctypes as ct
import resource
import shutil
from concurrent.futures import ThreadPoolExecutor

import pytest
from fmpy import simulate_fmu

from tests.export.fmi.cases import both
from tests.export.fmi.raw import CS, OK


def driven(one, steps):
    """Final values after some steps."""
    for k in range(steps):
        assert one.step(0.01 * k, 0.01) == OK
    return one.all()


@both
@pytest.mark.parametrize("what", ["plant", "nn", "closed-loop"])
@pytest.mark.slow_but("plant-3", "nn-2", "closed-loop-3")
def test_eight_threads(raw, what, version):
    fmu = raw(what, version)
    wanted = driven(fmu.new().begin(), 200)
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: driven(fmu.new().begin(), 200), range(16)))
    assert found == [wanted] * 16


@both
@pytest.mark.parametrize("folder", ["Ordner für Räder", "日本 語", "it's (odd) #1 & more"])
def test_odd_paths(exported, tmp_path, folder, version):
    place = tmp_path / folder
    place.mkdir()
    path = shutil.copy(exported("plant", version), place / "my plant é.fmu")
    assert len(simulate_fmu(str(path), stop_time=0.1, output_interval=0.01)) == 11


@both
@pytest.mark.parametrize("what", ["plant", "nn", "closed-loop"])
def test_instances_and_states_come_and_go_without_growth(raw, what, version):
    fmu = raw(what, version)
    one = fmu.new().begin()

    def cycles(count):
        for k in range(count):
            fmu.FreeInstance(ct.c_void_p(fmu.instantiate(CS)))
            if k % 5 == 0:
                assert one.restore(one.bytes_of_state()) == OK
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = cycles(1000)
    assert cycles(10_000) - before < 1024  # KiB; a single leaked instance each would be 10 MB

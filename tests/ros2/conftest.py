"""A Python with ROS 2, made from wheels; elsewhere NOT RUN."""

from __future__ import annotations

import json
import os
import platform
import signal
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.commands import finished
from wmr_ctrl.ros2.c_node import LINKED, NAME, node_settings, write_node
from wmr_ctrl.world.scenario import load_scenario

HERE, ROOT = Path(__file__).parent, Path(__file__).parents[2]
AT_ONCE = 3
"""Scripts that run beside each other; each keeps less than half a processor busy."""
SLACK, TICK = 0.15, 0.02
"""Time [s] that DDS may take, beside time-outs and ticks; a tick of the nodes that are tested."""
OVER_DDS = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="NOT RUN: no wheels"
)


@pytest.fixture(scope="session")
def ros(request):
    """A Python with ROS 2, which also sees this environment's packages.

    The wheels restart every interpreter of their environment with libraries of their own, so they
    are never installed into this one.  It is made once and kept in pytest's cache folder, for all
    processes and later runs.
    """
    from tests.ros2.environment import made  # it has locks that Windows has not

    folder, problem = made(Path(request.config.cache.mkdir("ros2")))
    if problem:
        pytest.skip(f"NOT RUN: the wheels of ROS 2 cannot be installed: {problem}")
    (site,) = folder.glob("lib/python*/site-packages")
    paths = [path for path in sys.path if path.endswith("site-packages")]
    (site / "zz_here.pth").write_text("\n".join([*paths, str(ROOT)]), "utf-8")
    return folder / "bin" / "python"


@dataclass(frozen=True)
class Job:
    """A script of this folder around a node: ``python SCRIPT SCENARIO *words [NODE]``.

    ``scenario`` is a text; ``rows`` are written to a file, whose path replaces the word {rows}.
    ``compiled`` are the settings of the C node that replaces the Python one.
    """

    script: str
    scenario: str
    words: tuple[str, ...] = ()
    compiled: tuple[str, ...] | None = None
    rows: object = None


def in_both(script, scenario, words=(), compiled=(), rows=None):
    """The job with either node, by a word for it."""
    settings = (*compiled, "discovery_time=0.0")
    return {
        "Python": Job(script, scenario, words, None, rows),
        "C": Job(script, scenario, words, settings, rows),
    }


@pytest.fixture(scope="session")
def report(request, ros, tmp_path_factory):
    """The JSON that a job prints, by its name in a module's JOBS.

    Nodes and scripts mostly wait.  So the jobs of all modules under test run AT_ONCE, each in a
    separate domain, as soon as the first one is requested.
    """
    modules = dict.fromkeys(item.module for item in request.session.items)
    made = [module.JOBS() for module in modules if hasattr(module, "JOBS")]
    jobs = {name: job for some in made for name, job in some.items()}
    assert len(jobs) == sum(map(len, made))
    folder, running = tmp_path_factory.mktemp("jobs"), set()

    def run(place, job):
        home = folder / str(place)
        home.mkdir()
        return report_of(job, ros, environment_of(place), home, running)

    with ThreadPoolExecutor(AT_ONCE) as pool:
        reports = {name: pool.submit(run, k, job) for k, (name, job) in enumerate(jobs.items())}
        try:
            yield lambda name: reports[name].result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in list(running):
                process.send_signal(signal.SIGINT)  # a script kills its nodes


def environment_of(place=0):
    """Environment in which no other machine and no other test hears these nodes."""
    local = {"ROS_DOMAIN_ID": str(1 + (os.getpid() + place) % 100)}
    return {**os.environ, **local, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@pytest.fixture(scope="session")
def environment():
    """Environment for nodes beside the jobs."""
    return environment_of(-1)


def report_of(job, ros, environment, folder, running):
    """JSON that a job's script prints."""
    path = folder / "base.toml"
    path.write_text(job.scenario, "utf-8")
    (folder / "rows.json").write_text(json.dumps(job.rows), "utf-8")
    words = [word.format(rows=folder / "rows.json") for word in job.words]
    if job.compiled is not None:
        words.append(str(built_node(load_scenario(path), job.compiled, ros, folder / "c")))
    with subprocess.Popen(
        [ros, HERE / job.script, path, *words],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        running.add(process)
        said, cried = process.communicate(timeout=1800)
        running.discard(process)
    assert process.returncode == 0, said[-500:] + cried[-2000:]
    return json.loads(said)


def with_python():
    """Words for a linker, since the wheels' librcl needs libpython."""
    python, shared = sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("LDLIBRARY")
    yield from ("-Wl,--allow-shlib-undefined,--no-as-needed", f"-Wl,-rpath,{python}")
    yield f"{python}/{shared}"


def built_node(scenario, settings, ros, folder):
    """The filter as a node in C, compiled with the headers and libraries of the wheels."""
    write_node(folder, scenario, node_settings(settings))
    prefix, out = ros.parent.parent, folder / NAME
    units = [path.name for path in folder.glob("*.c")]
    places = [f"-I{path}" for path in (prefix / "include").iterdir()]
    links = [*with_python(), f"-L{prefix}/lib", *LINKED, "-lm"]
    flags = ["-std=gnu11", "-O0", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
    command = ["cc", *flags, *places, *units, "-o", str(out), *links]
    finished(command, cwd=folder)
    return out


def bar(found, seconds):
    """Latest time [s] of a reaction: its time, two ticks (or two silences of a busy machine)."""
    return seconds + 2 * max(TICK, found["silence"]) + SLACK

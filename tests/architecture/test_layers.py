"""Allowed imports between rooms, as docs/architecture.md states them."""

import ast
import re
import sys

from tests.architecture.tree import ROOT, modules, nodes_of, offenders, room_of

ORDER = (
    "version", "core", "results", "world", "control", "codegen", "theory", "simulation",
    "identification", "report", "export", "api", "extend", "__init__", "ros2", "cli", "__main__",
)  # fmt: skip
"""Rooms and files of wmr_ctrl: each imports from those before it."""
UPWARD = {}
"""Imports for typing alone that go upward, by module, with a comment that says why."""
ROS_MESSAGES = {
    "diagnostic_msgs", "geometry_msgs", "nav_msgs", "nav2_msgs", "rcl_interfaces", "sensor_msgs",
    "std_msgs", "std_srvs",
}  # fmt: skip
THIRD_PARTY = {
    "version": set(),
    "core": {"casadi", "yaml"},
    "results": {"lazy_loader", "numpy", "rosbags"},
    "world": {"casadi", "lazy_loader", "lxml", "numpy", "scipy", "tomlkit", "xacro"},
    "control": {"casadi", "numpy"},
    "codegen": {"casadi", "filelock", "jinja2", "numpy", "platformdirs"},
    "theory": {"casadi", "control", "flint", "lazy_loader", "numpy", "scipy"},
    "simulation": {"cma", "filelock", "jinja2", "mujoco", "numpy", "scipy"},
    "identification": {"casadi", "numpy", "scipy", "tomlkit"},
    "report": {"PIL", "jinja2", "matplotlib", "numpy"},
    "export": {"casadi", "fmpy", "lxml", "numpy"},
    "api": set(),
    "extend": {"lazy_loader"},
    "ros2": {"jinja2", "numpy", "rclpy", *ROS_MESSAGES},
    "__init__": {"lazy_loader"},
    "__main__": set(),
    "wmr_proofs": {"casadi", "flint", "numpy", "scipy", "z3"},
}
"""What each room may import from elsewhere; the command line (cli) may import anything."""
JOINERS = {"simulation", "api", "cli", "export"}
"""Rooms that may both compile and run."""
ONLY_RUNS = "wmr_ctrl.simulation."
BUILDS = tuple(ONLY_RUNS + name for name in ("engines", "campaign", "physics", "tuning"))
"""Modules of the room of runs that may have a loop built; all others are handed one."""
LEDGER = "wmr_ctrl.results.ledger"
LIGHT = ("wmr_ctrl.core.errors", "wmr_ctrl.core.signals")


def rank(room):
    assert room in ORDER, f"wmr_ctrl/{room} is in no place: add it to docs/architecture.md and here"
    return ORDER.index(room)


def own_imports(module, *, typing=False):
    return [name for name in module.imports(typing=typing) if name.split(".")[0] == "wmr_ctrl"]


def foreign_imports(module):
    tops = {name.split(".")[0] for name in module.imports()}
    return tops - {"wmr_ctrl", "wmr_proofs", "__future__"} - sys.stdlib_module_names


def rooms_used(module):
    return {room_of(name) for name in own_imports(module)}


def in_package():
    return [module for module in modules() if module.room != "wmr_proofs"]


def test_imports_come_from_rooms_below():
    """Imports only for annotations count, too."""
    above = {
        module.name: {
            name
            for name in own_imports(module, typing=True)
            if room_of(name) != module.room and rank(room_of(name)) >= rank(module.room)
        }
        - UPWARD.get(module.name, set())
        for module in in_package()
    }

    assert {name: wrong for name, wrong in above.items() if wrong} == {}


def test_no_import_goes_from_the_package_to_its_proofs():
    """One module in `theory` finds wmr_proofs by name."""

    def imported(module):
        return [x for x in module.imports(typing=True) if x.split(".")[0] == "wmr_proofs"]

    def named(module):
        texts = (getattr(node, "value", "") for node in nodes_of(module.tree))
        return [x for x in texts if isinstance(x, str) and re.match(r"wmr_proofs[^ ]*$", x)]

    assert {name for name in offenders(imported) if name.startswith("wmr_ctrl")} == set()
    doors = {name for name in offenders(named) if name.startswith("wmr_ctrl")}
    assert doors == {"wmr_ctrl.theory.door"}


def test_files_of_a_folder_import_each_other_relatively():
    def absolute(module):
        folder = ".".join(module.path.parent.relative_to(ROOT).parts)
        if folder == "wmr_ctrl":  # its files stand beside the rooms and name them in full
            return []
        nodes = (node for node in nodes_of(module.tree) if isinstance(node, ast.ImportFrom))
        named = [node.module or "" for node in nodes if not node.level]
        return [name for name in named if name == folder or name.startswith(f"{folder}.")]

    assert offenders(absolute) == {}


def test_no_file_imports_itself_by_way_of_others():
    """Imports within functions count; imports only for annotations do not."""
    edges = {module.name: {*module.imports()} - {module.name} for module in modules()}
    ours = {name: {other for other in used if other in edges} for name, used in edges.items()}

    assert circle(ours) == []


def circle(edges):
    """Sorted names on cycles of a graph, and names between two cycles; usually none."""
    left = set(edges)
    while True:
        used = {name for other in left for name in edges[other]}
        inner = {name for name in left if edges[name] & left and name in used}
        if inner == left:
            return sorted(left)
        left = inner


def test_third_party_imports_are_those_of_the_room():
    def foreign(module):
        return foreign_imports(module) - THIRD_PARTY.get(module.room, set())

    assert {k: v for k, v in offenders(foreign).items() if not k.startswith("wmr_ctrl.cli")} == {}


def test_tests_notebooks_and_benchmarks_are_not_imported():
    outside = {"tests", "analysis", "benchmarks", "fmu"}

    assert offenders(lambda module: foreign_imports(module) & outside) == {}


def test_few_rooms_join_compiling_and_running():
    def joins(module):
        both = rooms_used(module) >= {"codegen", "simulation"}
        return ["codegen with simulation"] if both and module.room not in JOINERS else []

    assert {k: v for k, v in offenders(joins).items() if not k.startswith("wmr_proofs")} == {}


def test_runs_are_handed_their_kernels():
    graphs = {"control", "codegen", "theory"}

    def builds(module):
        runs = module.name.startswith(ONLY_RUNS) and not module.name.startswith(BUILDS)
        return rooms_used(module) & graphs if runs else set()

    assert offenders(builds) == {}


def test_the_report_runs_nothing():
    jobs = {"run_campaign", "run_cases", "run_comparison", "run_study", "simulate", "run_each"}

    def runs(module):
        if module.room != "report":
            return set()
        named = {node.id for node in nodes_of(module.tree) if isinstance(node, ast.Name)}
        return (rooms_used(module) & {"codegen", "export"}) | (named & jobs)

    assert offenders(runs) == {}


def test_the_ledger_needs_the_standard_library_alone():
    def heavy(module):
        return foreign_imports(module) | rooms_used(module) if module.name == LEDGER else set()

    assert offenders(heavy) == {}


def test_methods_of_proof_stand_alone():
    """Methods know graphs, not robots, so they cannot depend on the code that they judge."""
    parts = ("methods", "graph", "relation", "statement", "regions")
    allowed = (
        *(f"wmr_proofs.{part}" for part in parts),
        "wmr_ctrl.world.model.graph",
        "wmr_ctrl.core.errors",
        LEDGER,
    )

    def ours(module):
        if not module.name.startswith(allowed[: len(parts)]):
            return []
        own = (name for name in module.imports() if name.split(".")[0].startswith("wmr_"))
        return [name for name in own if not name.startswith(allowed)]

    assert offenders(ours) == {}


def test_the_oracle_shares_no_code_with_what_it_checks():
    """Only its package, which makes a Run of the oracle's results, imports more."""
    allowed = (
        "wmr_ctrl.core.fields",
        "wmr_ctrl.world.scenario",
        "wmr_ctrl.results",
        *LIGHT,
    )
    folder = ROOT / "tests" / "oracle"
    files = [path for path in folder.glob("*.py") if not path.name.startswith(("__", "test_"))]
    imported = {
        name
        for path in files
        for line in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(line, ast.ImportFrom) and (name := line.module or "").startswith("wmr_")
    }

    assert len(files) > 20
    assert sorted(name for name in imported if not name.startswith(allowed)) == []


def test_architecture_page_has_the_order():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rooms = [name for name in ORDER if (ROOT / "wmr_ctrl" / name).is_dir()]

    assert " → ".join(rooms) in " ".join(page.split())

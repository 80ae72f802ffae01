"""Who may import whom, as docs/architecture.md says it."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Mapping

from tests.architecture.tree import ROOT, Module, layer_of, modules, nodes_of, offenders

EVERYWHERE = {"errors", "signals", "symbolic", "compiled", "late_bound"}
"""Open to all; they import nothing of ours but each other."""
ORDER = (
    {"fields", "paper"},
    {"results"},
    {"model"},
    {"world"},
    {"scenario"},
    {"logs"},
    {"barrier"},
    {"laws"},
    {"guard"},
    {"filter"},
    {"control"},
    {"codegen"},
    {"checks"},
    {"sim"},
    {"proofs", "linear", "corridor"},
    {"fmi", "modelica", "simulink", "physics"},
    {"engines"},
    {"campaign"},
    {"report"},
    {"page"},
    {"api_types", "outputs"},
    {"api"},
    {"tuning", "identification"},
    {"__init__"},
    {"ros2"},
    {"cli"},
    {"__main__"},
)
ROS_MESSAGES = {
    "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rcl_interfaces", "std_msgs", "std_srvs",
}  # fmt: skip
THIRD_PARTY = {
    "errors": set(),
    "signals": set(),
    "symbolic": {"casadi"},
    "compiled": set(),
    "late_bound": set(),
    "paper": set(),
    "results": {"numpy", "rosbags"},
    "fields": set(),
    "model": {"casadi", "numpy"},
    "world": {"numpy", "scipy", "yaml"},
    "scenario": {"tomlkit"},
    "logs": {"numpy"},
    "barrier": {"casadi"},
    "laws": {"casadi"},
    "guard": {"casadi"},
    "filter": {"casadi", "numpy"},
    "control": {"casadi"},
    "codegen": {"casadi", "filelock", "jinja2", "numpy", "platformdirs"},
    "checks": {"casadi", "numpy"},
    "sim": {"numpy"},
    "proofs": {"casadi", "flint", "z3"},
    "linear": {"casadi", "control", "numpy", "scipy"},
    "corridor": {"casadi", "flint", "numpy"},
    "physics": {"jinja2", "mujoco", "numpy"},
    "fmi": {"casadi", "fmpy", "numpy"},
    "modelica": {"casadi"},
    "simulink": set(),
    "campaign": {"filelock", "numpy", "scipy"},
    "report": {"PIL", "jinja2", "matplotlib", "numpy"},
    "page": set(),
    "api_types": set(),
    "api": set(),
    "tuning": {"cma", "numpy"},
    "identification": {"casadi", "numpy", "scipy", "tomlkit"},
    "engines": set(),
    "outputs": set(),
    "ros2": {"numpy", "rclpy", *ROS_MESSAGES},
    "__init__": set(),
    "__main__": set(),
}
"""What each layer may import from elsewhere; the command line (cli) may import anything."""
JOINERS = {"engines", "api", "tuning", "cli", "fmi"}
"""Who may both compile and run: the interface, and the co-simulation that is compared with it."""
LEDGER = "wmr_ctrl.results.ledger"
LIGHT = ("wmr_ctrl.core.errors", "wmr_ctrl.core.signals")


def rank(layer: str) -> int:
    places = [place for place, layers in enumerate(ORDER) if layer in layers]
    assert places, f"wmr_ctrl/{layer} is in no layer: add it to docs/architecture.md and here"
    return places[0]


def own_imports(module: Module) -> list[str]:
    return [name for name in module.imports() if name.split(".")[0] == "wmr_ctrl"]


def foreign_imports(module: Module) -> set[str]:
    tops = {name.split(".")[0] for name in module.imports()}
    return tops - {"wmr_ctrl", "__future__"} - sys.stdlib_module_names


def layers_used(module: Module) -> set[str]:
    return {layer_of(name) for name in own_imports(module)}


def test_imports_come_from_layers_below():
    def above(module: Module) -> list[str]:
        if module.layer in EVERYWHERE:
            return [name for name in own_imports(module) if layer_of(name) not in EVERYWHERE]
        return [
            name
            for name in own_imports(module)
            if layer_of(name) not in {module.layer, *EVERYWHERE}
            and rank(layer_of(name)) >= rank(module.layer)
            and name != "wmr_ctrl"  # the version
        ]

    assert offenders(above) == {}


def test_no_file_imports_itself_by_way_of_others():
    """Imports within functions count; what only annotations need does not."""
    edges = {module.name: {*own_imports(module)} - {module.name} for module in modules()}

    assert circle(edges) == []


def circle(edges: Mapping[str, set[str]]) -> list[str]:
    """Names on circles of a graph, sorted, and what lies between circles; often none."""
    left = set(edges)
    while True:
        used = {name for other in left for name in edges[other]}
        inner = {name for name in left if edges[name] & left and name in used}
        if inner == left:
            return sorted(left)
        left = inner


def test_circles_are_seen():
    assert circle({"a": {"b"}, "b": {"c", "d"}, "c": set(), "d": {"c"}}) == []
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set()}) == ["b", "c"]


def test_third_party_imports_are_those_of_the_layer():
    def foreign(module: Module) -> set[str]:
        return foreign_imports(module) - THIRD_PARTY.get(module.layer, set())

    assert {k: v for k, v in offenders(foreign).items() if not k.startswith("wmr_ctrl.cli")} == {}


def test_tests_notebooks_and_benchmarks_are_not_imported():
    outside = {"tests", "analysis", "benchmarks", "fmu"}

    assert offenders(lambda module: foreign_imports(module) & outside) == {}


def test_only_the_api_joins_compiling_and_running():
    def joins(module: Module) -> list[str]:
        both = layers_used(module) >= {"codegen", "sim"}
        return ["codegen with sim"] if both and module.layer not in JOINERS else []

    assert offenders(joins) == {}


def test_runs_are_handed_their_kernels():
    graphs = {"model", "barrier", "laws", "guard", "control", "codegen", "checks"}

    def builds(module: Module) -> set[str]:
        return layers_used(module) & graphs if module.layer == "sim" else set()

    assert offenders(builds) == {}


def test_the_report_runs_nothing():
    running = {"codegen", "sim", "fmi"}
    jobs = {"run_campaign", "run_cases", "run_comparison", "run_study", "simulate", "run_each"}

    def runs(module: Module) -> set[str]:
        if module.layer != "report":
            return set()
        named = {node.id for node in nodes_of(module.tree) if isinstance(node, ast.Name)}
        return (layers_used(module) & running) | (named & jobs)

    assert offenders(runs) == {}


def test_report_reads_proofs_through_the_ledger_only():
    def proofs(module: Module) -> list[str]:
        used = [name for name in own_imports(module) if layer_of(name) == "proofs"]
        return [name for name in used if module.layer == "report" and name != LEDGER]

    def heavy(module: Module) -> set[str]:
        if module.name != LEDGER:
            return set()
        return foreign_imports(module) | (layers_used(module) - EVERYWHERE)

    assert offenders(proofs) == {}
    assert offenders(heavy) == {}


def test_methods_of_proof_stand_alone():
    """They know graphs, not robots: what they decide cannot lean on the code that they judge."""
    parts = ("methods", "graph", "relation", "statement", "ledger", "regions")

    def ours(module: Module) -> list[str]:
        top = module.name.removeprefix("wmr_proofs.").split(".")[0]
        if module.layer != "proofs" or top not in parts:
            return []
        allowed = tuple(f"wmr_proofs.{part}" for part in parts)
        own = (*allowed, "wmr_ctrl.world.model.graph", "wmr_ctrl.core.errors")
        return [name for name in own_imports(module) if not name.startswith(own)]

    assert offenders(ours) == {}


def test_the_oracle_shares_no_code_with_what_it_checks():
    """Its package alone, which makes a Run of what the oracle computed, uses more."""
    sections = (
        "spline",
        "rounded_square",
        "speed_profile",
        "waypoints",
    )  # the fitted path of a section, as data
    allowed = (
        "wmr_ctrl.core.fields",
        "wmr_ctrl.world.scenario",
        "wmr_ctrl.results",
        *(f"wmr_ctrl.world.references.{name}" for name in sections),
        *LIGHT,
    )

    folder = ROOT / "tests" / "oracle"
    files = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    imported = {
        name
        for path in files
        for line in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(line, ast.ImportFrom) and (name := line.module or "").startswith("wmr_ctrl")
    }

    assert len(files) > 20
    assert sorted(name for name in imported if not name.startswith(allowed)) == []


def test_laws_and_plants_are_built_into_systems():
    """One type at the arrow: every ``build`` of a law takes a Sample and returns a System."""
    built = [
        (module.name, ast.unparse(node.args.args[0].annotation or node), ast.unparse(node.returns))
        for module in modules()
        if module.layer == "laws"
        for node in module.tree.body
        if isinstance(node, ast.FunctionDef) and node.name == "build" and node.returns
    ]

    assert len(built) >= 4
    assert {(given, returned) for _, given, returned in built} == {("LawContext", "System")}


def test_every_engine_returns_a_run():
    """One type at the arrow: what the interface simulates is a Run, or many of them."""
    api = next((module for module in modules() if module.name == "wmr_ctrl.api"), None)
    assert api is not None
    returned = {
        node.name: ast.unparse(node.returns)
        for node in api.tree.body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("simulate") and node.returns
    }

    assert returned["simulate"] == "Run"
    assert all("Run" in annotation for annotation in returned.values())


def test_architecture_page_names_every_layer():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    order = next(line for line in page.splitlines() if line.startswith("fields, paper |"))
    steps = [set(re.findall(r"\w+", step)) for step in order.split("|")]

    assert steps == [layers for layers in ORDER if layers != {"__init__"}]
    assert all(f"`wmr_ctrl/{layer}" in page for layers in ORDER for layer in layers)

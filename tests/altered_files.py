"""Alterations of the product's text that tests have to notice: world, emitter, C runtime, checks.

What the ledger proves is altered in memory (`tests.alterations`); here a copy of the tree has one
place of one file altered, and the tests that are named beside it run on the copy, or after the word
``prove`` the entries of the ledger.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
COPIED = ("wmr_ctrl", "wmr_proofs", "fmu", "tests", "pyproject.toml")
PROVE = "prove "
PATIENCE = 300
"""Seconds for the tests of one alteration."""
EMITTER = "tests/codegen/test_emit.py::test_"
EMITTED = (
    f"{EMITTER}random_graphs_equal_their_instructions_to_the_bit[False] "
    f"{EMITTER}repeated_division_by_a_parameter_is_multiplication"
)
NATIVE = "tests/simulation/test_simulation_native.py::test_"
OPTIONS = f"{NATIVE}every_option_equals_the_oracle"
PIECES = "tests/codegen/test_resources_noise.py"
COLUMNS = "tests/export/fmi/test_fmi_every_column.py::"
DERIVED = "tests/control/guard/test_bounds.py::test_"
RUNTIME, FMI = "fmu/runtime/", "fmu/fmi/"
WORLD, CODEGEN = "wmr_ctrl/world/", "wmr_ctrl/codegen/"


@dataclass(frozen=True)
class TextAlteration:
    """``new`` for the first ``old`` of a file, and the tests that have to fail then."""

    path: str
    old: str
    new: str
    tests: str


def _rows(folder, tests, *rows):
    return tuple(TextAlteration(folder + name, old, new, tests) for name, old, new in rows)


ALTERED_FILES = (
    *_rows(
        WORLD, "tests/world/test_encoder.py",
        ("encoder.py", "ca.floor(turns)", "turns"),
    ),
    *_rows(
        WORLD, "tests/world/test_velocity_mean.py",
        ("velocity_mean.py", "* window)", "* (window + 1))"),
        ("velocity_mean.py", "seen.aged[age]", "seen.aged[0]"),
    ),
    *_rows(
        WORLD, "tests/world/test_jitter.py",
        ("jitter.py", "phase >= wait", "phase > wait"),
        ("jitter.py", "(most + 1)", "most"),
    ),
    *_rows(
        WORLD, "tests/world/test_motor.py",
        ("motor.py", "(v + turn, v - turn)", "(v + turn, v + turn)"),
    ),
    *_rows(
        WORLD, "tests/world/test_slope.py",
        ("slope.py", "ca.vertcat(-pull * along", "ca.vertcat(pull * along"),
    ),
    *_rows(
        WORLD, "tests/world/test_resistance.py",
        ("resistance.py", "- viscous *", "+ viscous *"),
    ),
    *_rows(
        WORLD, "tests/world/test_gust.py",
        ("gust.py", "(1 - keep) * number", "(1 + keep) * number"),
    ),
    *_rows(
        WORLD, OPTIONS,
        ("lag.py", "wanted + decay", "wanted - decay"),
        ("delay.py", '+ p.take("actuator.unmodelled_delay")', '+ p.take("clock.plant")'),
        ("torque_noise.py", "std * normal", "-std * normal"),
    ),
    *_rows(
        WORLD, OPTIONS,
        ("velocity_noise.py", "v + half *", "v - half *"),
    ),
    *_rows(
        WORLD, "tests/world/test_gyro.py",
        ("gyro.py", "omega.sym + p.take", "omega.sym - p.take"),
    ),
    *_rows(
        WORLD, "tests/world/test_pose_delay.py",
        ("pose_delay.py", "seen.aged[-1])", "seen.aged[0])"),
    ),
    *_rows(
        "wmr_ctrl/", EMITTED,
        ("world/model/graph.py", "(*one.operands[:2], other.operands[1])",
         "(one.operands[0], other.operands[1], one.operands[1])"),
        ("world/model/graph.py", "[CHANGING, STEADY]", "[STEADY, CHANGING]"),
        ("world/model/graph.py", "if node.op == ca.OP_DIV and", "if node.op == ca.OP_INV and"),
        ("codegen/dialect.py", '"wmr_min({0}, {1})"', '"wmr_max({0}, {1})"'),
        ("codegen/dialect.py", '"{0} <= {1}"', '"{0} < {1}"'),
        ("codegen/dialect.py", 'f"{condition} ? {yes} : {no}"', 'f"{condition} ? {no} : {yes}"'),
    ),
    *_rows(
        CODEGEN, "tests/codegen/test_body.py",
        ("items.py", "for side in (0, 1)]", "for side in (1, 0)]"),
        ("items.py", "if item not in dependent]", "if True]"),
        ("items.py", "self.condition, then, other)", "self.condition, other, then)"),
    ),
    *_rows(
        CODEGEN, f"{EMITTER}a_loop_keeps_its_array_where_something_else_reads_it[one_more-True]",
        ("reroll.py", "reads[number] == 1", "reads[number] >= 1"),
    ),
    *_rows(
        RUNTIME, PIECES,
        ("noise.c", "#define ROUNDS 10", "#define ROUNDS 9"),
        ("noise.c", "+ (cross >> 32)", ""),
        ("noise.c", "(low >> 32), cross", "0, cross"),
        ("noise.c", "k1 += 0xBB67AE8584CAA73Bu", "k1 += 0xBB67AE8584CAA73Au"),
    ),
    *_rows(RUNTIME, PIECES, ("noise.c", "product >> 64", "product >> 63")),
    *_rows(
        RUNTIME, OPTIONS,
        ("loop.c", "-2.0 * wmr_log", "-1.0 * wmr_log"),
        ("loop.c", "1.0 - u[0]", "1.0 - 0.5 * u[0]"),
        ("loop.c", "TWO_PI * u[1]", "3.0 * u[1]"),
        ("loop.c", "counter[2] = 0;", "counter[2] = 1;"),
        ("loop.c", "copy(slot, command, 2)", "copy(slot, arriving, 2)"),
        ("loop.c", "(WMR_AT(number, 0) + 0.5)", "(WMR_AT(number, 0) - 0.5)"),
    ),
    *_rows(
        RUNTIME, f"{NATIVE}truncated_noise_is_drawn_again_if_either_number_is_beyond",
        ("loop.c", " | wmr_mask(wmr_abs(out[1]) > most)", ""),
    ),
    *_rows(
        RUNTIME, "tests/simulation/test_many.py::test_a_torque_that_is_no_number_is_the_largest",
        ("loop.c", "wmr_not(wmr_mask(seen[WMR_SEEN_PEAK] <= *peak))",
         "wmr_mask(seen[WMR_SEEN_PEAK] > *peak)"),
    ),
    *_rows(
        RUNTIME, "tests/results/test_obstacles.py::"
        "test_runs_without_a_log_have_the_gap_of_the_log",
        ("loop.c", "wmr_mask(seen[WMR_SEEN_GAP] < found[WMR_FOUND_GAP])",
         "wmr_mask(seen[WMR_SEEN_GAP] > found[WMR_FOUND_GAP])"),
        ("loop.c", "findings[WMR_FOUND_GAP] = wmr_all(WMR_NO_MARGIN)",
         "findings[WMR_FOUND_GAP] = wmr_all(0.0)"),
    ),
    *_rows(
        RUNTIME, "tests/simulation/test_many.py::"
        "test_a_rate_of_turn_that_is_no_number_is_not_told_as_the_largest",
        ("loop.c", "both & wmr_mask(v[1] > most[1])", "first & wmr_mask(v[1] > most[1])"),
    ),
    *_rows(
        FMI, f"{COLUMNS}test_the_closed_loop",
        ("kind_loop.c", "memcpy(memory->queue, kept.queue, sizeof kept.queue);", ""),
        ("kind_loop.c", "rows[i] ? from[i]", "rows[i] ? from[0]"),
        ("kind_loop.c", "START_ROWS[i] ? v[START_ROWS[i]]", "START_ROWS[i] ? v[START_ROWS[0]]"),
    ),
    *_rows(
        FMI, f"{COLUMNS}test_the_closed_loop_ends_with_the_native_run",
        ("kind_loop.c", "s->state.finished = !memory->loop.running;", "s->state.finished = 0;"),
    ),
    *_rows(
        FMI, f"{COLUMNS}test_a_reference_with_memory_keeps_it_over_a_long_step",
        ("kind_sampled.c", "sample(s, sample_time(s));", "sample(s, t);"),
    ),
    *_rows(
        FMI,
        "tests/export/fmi/test_fmi_state.py::"
        "test_a_state_brings_its_parameters_into_a_new_instance",
        ("snapshot.c", "sizeof s->state);\n    kind_restore(s);", "sizeof s->state);"),
    ),
    *_rows(
        RUNTIME,
        "tests/world/test_registry.py::"
        "test_gusts_are_the_difference_of_two_pairs_of_numbers",
        ("loop.c", "(uint64_t)pair}", "0}"),
    ),
    *_rows(
        RUNTIME, "tests/codegen/test_resources.py",
        ("seed.c", "value ^= *constant;", ""),
        ("seed.c", "0xca01f9ddu * x - ", "0xca01f9ddu * x + "),
        ("seed.c", "value ^ (value >> 16)", "value ^ (value >> 15)"),
        ("seed.c", "(uint32_t)(seed >> 32)", "0"),
        ("seed.c", "if (from != to)", "if (from < to)"),
    ),
    *_rows(
        "wmr_ctrl/", "tests/control/guard/test_bounds.py",
        ("control/guard/bounds.py", "_sum(bound.dbar, given.d_model)",
         "_sum(bound.dbar, (given.d_model[0], 0.0))"),
        ("world/effect.py", "return mass_bounds(scenario)[1][0]",
         "return mass_bounds(scenario)[0][0]"),
        ("control/guard/bounds.py", 'name == "dbar" and any(', 'name == "d_model" and any('),
        ("control/guard/price.py", "time * max(net(guard, i), 0.0)", "time * net(guard, i)"),
    ),
    *_rows(
        "wmr_ctrl/", "tests/control/test_loop.py",
        ("control/loop.py", "ca.floor(self._late / h + 0.5)", "ca.floor(self._late / h)"),
    ),
    *_rows(
        "wmr_ctrl/", "tests/checks/test_guard_price.py tests/checks/test_start.py",
        ("world/phases.py", "return max(full_friction", "return min(full_friction"),
        ("control/guard/price.py",
         "return self.asked[0] > self.usable[0], self.asked[1] > self.usable[1]",
         "return self.asked[0] > self.usable[0], False"),
        ("control/guard/price.py", "max(ways, key=lambda way: way[0] - way[1])", "ways[0]"),
        ("theory/checks/preconditions.py", "if beyond[axis] > 0:", "if beyond[axis] >= 0:"),
    ),
    *_rows(
        "wmr_ctrl/", "tests/linear/test_margins.py",
        ("theory/linear/margins.py", "a % (2 * math.pi) / w", "abs(a) / w"),
    ),
    *_rows(
        "wmr_ctrl/", "tests/report/test_claims.py",
        ("report/paper_claims.py", "return Verdict.FAILS\n    own",
         "return Verdict.HOLDS\n    own"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", DERIVED + "what_effects_add_to_a_mass_widens_what_is_counted",
        ("bounds.py", "(low[0] - add[0], low", "(low[0], low"),
        ("bounds.py", "_sum(high, add)", "_sum(high, (add[0], 0.0))"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", DERIVED + "the_speed_that_no_guard_beats_counts_each_part",
        ("price.py", "- pair_of(guard.nbar)[i]", ""),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", DERIVED + "where_drives_vary_the_mixed_time_caps_what_brakes",
        ("bounds.py", "if not mixed:", "if True:"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/",
        DERIVED + "before_the_first_command_acts_a_push_has_delay_and_lag",
        ("price.py", "guard.latest + guard.slowest", "guard.latest"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", "tests/control/guard/test_refusals.py",
        ("refusals.py", "> period + GRID", "> 2 * period + GRID"),
        ("refusals.py", "(guard.age[i] or guard.window[i])", "guard.age[i]"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", "prove guard.outside",
        ("guard.py", "-ceiling(-y, b.mirrored,", "-ceiling(ca.fmin(-y, 2 * b.u1), b.mirrored,"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", "prove guard.assembled",
        ("guard.py", "rounding(max(item.roundings for item in late))", "rounding(0)"),
    ),
    *(
        TextAlteration(
            "wmr_ctrl/control/controller.py", "following([mapped,", "following([held.force,", seen
        )
        for seen in (
            "prove guard.assembled.alone",
            "tests/control/guard/test_lateness.py::"
            "test_older_commands_count_as_weak_wheels_were_given_them",
        )
    ),
    *_rows(
        WORLD, "prove world.noise.thrust",
        ("torque_noise.py", "else section.truncate\n", "else min(section.truncate, 3.0)\n"),
    ),
    *_rows(
        WORLD, "tests/world/test_effect_bounds.py::"
        "test_a_delay_is_as_many_plant_steps_as_its_decimals_say",
        ("delay.py", "round(late / clock.plant)", "int(late / clock.plant)"),
    ),
    *_rows(
        WORLD, "tests/checks/test_barrier.py",
        ("phases.py", "return robot.mu, robot.m,", "return robot.mu, 30.0,"),
    ),
    *_rows(
        WORLD, "tests/world/references/test_references.py",
        ("references/kind.py", "max(map(abs, turning))", "max(turning)"),
    ),
    *_rows(
        "wmr_ctrl/control/laws/", "tests/control/laws/test_laws_all.py::"
        "test_the_semi_implicit_step_leaks_at_its_end",
        ("nn.py", "/ (1 + leak)", "* (1 - leak)"),
    ),
    *_rows(
        "wmr_ctrl/results/", "tests/results/test_oscillation.py::"
        "test_a_swing_that_falls_below_its_share_in_a_quarter_decays",
        ("oscillation.py", "KEPT = 2 / 3", "KEPT = 1 / 3"),
    ),
    *_rows(
        "wmr_ctrl/results/", "tests/results/test_outcomes.py::"
        "test_the_gravest_event_gives_the_outcome",
        ("outcomes.py", "if monitor.violations:",
         "if monitor.violations and not (monitor.rigid and monitor.rigid.slipped is not None):"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", "tests/control/guard/test_lateness.py::"
        "test_a_guard_does_the_same_in_either_direction",
        ("delay.py", "self.rise, self.rise_late)", "self.rise_late, self.rise)"),
        ("delay.py", "self.slow and self.slow.mirrored", "self.slow"),
    ),
    *_rows(
        "wmr_ctrl/control/guard/", "tests/control/guard/test_lateness.py::"
        "test_a_few_hostile_robots_get_the_forces_of_the_formula",
        ("delay.py", "rise * ca.fmax(p - z, 0)", "rise * (p - z)"),
        ("delay.py", "    if late.averaged:\n", "    if late.jitter:\n"),
    ),
    *_rows(
        CODEGEN, f"{EMITTER}a_loop_keeps_its_array_where_something_else_reads_it[halves-False]",
        ("body.py", "operand.start + shift - inner.target.start, j",
         "operand.start - inner.target.start, j"),
    ),
    *_rows(
        "wmr_ctrl/control/", "tests/control/test_applied.py::"
        "test_a_torque_that_is_followed_is_that_of_every_step",
        ("applied.py", "pieces.insert(0, (", "pieces.append(("),
    ),
    *_rows(
        "wmr_ctrl/control/filter/", "tests/control/filter/test_forecast.py",
        ("forecast.py", "0.5 * x * x", "x * x"),
    ),
    *_rows(
        "wmr_ctrl/control/filter/", "tests/control/filter/test_filter_times.py",
        ("clip.py", "max(jitter, UNTOLD)", "jitter"),
    ),
    *_rows(
        "wmr_proofs/corridor/", "tests/corridor/test_enclosures.py::"
        "test_products_of_wide_matrices_hold_those_of_all_that_is_in_them",
        ("midradius.py", "self.radius @ other.most", "self.radius @ np.abs(other.middle)"),
    ),
    *_rows(
        "wmr_proofs/corridor/", "tests/corridor/test_certifier.py",
        ("certificate.py", " + law.sum(axis=(1, 2))", ""),
        ("masses.py", "zip(scenario.changes, later", "zip(scenario.changes, robots"),
    ),
    *_rows(
        "fmu/ros2/", "tests/ros2/test_filter_core.py",
        ("filter_core.c", "since > 0 ? (double)since * 1e-9 : 0.0", "(double)since * 1e-9"),
        ("filter_core.c", "now->simulated && core->answered && core->stamp",
         "now->simulated && core->stamp"),
    ),
    *_rows(
        "fmu/ros2/", "tests/ros2/test_free_core.py",
        ("filter_core.c", "isnan(one) || one < other", "one < other"),
        ("filter_core.c", "        u[1] = 0.0;\n", ""),
        ("filter_core.c", ": k == WMR_V_MAX;", ": 0;"),
    ),
    *_rows(
        "fmu/ros2/", "tests/ros2/test_scans.py",
        ("filter_core.c", "oldest = fmax(oldest, age)", "oldest = age"),
        ("scan_core.c", "range < b->least ? -1.0 : range", "range"),
        ("scan_core.c", "apart(gap, ray)", "1"),
        ("scan_core.c", "is_ignored(angle)) {", "0) {"),
    ),
    *_rows(
        RUNTIME, "tests/identification/test_identify.py::test_gradient_and_likelihood_agree",
        ("read_log.c", "if (kinds[n] != WATCHED)", "if (1)"),
        ("read_log.c", "kinds[n] == COUNTED", "kinds[n] >= SKIPPED"),
    ),
    *_rows(
        RUNTIME, "tests/simulation/test_batch.py::"
        "test_lanes_that_are_cancelled_do_no_further_sample",
        ("loop.c", " && !*s->cancelled) {", ") {"),
    ),
    *_rows(
        FMI, "tests/export/fmi/test_fmi_equality.py",
        ("kind_sampled.c", "PERIOD_TOLERANCE * period ? near : t",
         "PERIOD_TOLERANCE * period ? t : near"),
    ),
    *_rows(
        FMI, "tests/export/fmi/test_fmi_hostile.py",
        ("kind_loop.c", "period < 0.5 * step", "period < 1.5 * step"),
        ("instance.c", "stop >= start", "stop > start"),
    ),
    *_rows(
        "wmr_ctrl/theory/checks/", "tests/checks/test_barrier.py",
        ("wrong_model.py", "limits.v_u1).any()", "limits.v_u1).all()"),
    ),
    *_rows(
        "wmr_ctrl/simulation/campaign/", "tests/simulation/campaign/test_intervals.py::"
        "test_more_looks_need_a_narrower_interval",
        ("intervals.py", " / max(looks, 1)", ""),
    ),
    *_rows(
        "wmr_ctrl/simulation/campaign/", "tests/simulation/campaign/test_study_plan.py::"
        "test_the_points_of_a_latin_hypercube_lie_anywhere_in_their_strata",
        ("plan.py", "(strata + unit)", "(strata + 0.5)"),
    ),
    *_rows(
        "wmr_ctrl/simulation/campaign/", "tests/simulation/campaign/test_study_plan.py::"
        "test_every_combination_has_one_row_in_the_order_of_the_index",
        ("study_run.py", "plan.first_seed + k % plan.seeds)", "k % plan.seeds)"),
        ("study_store.py", "seed = plan.first_seed + place", "seed = place"),
        ("study_store.py", "divmod(index, plan.seeds)", "divmod(index, plan.seeds)[::-1]"),
    ),
    *_rows(
        "wmr_ctrl/export/page/", "tests/export/page/test_page_story.py::"
        "test_a_robot_has_room_for_delay_that_no_law_is_told",
        ("content.py", "actuator.delay + actuator.unmodelled_delay +", "actuator.delay +"),
    ),
    *_rows(
        RUNTIME, "tests/export/page/test_module.py::"
        "test_a_successor_goes_on_and_a_limit_that_is_moved_is_watched",
        ("page.c", "r->loop.sample * r->loop.substeps", "r->loop.sample"),
        ("page.c", "wmr_clock(parameters(&r->settings, &r->loop), r->loop.clock);", ""),
    ),
    *_rows(
        "wmr_ctrl/control/", "tests/control/test_loop.py",
        ("loop.py", "* (1 + NO_VIOLATION)", ""),
    ),
)  # fmt: skip
NOT_NOTICED = (
    (
        TextAlteration(RUNTIME + "loop.c", "STREAMS[k].held && !anew", "0 && !anew", ""),
        "a number that is held is drawn again in each step, by the index of its sample: the same "
        "number, later",
    ),
    (
        TextAlteration("wmr_ctrl/control/barrier/stable.py",
                       "ca.if_else(self.ahead, self.chi / self.base, 0)", "self.chi / self.base",
                       ""),
        "where the quotient reads it and v is not ahead, v is inside and c near: there Y = 0, and "
        "chi(0) = 0",
    ),
)  # fmt: skip
"""Alterations that change no value, so that no test could notice them, each with the reason."""


@contextmanager
def altered_copy(base, alteration):
    """For a time the file of a copied tree is altered.  ValueError where it lacks the place."""
    file = base / alteration.path
    text = file.read_text(encoding="utf-8")
    if alteration.old not in text:
        raise ValueError(f"{alteration.path} has no {alteration.old!r} any more")
    file.write_text(text.replace(alteration.old, alteration.new, 1), encoding="utf-8")
    try:
        yield
    finally:
        file.write_text(text, encoding="utf-8")


def copy_of_tree(base):
    """What tests need of the project, under ``base``."""
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, base / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, base / name)
    return base


def check_tests(base, rows):
    """Raise RuntimeError where a row names a test that is not there."""
    tests = (row.tests for row in rows if not row.tests.startswith(PROVE))
    named = sorted({test for text in tests for test in text.split()})
    if not named:
        return
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--co", "-n", "0", "-m", "",
         "-o", f"cache_dir={base / 'cache'}", *named],
        cwd=base, env={**os.environ, "PYTHONPATH": str(base)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(done.stdout + done.stderr)


def failing(base, tests):
    """The first of the tests that fails on a copied tree; empty where all pass.

    Tests that do not end or crash fail, too.  RuntimeError where they could not run at all.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-m", "", "--tb=no",
               "-o", f"cache_dir={base / 'cache'}", *tests.split()]  # fmt: skip
    if tests.startswith(PROVE):
        command = [sys.executable, "-m", "wmr_ctrl", "prove", "--only", tests.removeprefix(PROVE)]
    env = {**os.environ, "PYTHONPATH": str(base), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            command,
            cwd=base,
            env=env,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired:
        return f"{tests} (did not end)"
    if done.returncode < 0:
        return f"{tests} (crashed)"
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stdout + done.stderr)
    words = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("FAILED")]
    if done.returncode and tests.startswith(PROVE):
        return tests
    errors = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("ERROR")]
    return next(iter([*words, *errors]), "") if done.returncode else ""

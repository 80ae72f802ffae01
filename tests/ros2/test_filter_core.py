"""Faults of time, process and graph around the filter, as decisions of its core."""

import pytest

from tests.papers_robot import preset
from tests.ros2.worlds import MS, World
from tests.tables import changes
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.ros2.clocks import BACK, FORTH, FROZEN, Clocks, Moment
from wmr_ctrl.ros2.diagnosis import ERROR, OK, WARN, judged, rivals, two_senders
from wmr_ctrl.ros2.filter_core import FilterCore, node_templates
from wmr_ctrl.world.scenario import load_scenario

TICK = 20 * MS
STATED = changes("""
limits.v_u1 = [1.0, 2.0]; clock.control = 0.02
filter.kind = "clip"; filter.gain = [0.9, 1.1]; filter.d = [0.05, 0.05]
""")
SETTINGS = GateSettings(odometry="none")


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("paper-simulation", STATED)


@pytest.fixture
def world(scenario):
    return World(FilterCore(scenario, SETTINGS, "base_link"))


def ticks_to_rest(speed):
    return speed / (SETTINGS.fall[0] * TICK * 1e-9)


def test_ros_time_that_goes_back_begins_anew_and_drives_again(world):
    world.go(60)
    world.ros -= 10_000 * MS
    world.now()
    assert world.told == [BACK]
    assert world.core.tick(world.now()).command[0] == 0.5  # no time has passed
    assert world.go(1, sends=False)[0] < 0.5  # no command is left
    assert world.go(60)[-1] == 0.5  # older stamps count again


def test_ros_time_that_goes_forth_refuses_what_came_before_and_goes_on(world):
    world.go(60)
    before, world.ros = world.ros, world.ros + 10_000 * MS
    assert world.command(before + 1) == "too old"
    assert world.told == [FORTH]
    assert world.go(5) == [0.5] * 5


def test_ros_time_that_stops_ends_in_rest_by_the_steady_clock(world):
    world.go(60)
    speeds = world.go(60, passes=False)  # every stamp is the one before
    still = SETTINGS.command_timeout / (TICK * 1e-9)
    assert speeds[: int(still) - 1] == [0.5] * (int(still) - 1)
    assert speeds.index(0.0) <= still + ticks_to_rest(0.5) + 2
    assert speeds[-1] == 0.0


@pytest.mark.parametrize("stamped", [True, False])
def test_a_process_that_stood_still_trusts_nothing_from_before(world, stamped):
    """The queue has a command from before the freeze, whose sender has died."""
    world.go(60, stamped=stamped)
    queued = world.ros if stamped else 0
    world.wait(600 * MS)
    assert world.command(queued) != ""
    assert world.told == [FROZEN]
    speeds = world.go(30, sends=False)
    assert speeds[0] < 0.5  # one period's ramp, not the freeze's
    assert speeds[0] >= 0.5 - 1.01 * SETTINGS.fall[0] * TICK * 1e-9
    assert speeds[-1] == 0.0


def test_after_a_kill_the_next_life_sends_zeros_until_a_command_counts(world, scenario):
    world.go(60)
    old = world.ros
    again = World(FilterCore(scenario, SETTINGS, "base_link"), ros=world.ros + 2_000 * MS)
    assert again.go(5, sends=False) == [0.0] * 5
    assert again.command(old) == "too old"
    assert again.go(1, sends=False) == [0.0]
    speeds = again.go(3)
    assert speeds == pytest.approx([0.02, 0.04, 0.06])  # by the ramp: rise is 1 m/s2


def test_a_filter_that_starts_again_does_as_a_new_one_and_keeps_its_counters(scenario, world):
    """After any commands, messages and latches."""
    world.go(60)
    world.core.halt(True, world.now())
    world.core.halt(False, world.now())
    world.core.start()
    world.wait(700 * MS)
    new = World(FilterCore(scenario, SETTINGS, "base_link"), ros=world.ros)
    new.steady = world.steady
    for sends in (False, True, True):
        assert world.go(1, sends=sends) == new.go(1, sends=sends)
        assert world.core.last == new.core.last
    assert world.core.last.command[0] > 0
    assert world.told == new.told == []


def measured(scenario, **how):
    """A filter on simulated time that needs odometry, and has it."""
    core = FilterCore(scenario, GateSettings(odometry="required"), "base_link", **how)
    world = World(core, simulated=True)
    turn = 0.0, 0.0, 0.0, 1.0
    assert core.measure((0.1, 0.0), turn, world.ros, "base_link", world.now()) == ""
    return world


def test_on_simulated_time_odometry_that_is_newer_than_a_command_counts(scenario):
    world = measured(scenario, at_once=True)

    assert world.command(world.ros - 5 * MS) == ""
    assert "no-odometry" not in world.flags


def test_on_simulated_time_odometry_times_out_by_the_steady_clock(scenario):
    """A paused simulator says nothing new, however recent its last message."""
    world, flags = measured(scenario), []
    for steady in (20, 60, 60, 20):
        flags.append("no-odometry" in world.core.tick(world.now()).flags)
        world.wait(MS, steady * MS)

    assert flags == [False, False, False, True]


def test_a_stop_outlives_messages_and_needs_a_reset(world):
    world.go(60)
    world.wait(0, TICK)
    assert world.core.halt(True, world.now()).command == (0.0, 0.0)
    assert not world.core.reset()  # and it is not remembered
    assert world.core.halt(False, world.now()) is None
    assert world.go(3) == [0.0] * 3
    assert world.core.reset()
    assert world.go(1)[0] > 0


def test_simulated_time_may_run_at_another_rate_but_not_leap():
    clocks = Clocks(250 * MS)
    moments = [Moment(k * 400 * MS, k * 100 * MS, simulated=True) for k in range(5)]
    assert [clocks.see(now) for now in moments] == [()] * 5
    assert clocks.see(Moment(12_000 * MS, 500 * MS, simulated=True)) == (FORTH,)
    assert clocks.see(Moment(1_000 * MS, 600 * MS, simulated=True)) == (BACK,)
    assert clocks.counts == {FORTH: 1, BACK: 1}
    clocks = Clocks(250 * MS)  # nor is it a leap that it becomes simulated
    assert clocks.see(Moment(1_000_000 * MS, 0)) == ()
    assert clocks.see(Moment(0, 20 * MS, simulated=True)) == ()


# -- who else publishes --------------------------------------------------------------------

ME = "/robot1/wmr_filter"


def test_rivals_are_named_and_so_is_a_ghost_of_the_node_itself():
    assert rivals(ME, [ME], "/robot1/cmd_vel") == rivals(ME, [], "/robot1/cmd_vel") == ""
    assert two_senders(["/teleop"], "/cmd_vel_in") == ""
    other = rivals(ME, [ME, "/robot1/teleop"], "/base/cmd_vel")
    assert "/robot1/teleop" in other
    assert "/base/cmd_vel" in other
    ghost = rivals(ME, [ME, ME], "/base/cmd_vel")
    assert "own name" in ghost
    assert "lease" in ghost
    assert "teleop" not in ghost
    assert "/robot2/wmr_filter" in rivals(ME, [ME, "/robot2/wmr_filter"], "/base/cmd_vel")


def test_the_gravest_is_told_first():
    rival, senders = rivals(ME, [ME, "/x"], "/cmd_vel"), two_senders(["/a", "/b"], "/cmd_vel_in")
    assert judged((), "a callback failed", rival, senders) == (ERROR, "a callback failed")
    assert judged(("no-command",), "", rival, senders) == (ERROR, rival)
    assert judged(("stopped", "no-command"), "", "", senders) == (ERROR, "stopped")
    assert judged(("no-command",), "", "", senders) == (WARN, "no-command")
    assert judged(("limited",), "", "", senders) == (WARN, senders)
    assert judged(("limited", "ramped")) == (OK, "driving")
    assert judged(("arrived",)) == (OK, "arrived")


# -- answers when a command comes ----------------------------------------------------------


@pytest.fixture
def prompt(scenario):
    return World(FilterCore(scenario, SETTINGS, "base_link", at_once=True))


def sent_at(world, *, ros=0, steady=0, simulated=False):
    """True if a command that comes later by these times [ms] is answered immediately."""
    world.wait(ros * MS, steady * MS)
    world.simulated = simulated
    reason, gated = world.core.command((0.5, 0.0), world.ros, "base_link", world.now())
    assert reason == ""
    return gated is not None


def timer(world, *, steady, simulated=False):
    """True if the timer answers at this later time [ms]."""
    world.wait(0 if simulated else steady * MS, steady * MS)
    return world.core.tick(Moment(world.ros, world.steady, simulated)) is not None


def test_a_command_is_answered_when_it_is_due_and_no_sooner(prompt):
    assert sent_at(prompt)
    assert not sent_at(prompt, ros=14, steady=14)
    assert sent_at(prompt, ros=2, steady=2)


def test_the_timer_answers_what_is_late_by_a_quarter_and_then_each_period(prompt):
    assert sent_at(prompt)
    assert not timer(prompt, steady=24)
    assert timer(prompt, steady=1)
    assert not timer(prompt, steady=19)
    assert timer(prompt, steady=1)


def test_stamps_do_not_hasten_answers_but_on_simulated_time(prompt):
    assert sent_at(prompt)
    assert not sent_at(prompt, ros=20, steady=1)
    assert sent_at(prompt, ros=20, steady=1, simulated=True)
    assert timer(prompt, steady=300, simulated=True)
    assert sent_at(prompt, ros=20, steady=1, simulated=True)  # though the timer was last


def test_after_simulated_time_went_back_commands_are_answered_at_once_again(prompt):
    """After the jump, elapsed time comes from the steady clock."""
    assert sent_at(prompt, simulated=True)
    before = prompt.core.last.command[0]
    assert sent_at(prompt, ros=-10_000, steady=10, simulated=True)
    assert prompt.core.last.command[0] == pytest.approx(before + 0.01)


def test_answers_at_once_ramp_by_the_time_that_has_passed(prompt):
    speeds = []
    for _ in range(8):
        assert sent_at(prompt, ros=16, steady=16)
        speeds.append(prompt.core.last.command[0])
    assert speeds[1:] == pytest.approx([0.02 + 0.016 * k for k in range(1, 8)])


def test_a_step_is_in_time_within_the_stated_jitter_and_not_a_tick_more():
    """The gate sees nanoseconds: 900 ns off is late without jitter and in time with 1 us."""
    governed = "filter.kind = 'governor'; filter.tau = [0.2, 0.3]"
    for jitter, late in ((0.0, [False, False, True, True, False]), (1e-6, [False] * 5)):
        case = preset("paper-simulation", STATED, f"{governed}; filter.jitter = {jitter}")
        world, told = World(FilterCore(case, SETTINGS, "base_link")), []
        for off in (0, 0, 900, -900, 0):
            world.wait(TICK + off)
            told.append("late" in world.core.tick(world.now()).flags)
        assert told == late


@pytest.mark.parametrize(
    "text, literal",
    [("scan", '"scan"'), ('a"b\\?', r'"a\042b\134\077"'), ("é\n", r'"\303\251\012"')],
)
def test_a_text_in_c_is_plain_ascii(text, literal):
    template = node_templates().from_string("{{ text | quoted }}")

    assert template.render(text=text) == literal

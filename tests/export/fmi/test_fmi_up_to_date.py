"""Values that an instance shows fit its present time, states, inputs and updated memory."""

import ctypes as ct

import casadi as ca
import numpy as np
import pytest

from tests.export.fmi.raw import DISCARD, ERROR, ME, OK, REFUSED
from tests.export.fmi.sequences import reach
from tests.export.fmi.test_fmi_derivatives import call, system_of


def test_a_reference_is_where_it_is_at_the_solvers_time(raw):
    fmu = raw("reference", 3)
    one, late = reach(fmu, ME, "continuous"), fmu.new(ME).begin(start=1.5)
    begun = one.get("x_d", "v1_d")
    assert fmu.SetTime(one.handle, ct.c_double(1.5)) == OK

    assert one.get("x_d", "v1_d") == late.get("x_d", "v1_d") != begun


@pytest.mark.parametrize("parallel", [False, True])
def test_the_first_sample_has_the_inputs_of_its_step_unless_all_parts_step_at_once(raw, parallel):
    """All samples have their step's inputs, except the first with `clock.parallel`."""
    fmu = raw("nn", 3)
    one, still = (fmu.new() for _ in range(2))
    for instance in (one, still):
        assert instance.put({"clock.parallel": float(parallel)}) == OK
        instance.begin()
    for k in range(2):
        assert one.put({"v1": 0.3}) == OK
        for instance in (one, still):
            assert instance.step(0.01 * k, 0.01) == OK
        same = one.get("tau_right", "tau_left") == still.get("tau_right", "tau_left")

        assert same is (parallel and k == 0)


def test_derivatives_are_at_the_memory_that_the_last_sample_started_from(raw):
    """The law learns, and each sample has other inputs."""
    system, fmu, draw = system_of("nn"), raw("nn", 3), np.random.default_rng(5)
    knowns = [n for p in system.inputs for n in p.signal.elements]
    unknowns = [n for o in system.outputs for n in o.signal.elements]
    slopes = system.function("J", [ca.jacobian(system.y, system.u)])
    after = system.function("after", [system.update])

    one, x = fmu.new(), ca.DM(system.x0)
    for k in range(3):
        near = {"v1_d": 0.2, "v1": 0.1, "v2_d": 0.1, "omega": 0.2}  # where the network is large
        u = [near.get(n, 0.0) + draw.uniform(-0.01, 0.01) for n in knowns]
        assert one.put(dict(zip(knowns, u, strict=True))) == OK
        if k == 0:
            one.begin()
        before, x = x, after(u, x, system.p0)
        assert one.step(0.01 * k, 0.01) == OK
    exact, stale = (np.array(slopes(u, memory, system.p0)) for memory in (before, x))
    for name, J, other in (("Directional", exact, stale), ("Adjoint", exact.T, stale.T)):
        seed = draw.normal(size=J.shape[1])
        _, found = call(one, f"Get{name}Derivative", unknowns, knowns, seed, len(J))
        off = [np.abs(found - slope @ seed).max() for slope in (J, other)]
        assert off[0] <= 1e-12 * (1 + np.abs(exact).max()) < 1e-3 * off[1]


def test_events_are_told_while_their_category_is_on(raw):
    events, errors = [b"logEvents"], [b"logStatusError"]
    told = [(1, [])], [(1, errors), (1, events)], [(1, events), (0, errors)]
    for version in (2, 3):
        fmu = raw("plant", version)
        fmu.categories.clear()
        for switches in (*told, [(1, errors)], [(1, []), (0, events)], []):
            one = fmu.new()
            for on, names in switches:
                listed = (ct.c_char_p * len(names))(*names) if names else None
                assert fmu.SetDebugLogging(one.handle, on, ct.c_size_t(len(names)), listed) == OK
            fmu.messages.clear()
            one.begin()
            assert bool(fmu.messages) == (switches in told)
        assert (one.step(0.0, 1e9), one.step(0.0, -1.0)) == (DISCARD, ERROR)
        assert fmu.categories == {
            (OK, "logEvents"), (DISCARD, "logStatusDiscard"), (ERROR, "logStatusError")
        }  # fmt: skip


def test_every_number_of_an_array_is_set_and_looked_at(raw):
    fmu = raw("nn", 3)
    one, ref, weights = fmu.new(), fmu.ref("W_hat1"), [0.01 * k for k in range(64)]

    assert one.put_refs([ref], weights) == OK
    assert one.put_refs([ref], [*weights[:-1], np.nan]) in REFUSED
    assert one.get_refs([ref], 64) == (OK, weights)


@pytest.mark.parametrize("what", ["closed-loop", "nn"])
def test_in_half_steps_it_shows_at_its_samples_what_it_shows_in_whole_ones(raw, what):
    fmu, shown = raw(what, 3), []
    for h in (0.01, 0.005, 0.02, 0.04):
        one = fmu.new()
        one.put(dict.fromkeys(fmu.inputs, 0.1))
        before = one.begin().all()
        for k in range(round(0.04 / h)):
            assert one.step(k * h, h) == OK
        shown.append(one.all())

    assert shown == shown[:1] * 4
    assert shown[0][1:] != before[1:]


def test_a_change_comes_with_the_first_plant_step_at_or_after_its_time(raw):
    """Times are compared as decimals: 0.035 / 0.005 is a little more than 7 in doubles."""
    fmu, shown = raw("closed-loop", 3), {}
    for time in (0.0301, 0.035, 0.0351):
        one = fmu.new()
        assert one.put({"changes[1].t": time, "clock.plant": 0.005}) == OK
        assert one.begin().step(0.0, 0.1) == OK
        shown[time] = one.get("x", "v1")

    assert shown[0.035] == shown[0.0301] != shown[0.0351]


def test_samples_count_from_the_start_time(raw):
    fmu, shown = raw("closed-loop", 3), []
    for start in (0.0, 1.0):
        one = fmu.new().begin(start)
        for k in range(3):
            assert one.step(start + 0.01 * k, 0.01) == OK
        shown.append(one.get("x", "v1"))

    assert shown[0] == shown[1]

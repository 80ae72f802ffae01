"""Times of messages, on one clock."""

import numpy as np
import pytest

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.results.bag_clocks import Topic, clocks_of

SECOND = 10**9


def topic(stamps, receipt, name="/odom"):
    ns = [np.rint(np.asarray(t) * SECOND).astype(np.int64) for t in (stamps, receipt)]
    return Topic(name, *ns, np.zeros((len(receipt), 1)), "odom")


T = np.arange(0.0, 20.0, 0.1)


def test_stamps_are_used_and_receipts_where_there_are_none():
    remarks = []
    clocks = clocks_of(
        {"odom": topic(T + 5, T + 5.02), "cmd": topic(0 * T, T + 5.01, "/cmd")}, remarks
    )

    assert clocks["odom"] == pytest.approx((T + 5) * SECOND, abs=1)
    assert clocks["cmd"] == pytest.approx((T + 5.01) * SECOND, abs=1)
    assert "recorded 20 ms after its stamps" in remarks[0]
    assert "times are those of the recorder" in remarks[1]


@pytest.mark.parametrize("other", [False, True], ids=["no stamps", "stamps of a third clock"])
@pytest.mark.parametrize(
    "rate, pause, jitter",
    [
        (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.59, 0.0, 0.004), (0.995, 8.0, 0.004),
        (1.0, 8.0, 0.004), (3.0, 8.0, 0.004),
    ],
)  # fmt: skip
def test_receipts_are_put_on_the_clock_of_the_stamps(rate, pause, jitter, other):
    """A simulation at ``rate`` times real time, which may pause; messages are up to 30 ms late."""
    late = np.minimum(jitter * np.random.default_rng(0).exponential(size=(2, len(T))), 0.03)
    odom, sent = 100 + T / rate + pause * (T > 9.98) + late
    stamps, remarks = (sent - 3e5 if other else 0 * T), []

    found = clocks_of({"odom": topic(T, odom), "cmd": topic(stamps, sent, "/cmd")}, remarks)

    off = 0.035 * max(rate, 1.0) if jitter else 1e-6
    assert found["cmd"] / SECOND == pytest.approx(T, abs=off)
    assert "on two clocks" in remarks[1]
    assert ("runs at" in remarks[1]) is (rate != 1.0)
    assert jitter or rate == 1.0 or f"runs at {rate} of the recorder's" in remarks[1]
    assert ("stands still for 8 s" in remarks[1]) is bool(pause)


@pytest.mark.parametrize("apart, two", [(0.4, False), (-0.4, False), (0.6, True), (-0.6, True)])
def test_clocks_half_a_second_apart_are_one(apart, two):
    remarks = []
    parts = {"odom": topic(T, T + apart), "cmd": topic(0 * T, T, "/cmd")}
    delay = (lambda found: found["odom"][0] - found["cmd"][0])(clocks_of(parts, remarks))

    assert any("two clocks" in text for text in remarks) is two
    assert delay / SECOND == pytest.approx(apart if two else 0.0, abs=1e-6)


def test_clocks_whose_rates_differ_are_put_on_one_though_they_begin_together():
    found = clocks_of({"odom": topic(T, 1.01 * T), "cmd": topic(0 * T, 1.01 * T, "/cmd")}, [])

    assert found["cmd"] == pytest.approx(found["odom"], abs=1e-6 * SECOND)


def test_a_clock_whose_rate_changes_is_refused():
    bent = np.where(T < 10, T, 10 + 2 * (T - 10))
    with pytest.raises(ResultFileError, match="stamps run at 1 to 2 seconds in a second"):
        clocks_of({"odom": topic(bent, T + 100), "cmd": topic(0 * T, T + 100)}, [])


@pytest.mark.parametrize("back, refused", [(0.95, False), (1.05, True)])
def test_a_message_up_to_a_second_late_is_put_in_order(back, refused):
    stamps, remarks = T.copy(), []
    stamps[41] = T[40] - back
    parts = {"odom": topic(stamps, T + 1)}

    if refused:
        with pytest.raises(ResultFileError, match=r"goes back by 1\.05 s at message 42"):
            clocks_of(parts, remarks)
    else:
        clocks_of(parts, remarks)
        assert remarks[-1].endswith(
            "1 messages came out of order, by 950 ms at most; sorted by time."
        )

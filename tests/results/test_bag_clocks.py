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


def test_stamps_count_and_receipts_where_there_are_none():
    remarks = []
    clocks = clocks_of(
        {"odom": topic(T + 5, T + 5.02), "cmd": topic(0 * T, T + 5.01, "/cmd")}, remarks
    )

    assert clocks["odom"] == pytest.approx((T + 5) * SECOND, abs=1)
    assert clocks["cmd"] == pytest.approx((T + 5.01) * SECOND, abs=1)
    assert "recorded 20 ms after its stamps" in remarks[0]
    assert "times are those of the recorder" in remarks[1]


@pytest.mark.parametrize("rate", [1.0, 0.5])
def test_receipts_are_put_on_the_clock_of_the_stamps(rate):
    remarks = []
    parts = {"odom": topic(rate * T, T + 100), "cmd": topic(0 * T, T + 100.03, "/cmd")}

    clocks = clocks_of(parts, remarks)

    assert clocks["cmd"] / SECOND == pytest.approx(rate * (T + 0.03), abs=1e-6)
    assert "on two clocks" in remarks[1]
    assert ("runs at 0.5 of the recorder's" in remarks[1]) is (rate == 0.5)


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


def test_a_clock_whose_rate_changes_or_that_was_set_back_is_refused():
    bent = np.where(T < 10, T, 10 + 2 * (T - 10))
    with pytest.raises(ResultFileError, match="stamps run at 1 to 2 seconds in a second"):
        clocks_of({"odom": topic(bent, T + 100), "cmd": topic(0 * T, T + 100)}, [])

    back = np.where(T < 10, T, T - 5)
    with pytest.raises(ResultFileError, match=r"goes back by 4\.9 s at message 101"):
        clocks_of({"odom": topic(back, T)}, [])


def test_messages_out_of_order_by_less_than_a_second_are_told():
    remarks = []
    swapped = T.copy()
    swapped[[7, 8]] = swapped[[8, 7]]
    clocks_of({"odom": topic(swapped, T + 1)}, remarks)

    assert remarks[-1] == "/odom: 1 messages came out of order, by 100 ms at most; sorted by time."

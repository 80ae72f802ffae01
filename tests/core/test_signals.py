"""Signals: elements, units and places."""

from wmr_ctrl.core.signals import MEASURED, TRACKING_ERROR, Signal, elements, places, tau_sent


def test_elements_have_names_and_units_and_places_of_their_own():
    pair, whole = Signal("v", "m/s, rad/s", "velocity", 2), Signal("q", "1", "share", 3)

    assert pair.units == ("m/s", "rad/s")
    assert whole.units == ("1", "1", "1")
    assert elements([pair, Signal("t", "s", "time")]) == ("v[1]", "v[2]", "t")
    assert places([pair, whole]) == {"v": slice(0, 2), "q": slice(2, 5)}
    assert places([]) == {}


def test_the_catalogue_says_what_it_lists():
    assert TRACKING_ERROR.units == ("m", "m", "rad")
    assert len(elements(MEASURED)) == 5
    assert tau_sent(3).elements == ("tau_sent3[1]", "tau_sent3[2]")

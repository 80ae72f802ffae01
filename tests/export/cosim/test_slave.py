"""Numbers of an FMU's variables, as its functions take them."""

from types import SimpleNamespace

import pytest

from wmr_ctrl.export.cosim.slave import Values


def values(kind, **variables):
    functions = {f"fmi3{verb}{kind}": lambda *_: 0 for verb in ("Get", "Set")}
    fmu = SimpleNamespace(component=None, dll=SimpleNamespace(**functions))
    own = [
        SimpleNamespace(valueReference=k, shape=shape, start=start)
        for k, (shape, start) in enumerate(variables.values())
    ]
    return Values(fmu, 3, kind, own)


def test_integers_are_rounded_and_must_fit():
    whole = values("Int32", a=(None, "3"))
    whole.assign(0, 2.6)

    assert whole.numbers[0] == 3
    with pytest.raises(ValueError, match="does not fit into type Int32"):
        whole.assign(0, 1e12)


def test_a_truth_value_begins_at_one_half():
    flag = values("Boolean", a=(None, "false"))
    for given, kept in ((0.5, True), (0.49, False), (-7.0, False)):
        flag.assign(0, given)
        assert flag.numbers[0] is kept


def test_arrays_begin_where_the_last_one_ends_with_their_start():
    arrays = values("Float64", a=((2,), "1.5 2.5"), b=(None, None), c=((3,), "7"))

    assert arrays.begins == {0: 0, 1: 2, 2: 3}
    assert list(arrays.numbers) == [1.5, 2.5, 0.0, 7.0, 7.0, 7.0]

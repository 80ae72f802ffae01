"""The examples in the documentation run and print what is shown."""

import doctest

import pytest

from wmr_ctrl import api


@pytest.mark.slow
def test_examples_of_the_python_interface():
    failed, tried = doctest.testmod(api)

    assert failed == 0
    assert tried > 0

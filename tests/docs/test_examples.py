"""The examples in the documentation run and print what they say."""

import doctest
from importlib import import_module

import pytest


@pytest.mark.slow
@pytest.mark.parametrize("name", ["wmr_ctrl.api"])
def test_examples_of_the_python_interface(name):
    failed, tried = doctest.testmod(import_module(name))

    assert failed == 0
    assert tried > 0

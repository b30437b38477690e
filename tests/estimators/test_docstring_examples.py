"""The examples in the docstrings of estimators run, and print what they say."""

import doctest
from importlib import import_module

import pytest


@pytest.mark.parametrize("name", ["arcs", "gaussian", "contact", "recursive"])
def test_the_example_of_an_estimator_prints_what_it_says(name):
    found = doctest.testmod(import_module(f"soft_gripper.estimators.{name}"))
    assert (found.failed, found.attempted > 5) == (0, True)

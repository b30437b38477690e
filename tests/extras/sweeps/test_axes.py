"""What --vary means, and the points that follow."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.axes import Range, Values, read_axis, sweep_points


@pytest.mark.parametrize(
    ("text", "axis"),
    [
        ("a.b=1,2.5,x", Values("a.b", (1, 2.5, "x"))),
        ("a=true, null", Values("a", (True, None))),
        ("a=[1, [2, 3]]", Values("a", (1, [2, 3]))),
        ("a=+10 %,-10 %", Values("a", ("+10 %", "-10 %"))),
        ("a=0.1..0.5:5", Values("a", (0.1, 0.2, 0.3, 0.4, 0.5))),
        ("a=1..5:5", Values("a", (1, 2, 3, 4, 5))),
        ("a=1..2:3", Values("a", (1.0, 1.5, 2.0))),
        ("a=1e-3..2e-3:2", Values("a", (1e-3, 2e-3))),
        ("a=-10..10 %:3", Values("a", ("-10 %", "+0 %", "+10 %"))),
        ("a=0.5..0.9", Range("a", 0.5, 0.9)),
        ("a=-3..4", Range("a", -3.0, 4.0, is_whole=True)),
    ],
)
def test_values_and_ranges(text, axis):
    assert read_axis(text) == axis


@pytest.mark.parametrize(
    "text",
    [
        "a",
        "=1",
        "a=[]",
        "a=2..1:3",
        "a=1..2:1",
        "a=-1e999..1:2",
        "a=2020-13-45",
        "a=[&a [*a]]",
        "a=[1]: 2",
    ],
)
def test_what_means_nothing_is_quoted(text):
    with refused("--vary"):
        read_axis(text)


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("1-4", "1..4:N"),
        ("2,0.5 - 0.9", "0.5..0.9:N"),
        ("-4--1", "-4..-1:N"),
        ("1e3 to 1e4", "1e3..1e4:N"),
        ("-10-10%", "-10..10 %:N"),
    ],
)
def test_a_range_in_another_notation_is_told_ours(text, right):
    with pytest.raises(InputError) as caught:
        read_axis(f"sensor.sections={text}")
    assert caught.value.expected == f"write {right}, with N values, or list them"


@pytest.mark.parametrize("text", ["a-b", "box_1-4", "1e-3", "-3,-2", "1-2-3-4", "left-1"])
def test_a_dash_inside_a_value_is_no_range(text):
    assert isinstance(read_axis(f"a={text}"), Values)


@pytest.mark.parametrize("count", ["1000000000", "9" * 5000, "1000001"])
def test_more_values_than_anybody_waits_for_are_refused_before_they_are_listed(count):
    with pytest.raises(InputError) as error:
        read_axis(f"a=1..2:{count}")
    assert error.value.field == "--vary"


@pytest.mark.parametrize(
    "arguments",
    [
        ([Values("a", tuple(range(1000))), Values("b", tuple(range(1000))), Values("c", tuple(range(1000)))],),
        ([Values("a", tuple(range(1001))), Values("b", tuple(range(1000)))],),
        ([Range("a", 0.0, 1.0)], "latin", 10**9),
    ],
)
def test_more_points_than_anybody_waits_for_are_refused_before_they_are_made(arguments):
    with pytest.raises(InputError) as error:
        sweep_points(*arguments)
    assert "above the limit of 1000000" in error.value.expected


def test_a_grid_has_all_combinations_the_last_key_fastest():
    grid = sweep_points([Values("a", (1, 2)), Values("b", ("x", "y", "z"))])
    assert [(point["a"], point["b"]) for point in grid] == [(a, b) for a in (1, 2) for b in "xyz"]


@pytest.mark.parametrize(("method", "number"), [("latin", 40), ("sobol", 64)])
def test_samples_fill_every_axis_evenly(method, number):
    """In each of as many intervals of a range lies one; values and whole numbers come equally often."""
    axes = [Range("a", 0.5, 0.9), Range("n", 1.0, 4.0, is_whole=True), Values("c", ("x", "y"))]
    found = sweep_points(axes, method, number, 3)
    filled = np.floor((np.array([point["a"] for point in found]) - 0.5) / 0.4 * number).astype(int)
    assert sorted(filled) == list(range(number))
    assert [sum(point["n"] == n for point in found) for n in (1, 2, 3, 4)] == [number // 4] * 4
    assert [sum(point["c"] == c for point in found) for c in "xy"] == [number // 2] * 2
    assert found == sweep_points(axes, method, number, 3)
    assert found != sweep_points(axes, method, number, 4)


@pytest.mark.parametrize(
    ("axes", "arguments", "field", "value"),
    [
        ([Values("a", (1,)), Values("a", (2,))], (), "--vary", "a"),
        ([Range("a", 0, 1)], (), "--vary", "a"),
        ([Range("a", 0, 1)], ("sobol", 6), "--sample", 6),
        ([Range("a", 0, 1)], ("latin", 0), "--sample", 0),
    ],
)
def test_what_cannot_be_sampled_is_refused(axes, arguments, field, value):
    with refused(field, value):
        sweep_points(axes, *arguments)


@pytest.mark.parametrize("ends", [(2.0, 1.0), (1.0, 1.0), (None, 1.0), ("a", "b"), (float("nan"), 1.0)])
def test_a_range_has_a_lower_and_a_higher_end(ends):
    with pytest.raises(InputError) as caught:
        Range("a.b", *ends)
    assert caught.value.field == "a.b"


@pytest.mark.parametrize("values", [(), [], None, 3, "text"])
def test_a_key_takes_one_value_at_least(values):
    with pytest.raises(InputError) as caught:
        Values("a.b", values)
    assert caught.value.field == "a.b"


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (([],), "axes"),
        ((None,), "axes"),
        (([None],), "axes"),
        (([Values("a", (1,))], "random"), "method"),
        (([Values("a", (1,))], "latin", 2.5), "number"),
        (([Values("a", (1,))], "latin", 2, -1), "seed"),
    ],
)
def test_points_of_what_is_none(arguments, field):
    with pytest.raises(InputError) as caught:
        sweep_points(*arguments)
    assert caught.value.field == field


@pytest.mark.parametrize("count", [1, -1, 2.5, None])
def test_a_range_is_spread_over_two_values_at_least(count):
    with pytest.raises(InputError):
        Range("a", 0.0, 1.0).spread(count)

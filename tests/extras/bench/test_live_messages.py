"""Messages in four formats; whatever is not what was described is malformed."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from soft_gripper.extras.bench.messages import (
    MAX_MESSAGE_BYTES,
    MalformedError,
    count_of,
    decoded,
    encoded,
    select_numbers,
)
from soft_gripper.extras.bench.watch import Watch

FIELDS = ["n", "a", "b"]
RESULTS = {"n": 3.0, "v": np.array([0.5, -1.25])}


@pytest.mark.parametrize("form", ["text", "float32", "float64"])
def test_numbers_without_names_come_back(form):
    assert decoded(encoded(RESULTS, form), form, FIELDS) == {"n": 3.0, "a": 0.5, "b": -1.25}


def test_null_is_a_sensor_that_was_not_read():
    found = decoded(b'{"a": null, "b": [1, null]}', "json", ())
    assert math.isnan(found["a"])
    assert math.isnan(found["b[1]"])
    assert json.loads(encoded({"a": np.array([np.nan])}, "json")) == {"a": [None]}


@pytest.mark.parametrize(
    ("message", "form"),
    [
        (b"", "json"),
        (b"nonsense", "json"),
        (b"[1, 2]", "json"),
        (b'{"a": "1"}', "json"),
        (b'{"a": true}', "json"),
        (b'{"a": NaN}', "json"),
        (b'{"a": 1e999}', "json"),
        (b'{"a": ' + b"9" * 400 + b"}", "json"),
        (b"[" * 50_000, "json"),
        (b'{"a": [[1]]}', "json"),
        (b" " * (MAX_MESSAGE_BYTES + 1), "json"),
        (b"\xff\xfe", "json"),
        (b"1,2", "text"),
        (b"1,2,3,4", "text"),
        (b"1,2,nan", "text"),
        (b"1,2,inf", "text"),
        (b"1,2,x", "text"),
        (b"1,2,1_0", "text"),
        (b"\xb2,2,3", "text"),
        (b"\0" * 11, "float32"),
        (np.array([1, 2, np.nan]).tobytes(), "float64"),
    ],
)
def test_malformed_messages(message, form):
    with pytest.raises(MalformedError):
        decoded(message, form, FIELDS)


@given(st.binary(max_size=200), st.sampled_from(["json", "text", "float32", "float64"]))
def test_no_message_does_more_than_be_malformed(message, form):
    try:
        found = decoded(message, form, FIELDS)
    except MalformedError:
        return
    assert not any(map(math.isinf, found.values()))


def test_fields_that_are_missing_and_numbers_that_do_not_count():
    with pytest.raises(MalformedError, match="no field 'c'"):
        select_numbers({"a": 1.0}, ["a", "c"])
    for value in (-1.0, 0.5, math.nan, math.inf, 2.0**60):
        with pytest.raises(MalformedError):
            count_of(value)


def watched(*counts):
    watch = Watch()
    return [watch.accept(count) for count in counts], watch.counts


@pytest.mark.parametrize(
    ("counts", "gaps", "expected"),
    [
        ([None, None], [0, 0], {"used": 2}),
        ([0, 1, 4, 3, 3, 4, 5], [0, 0, 2, None, None, None, 0], {"used": 4, "lost": 1, "late": 1, "repeated": 2}),
        # A device that restarts: from several readings in order it is known that the numbers go on there.
        *(([n, 0, 1, 2, 3], [0, None, None, 0, 0], {"used": 3, "restarts": 1, "repeated": 2}) for n in (5000, 500, 5)),
        # The sixth has a number far ahead: what it skips is not lost, but for the number that it hid.
        *(
            (
                [0, 1, 2, 3, 4, n, 6, 7, 8, 9, 10],
                [0, 0, 0, 0, 0, n - 5, None, None, 0, 0, 0],
                {"used": 9, "lost": 1, "late": 2, "restarts": 1},
            )
            for n in (12, 999, 10**6)
        ),
        # A number that cannot be right loses nothing; where others go on from it, the device counts from there.
        ([3, 4, 2**53 - 1, 6, 7], [0, 0, None, 1, 0], {"used": 4, "lost": 1, "malformed": 1}),
        ([4, *range(2**40, 2**40 + 4)], [0, None, None, 0, 0], {"used": 3, "malformed": 2, "restarts": 1}),
    ],
)
def test_numbers_of_readings_tell_what_is_missing(counts, gaps, expected):
    found, seen = watched(*counts)
    assert found == gaps
    assert {name: number for name, number in asdict(seen).items() if number} == expected


@given(st.lists(st.integers(0, 60), unique=True, min_size=1))
def test_every_reading_is_counted_once(order):
    """Used, late or lost: together all those between the first that came and the last, if it never began anew."""
    _, counts = watched(*order)
    assume(counts.restarts == 0)
    assert counts.used + counts.late + counts.repeated == len(order)
    assert counts.used + counts.late + counts.lost == max(order) - order[0] + 1
    assert counts.repeated == sum(count < order[0] for count in order)

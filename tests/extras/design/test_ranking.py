"""Scores and fronts of designs, what matters for them, their figure and tables."""

from dataclasses import replace

import numpy as np
import pytest
from csv_rows import csv_rows

from soft_gripper.extras.design.run_design import Design, DesignResult, find_best, score_design, summarize_runs
from soft_gripper.extras.design.study_file import DesignConfig, DesignStudy, EndConfig, LimitConfig
from soft_gripper.extras.design.study_tables import DESIGNS, SENSITIVITY, TESTS, sensitivities, write_tables
from soft_gripper.extras.sweeps.axes import Range, Values

FORCE = EndConfig("force", "least", "mean")
NAN = float("nan")


def rows(*forces, grasp="held"):
    return [{"grasp": grasp, "force": str(force)} for force in forces]


@pytest.mark.parametrize(
    ("end", "forces", "expected"),
    [
        (FORCE, [1.0, 3.0], 2.0),
        (EndConfig("force", "least", "worst"), [1.0, 3.0], 3.0),
        (EndConfig("force", "most", "worst"), [1.0, 3.0], 1.0),
        (FORCE, [1.0, NAN], NAN),
        (FORCE, [], NAN),
    ],
)
def test_ends_are_means_or_the_worst(end, forces, expected):
    assert summarize_runs([*rows(*forces), *rows(9.0, grasp="dropped")], [end])[1] == pytest.approx(
        (expected,), nan_ok=True
    )


@pytest.mark.parametrize(
    ("limit", "excess"),
    [
        (LimitConfig(most=2.5), 0.2),
        (LimitConfig(most=4.0), -0.2),
        (LimitConfig(least=2.0), 0.5),
        (LimitConfig(1, 3), 0),
    ],
)
def test_limits_are_of_the_worst_run(limit, excess):
    found = score_design(1, {}, rows(1.0, 3.0), DesignConfig(ends=[FORCE], limits={"force": limit}))
    assert max(found.excess.values()) == pytest.approx(max(excess, 0.0))
    assert found.is_allowed == (excess <= 0)


def test_the_best_is_that_of_the_first_end_then_of_the_next():
    ends = [(2.0, 0.0), (1.0, 4.0), (1.0, 5.0), (0.0, 9.0)]
    designs = [Design(number, {}, 4, 4, values) for number, values in enumerate(ends)]
    designs[3] = replace(designs[3], excess={"grasp": 0.25})
    assert find_best(designs, [FORCE, EndConfig("slip", "most")]) is designs[2]
    assert find_best(designs[3:], [FORCE, FORCE]) is None
    assert find_best([], [FORCE]) is None


COUNT = 2000


@pytest.fixture
def drawn():
    """Three variables without any correlation, also in the sample."""
    columns = np.linalg.qr(np.random.default_rng(1).standard_normal((COUNT, 3)))[0]
    return np.sqrt(COUNT) * columns.T


def cells(values):
    return [repr(float(value)) for value in values]


def of_ranks(correlation):
    """Correlation of the ranks of two normal variables (Pearson, 1907)."""
    return 6 / np.pi * np.arcsin(correlation / 2)


def test_shares_of_independent_variables(drawn):
    a, b, c = drawn
    rows = {
        row.variable: row for row in sensitivities("y", 3 * a - 4 * b, {"a": cells(a), "b": cells(b), "c": cells(c)})
    }
    assert rows["a"].explained == pytest.approx(of_ranks(0.6) ** 2, abs=0.015)
    assert rows["b"].explained == pytest.approx(of_ranks(0.8) ** 2, abs=0.015)
    assert rows["c"].explained < 0.001
    assert rows["a"].slope_of_ranks == pytest.approx(of_ranks(0.6), abs=0.015)
    assert rows["b"].slope_of_ranks == pytest.approx(-of_ranks(0.8), abs=0.015)


def test_choices_without_order():
    """Two of three choices are alike: a third of the runs has another value."""
    choices = np.random.default_rng(2).choice(["sides", "faces", "corners"], COUNT)
    noise = np.random.default_rng(3).standard_normal(COUNT)
    (kind, other) = sensitivities(
        "y", (choices == "faces") + 1e-3 * noise, {"kind": choices.tolist(), "n": cells(noise)}
    )
    assert np.isnan(kind.slope_of_ranks)
    assert kind.explained > 0.6  # the ranks of the noise within a choice are the rest
    assert kind.together > 0.99 * (kind.explained + other.explained)


def test_too_few_designs_tell_nothing():
    assert sensitivities("y", np.arange(3.0), {"a": ["1", "2", "3"]}) == []
    assert sensitivities("y", np.zeros(0), {"a": []}) == []
    assert sensitivities("y", np.ones(9), {"a": cells(range(9))}) == []
    assert len(sensitivities("y", np.arange(9.0), {"a": ["1"] * 9, "b": cells(range(9))})) == 2


MEAN_FORCE, ENERGY = EndConfig("force"), EndConfig("energy")
AXES = [Range("models.gripper.fingers.all.length", 0.1, 0.2), Values("sensor.layout", ("sides", "faces"))]


def found(ends, allowed=True, designs=12):
    rng = np.random.default_rng(1)
    config = DesignConfig("bottle_grasp", vary={"a": 1}, ends=ends)
    study = DesignStudy("study.yaml", config, "bottle_grasp", {}, AXES, {"bottle": {}}, {"cup": {}})
    tried = [Design(0, {}, 4, 4, tuple(2.0 for _ in ends), {"grasp": 0.0})]
    for number in range(1, designs + 1):
        values = {AXES[0].key: float(rng.uniform(0.1, 0.2)), AXES[1].key: AXES[1].values[number % 2]}
        lost = Design(number, values, 1, 4, tuple(np.nan for _ in ends), {"grasp": 0.75})
        held = replace(lost, held=4, ends=tuple(rng.random(len(ends)).tolist()), excess={"grasp": 0.0})
        tried.append(held if allowed else lost)
    tried[3] = Design(3, tried[3].values, refused="a wall of 1.00 mm, below 2 mm", excess={"wall": 0.5})
    row = {"grasp": "held", "force": "1.0", "energy": "2.0"}
    compared = [0, 5] if allowed else [0]
    tested = [(row | {"design": str(i), "object": name}, {}) for i in compared for name in ("bottle", "cup")] * 3
    return DesignResult(study, tried, tried[0], [5, 6] if allowed else [], tried[5] if allowed else None, tested)


def test_tables(tmp_path):
    write_tables(found([MEAN_FORCE, ENERGY]), tmp_path)
    rows = {name: csv_rows(tmp_path / name) for name in (DESIGNS, TESTS, SENSITIVITY)}
    assert [row["design"] for row in rows[DESIGNS]] == [str(i) for i in range(13)]
    assert rows[DESIGNS][3]["reason"] == "a wall of 1.00 mm, below 2 mm"
    assert [row["front"] for row in rows[DESIGNS]].count("True") == 2
    assert [(row["design"], row["object"], row["unseen"], row["held"]) for row in rows[TESTS]] == [
        ("0", "bottle", "False", "3"),
        ("0", "cup", "True", "3"),
        ("5", "bottle", "False", "3"),
        ("5", "cup", "True", "3"),
    ]
    assert {row["end"] for row in rows[SENSITIVITY]} == {"force", "energy"}

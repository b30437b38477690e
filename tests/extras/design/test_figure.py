"""The figure and the tables of a study, also where nothing holds, with one end, and with choices."""

import numpy as np
from csv_rows import csv_rows

from soft_gripper.extras.design.ranking import Design, DesignScore
from soft_gripper.extras.design.run_design import DesignResult
from soft_gripper.extras.design.study_file import DesignConfig, DesignStudy, EndConfig
from soft_gripper.extras.design.study_tables import DESIGNS, SENSITIVITY, TESTS, write_tables
from soft_gripper.runs.sweep.axes import Range, Values

FORCE, ENERGY = EndConfig("force"), EndConfig("energy")
AXES = [Range("models.gripper.fingers.all.length", 0.1, 0.2), Values("sensor.layout", ("sides", "faces"))]


def found(ends, allowed=True, designs=12):
    rng = np.random.default_rng(1)
    config = DesignConfig("bottle_grasp", vary={"a": 1}, ends=ends)
    study = DesignStudy("study.yaml", config, "bottle_grasp", {}, AXES, {"bottle": {}}, {"cup": {}})
    tried = [Design(0, {}, DesignScore(4, 4, tuple(2.0 for _ in ends), {"grasp": 0.0}))]
    for number in range(1, designs + 1):
        values = {AXES[0].key: float(rng.uniform(0.1, 0.2)), AXES[1].key: AXES[1].values[number % 2]}
        score = DesignScore(4, 4, tuple(rng.random(len(ends)).tolist()), {"grasp": 0.0})
        tried.append(
            Design(
                number, values, score if allowed else DesignScore(1, 4, tuple(np.nan for _ in ends), {"grasp": 0.75})
            )
        )
    tried[3] = Design(3, tried[3].values, DesignScore(refused="a wall of 1.00 mm, below 2 mm", excess={"wall": 0.5}))
    row = {"grasp": "held", "force": "1.0", "energy": "2.0"}
    compared = [0, 5] if allowed else [0]
    tested = [(row | {"design": str(i), "object": name}, {}) for i in compared for name in ("bottle", "cup")] * 3
    return DesignResult(study, tried, tried[0], [5, 6] if allowed else [], 5 if allowed else None, tested)


def test_tables(tmp_path):
    write_tables(found([FORCE, ENERGY]), tmp_path)
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

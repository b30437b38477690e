"""The pages of shipped scenarios: what was kept of each run belongs to its criteria, and meets them."""

import pytest
from scenario_pages import STORED, stored_criteria

import soft_gripper as sg
from soft_gripper.runs.success import success_criteria, success_rows

LARGEST = 30e3  # bytes of a picture
QUICKEST = "tip_distance_steps"


@pytest.mark.parametrize("name", sg.scenario_names())
def test_a_scenario_meets_its_criteria(name):
    """As `make scenarios` has found; of other criteria than those of the file nothing is kept."""
    rows = stored_criteria(name)
    assert [row["criterion"] for row in rows] == success_criteria(sg.load_scenario(name))
    assert all(row["met"] == "True" for row in rows)
    assert 0 < (STORED / f"{name}.webp").stat().st_size < LARGEST


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name == QUICKEST else pytest.mark.published)
        for name in sg.scenario_names()
    ],
)
def test_what_is_kept_is_what_a_run_gives(name):
    station = sg.make_station(sg.load_scenario(name))
    rows = success_rows(station, sg.run_station(station))
    for row, kept in zip(rows, stored_criteria(name), strict=True):
        assert (row.criterion, str(row.met)) == (kept["criterion"], kept["met"])
        try:
            assert float(row.measured) == pytest.approx(float(kept["measured"]), rel=0.02)
        except ValueError:
            assert row.measured == kept["measured"]

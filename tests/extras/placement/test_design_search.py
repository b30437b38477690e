"""Sets of paths: small ones are all tried, larger ones are found by exchange, as by brute force."""

from itertools import combinations

import pytest

from soft_gripper.estimators.uncertainty import uncertainty_of
from soft_gripper.extras.placement import design_search
from soft_gripper.extras.placement.catalogue import PATHS, STRAIN, Design
from soft_gripper.extras.placement.design_search import try_sets
from soft_gripper.extras.placement.spatial_scores import Scores
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors


@pytest.fixture(scope="module")
def score(spatial_tasks):
    """Of paths of realistic sensors in two sections."""
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset="realistic")))
    scores = Scores(spatial_tasks, STRAIN, uncertainty_of(errors, finger=0.1))
    return lambda paths: scores(Design(STRAIN, (0.5,), paths)).score


def test_small_sets_are_all_tried(score):
    paths = list(PATHS)[:9]
    tried = try_sets(score, paths, 3)
    assert list(tried) == [chosen for size in (1, 2, 3) for chosen in combinations(paths, size)]
    assert all(tried[chosen] == score(chosen) for chosen in list(tried)[::10])


def test_exchange_finds_what_brute_force_finds(score, monkeypatch):
    """Of all sets of one to four paths among twelve that see bends, twist, or both."""
    chosen = [*list(PATHS)[::2], "outer_rising", "outer_slanted"]
    paths = [path for path in PATHS if path in chosen]
    monkeypatch.setattr(design_search, "EXHAUSTIVE", 0)
    tried = try_sets(score, paths, 4)
    for size in range(1, 5):
        least = min(map(score, combinations(paths, size)))
        assert min(tried[chosen] for chosen in tried if len(chosen) == size) == pytest.approx(least, rel=1e-12)
    assert len(tried) < 400


def test_there_are_no_more_paths_than_there_are(score):
    assert max(map(len, try_sets(len, ["a", "b"], 5))) == 2

"""The example that recognizes what is held: its estimates are those of the blocks, and it tells shapes apart."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario
from studies.benchmark.random_objects import SETS, SHAPES
from studies.benchmark.recognition import MEAN_SAMPLES, Probe, confusion, confusion_figure, probe


@pytest.mark.slow
def test_probes_are_what_the_blocks_estimate_at_the_end_of_every_step():
    scenario = load_scenario("probing_grasp", ["sensor.errors=null"])
    station = make_station(scenario)
    recording = run_station(station)
    found, time = probe(station, recording, 4, np.random.default_rng(0)), recording["time"].values
    for level in range(3):
        (sample,) = np.flatnonzero(np.isclose(time, (level + 1) * scenario.step_duration))
        for i, finger in enumerate(("left_finger", "right_finger")):
            for values, signal in ((found.angles, "estimated_joint_angles"), (found.torques, "external_torque")):
                expected = recording[f"{finger}.{signal}"].values[sample - MEAN_SAMPLES + 1 : sample + 1].mean(axis=0)
                np.testing.assert_allclose(values[0, level, i], expected, atol=1e-12)


def test_a_confusion_counts_grasps_and_is_drawn():
    """Probes that differ by shape and scatter a little are told apart."""
    rng, grasps = np.random.default_rng(1), {}
    centers = {shape: rng.normal(size=(2, 1, 3, 2, 12)) for shape in SHAPES}
    for key in ((set, number, shape) for set in SETS for number in range(8) for shape in SHAPES):
        grasps[key] = {2: Probe(*(centers[key[2]] + 0.1 * rng.normal(size=(2, 2, 3, 2, 12))))}
    found = confusion(grasps, 2)
    np.testing.assert_allclose(found.sum(axis=1), 8)
    assert np.trace(found) > 0.8 * found.sum()
    (axes,) = confusion_figure({2: found}, 8).axes
    assert axes.get_title() == f"2 sections: {100 * np.trace(found) / 32:.1f} % right"

"""Blocks of the user's in many runs at once: those made of steps share one station, others have one for each run."""

import numpy as np
import pytest
from own_blocks import MeanBend

pytest.importorskip("mujoco")

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.simulation import run_many
from soft_gripper.errors import InputError
from soft_gripper.estimators.arcs import arcs_from_readings
from soft_gripper.scenario.scenario_file import changed_scenario

SHORT = {"pressure.steps": {"all": [60e3]}, "pressure.settle": 0.1, "pressure.hold_samples": 5, "engine_step": 0.005}
made = []


class SmoothArcs(ArrayBlock):
    """Arcs from readings that a low-pass filter smooths."""

    def __init__(self, layout, period):
        super().__init__(period)
        self.layout = layout
        self.take("strain", layout.readings)
        begin = np.full(layout.readings, np.nan)
        self.remember("smooth", self.smooth, "strain", begin=begin, keep=lambda smooth: smooth)
        joints = range(layout.finger.segments)
        self.put_out("estimated_joint_angles", self.angles, "smooth", unit="rad", joint=joints)

    def smooth(self, before, strain):
        return np.where(np.isfinite(before), 0.8 * before + 0.2 * strain, strain)

    def angles(self, smooth):
        return self.layout.shared_equally(arcs_from_readings(self.layout, smooth).theta)


def smooth_arcs(layout, gravity, period):
    made.append(layout)
    return SmoothArcs(layout, period)


def mean_bend(layout, gravity, period):
    made.append(layout)
    return MeanBend(layout)


LIMIT = [np.inf]  # of readings


class BreakableArcs(SmoothArcs):
    """Arcs that fail at readings beyond a limit."""

    def smooth(self, before, strain):
        if (strain > LIMIT[0]).any():
            raise ArithmeticError("beyond the limit")
        return super().smooth(before, strain)


def breakable_arcs(layout, gravity, period):
    return BreakableArcs(layout, period)


def runs(function, seeds):
    """Runs of these seeds, made together."""
    changes = {**SHORT, "engine": "mujoco", "sensor.errors.preset": "realistic"}
    name = f"{__name__}:{function.__name__}"
    scenarios = [changed_scenario("free_bending", {**changes, "estimator.type": name, "sensor.seed": i}) for i in seeds]
    made.clear()
    return list(run_many(scenarios))


def angles(function, seeds):
    """Estimated joint angles in runs of these seeds, made together."""
    return [run.recording["left_finger.estimated_joint_angles"].values for run in runs(function, seeds)]


def test_blocks_made_of_steps_share_a_station_and_do_what_each_does_alone():
    together = angles(smooth_arcs, range(3))
    fingers = len(made)
    alone = angles(smooth_arcs, [2])
    assert len(made) == fingers, "one station for three runs"
    np.testing.assert_array_equal(together[2], alone[0])
    assert not np.array_equal(together[1], together[2])


def test_other_blocks_may_remember_a_run_and_have_a_station_for_each():
    angles(mean_bend, [0])
    fingers = len(made)
    angles(mean_bend, range(2))
    assert len(made) == 2 * fingers


def test_a_run_whose_block_fails_is_blamed_on_it_and_the_others_go_on(monkeypatch):
    whole = runs(breakable_arcs, range(4))
    largest = [
        max(float(run.recording[f"{side}_finger.strain"].values.max()) for side in ("left", "right")) for run in whole
    ]
    *_, second, bad = np.argsort(largest)
    monkeypatch.setitem(globals(), "LIMIT", [(largest[second] + largest[bad]) / 2])
    found = runs(breakable_arcs, range(4))
    for seed, (one, other) in enumerate(zip(found, whole, strict=True)):
        if seed == bad:
            assert isinstance(one, InputError)
            said = str(one)
            assert said.startswith(f"scenario: estimator.type = '{__name__}:breakable_arcs': ")
            assert "failed at t = 0." in said
            assert said.endswith("ArithmeticError: beyond the limit")
        else:
            name = "left_finger.estimated_joint_angles"
            np.testing.assert_array_equal(one.recording[name].values, other.recording[name].values)

"""What a grasp is judged by, from signals that are made up."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from task_rules import motion as arm_motion

from soft_gripper.control.task import Phase
from soft_gripper.diagrams.recording import Recording
from soft_gripper.runs.scores.grasp import (
    IMPULSE_TIME,
    GraspSignals,
    Sizes,
    finger_grips,
    judge,
    largest_impulse,
    pump_energy,
    slip_ratio,
    stiffness,
    verdict,
)
from soft_gripper.runs.scores.recorded_grasps import touched_instead
from soft_gripper.runs.scores.recorded_object import precedes_put_down
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names

TIME = np.arange(0, 2.005, 0.01)
WEIGHT = 0.5  # N, carried by the friction of two fingers


def signals(normal=1.0, support=0.0):
    """Two fingers press with a normal force (T) N on opposite faces; others carry `support`, (T) N."""
    pressing = np.broadcast_to(normal, len(TIME))
    friction = np.zeros((len(TIME), 2, 3))
    friction[:, :, 2] = WEIGHT / 2 * (pressing > 0)[:, None]
    both = np.stack([pressing, 0.9 * pressing], axis=-1)
    still = np.broadcast_to(np.eye(3), (len(TIME), 3, 3))
    supports = np.broadcast_to(support, len(TIME))
    place = np.zeros((len(TIME), 3))
    return GraspSignals(
        TIME, both, friction, 1e-5 * (both > 0), 1e5 * both, supports, place, still, WEIGHT, np.array([0.8, 0.8])
    )


def judged(of, speed=0.0):
    return judge(of, finger_grips(of, ["one", "other"]), 0.0, speed, Sizes(), 0.0)


def test_a_held_object_is_held_by_forces_at_the_end():
    found = judged(signals())
    assert found.grasp == "held"
    assert (found.normal_force_n, found.friction_force_n) == pytest.approx((1.0, WEIGHT / 2))
    assert found.slip_ratio == pytest.approx(WEIGHT / (0.8 * 1.9))
    assert found.least_force_n == pytest.approx(found.slip_ratio)
    assert found.contact_area_mm2 == pytest.approx(20)
    assert (found.mean_pressure_kpa, found.largest_pressure_kpa) == pytest.approx((95, 100))
    assert "estimated_width_mm" not in vars(found), "an estimate without a band"


@pytest.mark.parametrize(
    ("of", "speed", "word"),
    [
        (signals(0.0, WEIGHT), np.nan, "never touched"),
        (signals(1.0 * (TIME < 1.9)), np.nan, "dropped"),
        (signals(1.0 * (TIME < 1.9), WEIGHT), np.nan, "dropped"),
        (signals(), 2e-3, "slipping"),
        (signals(1.0, 0.8 * WEIGHT), 0.0, "held"),  # it has come down on a table, and could be lifted
        (signals(1.0, 0.95 * WEIGHT), 0.0, "resting"),  # what is squeezed but not carried
        (signals(1.0, 1.2 * WEIGHT), 0.0, "resting"),  # what is pressed down
        (signals(0.3, 0.3 * WEIGHT), 0.0, "resting"),  # with friction for 0.46 N of 0.5 N
        (signals(1.0, 0.3 * WEIGHT), 2e-3, "slipping"),
        (signals(1.0, 0.05 * WEIGHT), 5e-4, "held"),
        (signals(1.0, np.where(TIME < 1.0, WEIGHT, 0.0)), 0.0, "held"),
    ],
)
def test_the_verdict_in_one_word(of, speed, word):
    assert verdict(of, speed) == judged(of, speed).grasp == word


def test_motion_counts_while_held_only():
    moved = signals(1.0, np.where(TIME < 1.0, WEIGHT, 0.0))
    moved.place[:100] = [0.5, 0.5, 0.5]
    moved.place[150] = [0, -2e-3, 0]
    found = judged(moved)
    assert (found.moved_mm, found.sideways_play_mm, found.turned_deg) == pytest.approx((2.0, 2.0, 0.0))
    assert np.isnan(judged(signals(0.0, WEIGHT)).moved_mm)


def test_friction_that_fingers_apply_against_each_other_carries_nothing():
    """Each pulls with 0.6 N along the object; a weight of 0.4 N is left."""
    friction = np.array([[0.6, 0, 0.2], [-0.6, 0, 0.2]])
    assert slip_ratio(np.array([1.0, 1.0]), friction, np.array([0.8, 0.8])) == pytest.approx(0.4 / 1.6)
    assert np.isnan(slip_ratio(np.zeros(2), 0 * friction, np.array([0.8, 0.8])))


@pytest.mark.parametrize("step", [0.01, 0.005, 0.002, 0.001])
def test_an_impulse_does_not_depend_on_the_samples(step):
    """Of a held force of 0.7 N, and of a blow of 30 mN s that ends within 10 ms, however it is sampled."""
    time = np.arange(0, 1 + step / 2, step)
    blow = np.where(np.abs(time - 0.5) < step / 2, 0.03 / step, 0.0)
    assert largest_impulse(time, 0.7 + 0 * time) == pytest.approx(0.7 * IMPULSE_TIME)
    assert largest_impulse(time, 0.7 + blow) == pytest.approx(0.7 * IMPULSE_TIME + 0.03, rel=1e-6)
    assert largest_impulse(time[:1], blow[:1]) == 0


def test_the_pump_works_where_the_volume_grows():
    """At 100 kPa by 1 cm^3, back to nothing, and up again at half the pressure; another chamber does nothing."""
    volume = 1e-6 * np.array([0, 1, 0, 1])
    pressure = 1e5 * np.array([1, 1, 0.5, 0.5])
    assert pump_energy(np.stack([pressure, pressure], 1), np.stack([volume, 0 * volume], 1)) == pytest.approx(0.15)


def test_stiffness_is_the_slope_of_force_over_width():
    width = np.linspace(0.044, 0.042, 50)
    force = 500 * (0.045 - width)
    assert stiffness(width, force) == pytest.approx(500)
    assert stiffness(np.r_[np.nan, width], np.r_[9.0, force]) == pytest.approx(500)
    for unknown in (0 * width + 0.044, width[::-1], np.nan * width):
        assert np.isnan(stiffness(unknown, force))


def test_a_width_that_does_not_follow_the_force_gives_no_stiffness():
    noise = np.random.default_rng(1).normal(0, 1e-3, 200)
    assert np.isnan(stiffness(0.044 + noise, np.linspace(0.5, 1.0, 200)))


def test_the_impulse_of_a_finger_is_its_own():
    one, other = finger_grips(signals(), ["one", "other"])
    assert (one.largest_impulse_mns, other.largest_impulse_mns) == pytest.approx((50, 45))
    assert replace(one, finger="other") != other


def judged_phases(*holds, reached=None):
    """The numbers of the phases that count, of a task whose phases hold an object or not, before two rescues."""
    end = len(holds) + 2
    phases = [
        Phase(f"phase {i}", arm_motion(1.0), np.nan, i + 1 if i + 1 < len(holds) else end, holds=held)
        for i, held in enumerate(holds)
    ]
    rescues = [Phase(name, arm_motion(1.0), np.nan, end) for name in ("rise", "return")]
    numbers = np.repeat(np.arange(len(holds) if reached is None else reached), 3)
    counted = precedes_put_down(numbers, [*phases, *rescues])
    return sorted({int(number) for number in numbers[counted]})


@pytest.mark.parametrize(
    ("holds", "reached", "counted"),
    [
        ((False, True, True), None, [0, 1, 2]),  # it is held to the end
        ((False, True), None, [0, 1]),
        ((False, True, True, False), None, [0, 1]),  # the last one puts it down
        ((False, True, False), None, [0, 1]),
        ((False, False), None, [0, 1]),
        ((False, False, True, True), 2, [0, 1]),  # it was never grasped
    ],
)
def test_a_hold_counts_to_its_end_unless_it_puts_the_object_down(holds, reached, counted):
    assert judged_phases(*holds, reached=reached) == counted


def test_shipped_tasks_are_judged_before_they_put_the_object_down():
    tasks = {name: load_scenario(name).task for name in scenario_names()}
    tasks = {name: task for name, task in tasks.items() if task is not None and any(p.holds for p in task.phases)}
    assert len(tasks) >= 4
    for name, task in tasks.items():
        last_counted = judged_phases(*(phase.holds for phase in task.phases))[-1]
        assert task.phases[last_counted + 1].name == "lower", name


@pytest.mark.parametrize(
    ("scenario", "on_left", "phrase"),
    [
        ("box_grasp", [0.0, 0.0], ""),
        ("box_grasp", [0.1, 0.7], "left_finger touches table, with up to 0.70 N"),
        ("pick_and_place_box", [0.1, 0.7], "left_finger touches workbench, with up to 0.70 N"),
    ],
)
def test_fingers_that_touch_the_table_say_so(scenario, on_left, phrase):
    """What presses on the box does not count."""
    on_box = np.array([[0.0, 0.5], [0.3, 0.2]])
    forces = {
        "left_finger.normal_force": ("time", on_box[:, 0] + on_left),
        "right_finger.normal_force": ("time", on_box[:, 1]),
        "box.grip_normal_force": (("time", "finger"), on_box),
    }
    fingers = [SimpleNamespace(name=f"{side}_finger", model_name="gripper") for side in ("left", "right")]
    station = SimpleNamespace(
        scenario=load_scenario(scenario), fingers=fingers, logs=SimpleNamespace(signals=forces), task=None
    )
    assert touched_instead(station, Recording(xr.Dataset(forces))) == phrase

"""Simulated recordings against statics, closed forms, and rigid motions of their mounting."""

from dataclasses import replace

import numpy as np
import pytest
from identified import CLOSES, OPENS, REFERENCE, RELEASE, release, step

from soft_gripper.extras.hardware.identification.simulated_motion import (
    Setup,
    _chamber_pressure,
    simulated_markers,
    tip_motion,
)
from soft_gripper.fingers.finger_parts import CreepBranch, PressureLaw, TipLoad
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles


def test_released_beam_comes_to_rest_in_balance(beam):
    damped = replace(beam, relaxation_time=0.05)
    tip = tip_motion(damped, Setup(), release(3.0))
    chain = forward_kinematics(resting_angles(beam, 0.0, 9.81j), beam.segment_length)
    assert tip.tip[-1] == pytest.approx(complex(chain.tip), abs=1e-3 * abs(chain.tip - beam.length))
    assert tip.heading[-1] == pytest.approx(float(chain.headings[-1]), rel=1e-3)
    assert tip.tip[0] == pytest.approx(beam.length)


def taking(share: float, highest: float = 3e4) -> PressureLaw:
    """The highest pressure takes a share of the stiffness, and bends a light finger as far as without a law."""
    effective = (1 - share) * highest
    return PressureLaw((0.0, highest), (0.0, effective), (0.0, share))


def test_an_emptied_finger_remembers_how_far_it_was_bent(hollow):
    """Its branch of creep rests on the share of its bend, which fades by exp(-(1 - share) t / time)."""
    law, share, time = taking(0.5), 0.2, 0.6
    creeping = replace(hollow, relaxation_time=0.01, pressure_law=law, creep=(CreepBranch(share, time),))
    motion = replace(step(3e4, 4.5), gravity=np.zeros(3), events=(OPENS, OPENS + 3.5))
    tip = tip_motion(creeping, Setup(fill_time=5e-3, swelling=0.0), motion)
    held, late = tip.heading[np.searchsorted(tip.time, [3.45, 3.8])]
    assert late == pytest.approx(share * held * np.exp(-(1 - share) * 0.3 / time), rel=0.1)


@pytest.mark.parametrize("share", [0.0, 0.1])
def test_pressure_that_takes_stiffness_multiplies_what_weight_and_creep_bend(hollow, share):
    """As what it bends itself: the finger rests as under a gravity, and with a share of creep, three times as large."""
    law = PressureLaw((0.0, 3e4), (0.0, 1.5e4), (0.0, 2 / 3))  # further by 3

    def creeping(share):
        creep = (CreepBranch(share, 0.1),) if share else ()
        return replace(hollow, relaxation_time=0.05, pressure_law=law, creep=creep)

    tip = tip_motion(creeping(share), Setup(), replace(step(3e4, 3.0), events=(OPENS, 2.9)))
    alike = replace(creeping(3 * share), pressure_law=PressureLaw((0.0, 3e4), (0.0, 4.5e4)))
    rests = resting_angles(alike, 3e4, 3 * 9.81j).sum()
    assert rests == pytest.approx(resting_angles(creeping(share), 3e4, 9.81j).sum(), rel=1e-9)
    assert tip.heading[np.searchsorted(tip.time, 2.5)] == pytest.approx(rests, rel=3e-3)


def test_mounting_moves_markers_rigidly(beam):
    """A mounting that is moved and turned, with gravity and markers turned along, shows the same from there."""
    motion, setup = release(1.0), Setup(mounting_x=0.004, mounting_z=-0.003, mounting_angle=0.2)
    place = (setup.mounting_z + 1j * setup.mounting_x, np.exp(0.2j))
    weight = 9.81j * place[1]
    along = replace(motion, reference=place[0] + place[1] * REFERENCE, gravity=np.array([weight.imag, 0, weight.real]))
    np.testing.assert_allclose(
        simulated_markers(beam, setup, along), place[0] + place[1] * simulated_markers(beam, Setup(), motion), atol=1e-9
    )


def test_load_and_markers_add_up(beam):
    loaded = replace(release(1.0), load=TipLoad(0.05, -0.015, 0.0))
    middle = complex(REFERENCE.mean()) - beam.length
    together = TipLoad(0.07, (-0.015 * 0.05 + middle.imag * 0.02) / 0.07, middle.real * 0.02 / 0.07)
    tips = [
        tip_motion(beam, Setup(marker_mass=0.02), loaded),
        tip_motion(beam, Setup(), replace(loaded, load=together)),
    ]
    np.testing.assert_allclose(tips[0].tip, tips[1].tip, atol=1e-12)


@pytest.mark.parametrize("lets_go", [0.06, 0.2])
def test_hand_that_lets_go_slowly_leaves_less_of_the_swing(beam, lets_go):
    """Of an oscillator that is loaded evenly over a time T, sin(pi f T) / (pi f T) of the amplitude."""
    light = replace(beam, relaxation_time=1e-4, creep=())
    sudden, slow = (
        tip_motion(light, Setup(), replace(release(2.6, 0.5), events=(RELEASE, RELEASE + time)))
        for time in (0.0, lets_go)
    )
    swings = [motion.heading[(motion.time > 0.3) & (motion.time < 1.2)] for motion in (sudden, slow)]
    rests = float(resting_angles(light, 0.0, 0.5j).sum())
    crossings = np.flatnonzero(np.diff(np.sign(swings[0] - rests)))
    frequency = (len(crossings) - 1) / 2 / (0.01 * (crossings[-1] - crossings[0]))
    left = np.ptp(swings[1]) / np.ptp(swings[0])
    assert left == pytest.approx(abs(np.sinc(frequency * lets_go)), abs=0.05)


def test_load_bends_as_far_as_it_weighs_where_it_hangs(beam):
    hung = replace(release(3.0), load=TipLoad(0.05, 0.0, 0.0))
    damped = replace(beam, relaxation_time=0.05)
    moved = tip_motion(damped, Setup(load_x=-0.015, load_z=0.01), hung)
    loaded = replace(damped, tip_load=TipLoad(0.05, -0.015, 0.01))
    assert moved.heading[-1] == pytest.approx(resting_angles(loaded, 0.0, 9.81j).sum(), rel=1e-3)


def test_chamber_fills_and_empties_as_through_an_orifice(hollow):
    motion, setup = step(3e4), Setup(fill_time=0.05, swelling=0.0)
    pressure, time = _chamber_pressure(hollow, setup, motion, 1.3), np.linspace(0, 1.3, 53)
    within = 0.05 * np.sqrt(3e4 / 1e4)  # s, the more there is to fill, the longer
    open_for = CLOSES - OPENS
    filled = 3e4 * (1 - np.clip(1 - time / within, 0, 1) ** 2)  # of dp/dt = k sqrt(supply - p)
    emptied = 3e4 * np.clip(1 - (time - open_for) / within, 0, 1) ** 2
    expected = np.where(time < open_for, filled, emptied)
    found = [float(pressure.value(t)[0, 0]) for t in time]
    np.testing.assert_allclose(found, expected, atol=2e-3 * 3e4)


@pytest.mark.parametrize("supply", [3e4, -3e4, 2e3])
def test_supply_that_lags_comes_up_to_its_pressure(hollow, supply):
    """It lacks 3 kPa at first, of vacuum too; all of a pressure that is smaller than that."""
    setup = Setup(fill_time=0.01, swelling=0.0, supply_lag=3e3, supply_time=0.3)
    pressure = _chamber_pressure(hollow, setup, step(supply), 1.3)
    time = np.linspace(0.1, 0.8, 8)
    expected = supply - np.sign(supply) * min(abs(supply), 3e3) * np.exp(-time / 0.3)
    np.testing.assert_allclose([float(pressure.value(t)[0, 0]) for t in time], expected, rtol=1e-3)


@pytest.mark.parametrize("sign", [1, -1])
def test_chamber_that_swells_fills_more_slowly(hollow, sign):
    law = PressureLaw(
        (-5e4, -3e4, -1e4, 0.0, 1e4, 3e4, 5e4), (-15e4, -9e4, -1e4, 0.0, 1e4, 9e4, 15e4)
    )  # bend: to 3 times
    swelling = replace(hollow, pressure_law=law)
    pressure = _chamber_pressure(swelling, Setup(fill_time=0.2, swelling=1.0), step(sign * 5e4), 1.3)
    late = np.array([0.75, 0.8])  # s, above 3e4 Pa, where the chamber takes three times as much
    roots = [np.sqrt(sign * (sign * 5e4 - float(pressure.value(t)[0, 0]))) for t in late]
    assert roots[1] > 0.0
    assert 5e4 - roots[0] ** 2 > 3e4
    assert (roots[0] - roots[1]) / 0.05 == pytest.approx(np.sqrt(1e4) / (3 * 0.2), rel=0.02)

"""Reported force, deviation and interval are of one posterior: compared with sums over all cells and forces."""

import numpy as np
import pytest
from loaded_fingers import Push, in_balance

from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from studies.contacts.statics import contacts_in_space, finger_in_space

ASSUMED = Uncertainty(reading=1.5e-3, bend_variation=0.0)


def dense(found, usual, largest):
    """Forces, (K), and the density of cells and logarithms of force at them, (C, K), of one sample."""
    forces = np.geomspace(largest / 1000, largest, 2001)
    fits = [values[0][:, None] for values in found.fits]
    force, std, misfit, spread = fits
    logs = -(misfit + ((forces - force) / std) ** 2 + spread + (forces / usual) ** 2) / 2
    density = found.cells.prior[:, None] * np.exp(logs - logs.max())
    return forces, density / density.sum()


def check(density, forces, across, reported, std, interval):
    """The force is the most probable one; the deviation, of forces times their part across, is about it."""
    cell, number = np.unravel_index(density.argmax(), density.shape)
    assert reported == pytest.approx(across[cell] * forces[number], rel=0.1), "the place is within the cell"
    distance = across[:, None] * forces - reported
    assert std == pytest.approx(np.sqrt((density * distance**2).sum()), rel=0.1)
    assert interval[0] <= forces[number] * 1.001
    assert interval[2] >= forces[number] * 0.999
    shares = np.cumsum(density.sum(axis=0))
    least, median, most = np.interp(interval, forces, shares)
    assert median == pytest.approx(0.5, abs=0.02)
    assert 0.94 < most - least < 0.99


@pytest.mark.parametrize("sections", [2, 4])
@pytest.mark.parametrize(("place", "force"), [(0.25, 0.8), (0.45, -0.5), (0.55, 0.7), (0.8, -0.4), (1.0, 0.6)])
def test_in_the_plane(shipped_finger, sections, place, force):
    layout, s = SensorLayout(shipped_finger, sections), place * shipped_finger.length
    shape = ContactShape(layout, ASSUMED)
    q = in_balance(shipped_finger, 60e3, 9.81, [Push(s, force, 0.3 * abs(force))])
    readings, driving = layout.response.reading(extension_ratios(layout, q)), shipped_finger.pressure_torque(60e3)
    given = readings[None], driving[None], np.array([[0.0, 0.0, 9.81]])
    contact, known = shape(*given).contact, shape.posterior(*given)
    assert contact.force != 0
    found = shape._explain(shape._gaussian(*given).q, *given)[0].cell_fits
    forces, density = dense(found, shape.contact.mechanics.usual_force, ASSUMED.largest_force)
    check(density, forces, found.cells.side, contact.force[0], contact.force_std[0], known.force_interval[0])


def test_in_space():
    """Of smooth contacts on all faces: the part across the finger, of which there is none on its sides."""
    layout = sensor_layout(finger_in_space(), SensorConfig(layout="four_faces_and_diagonal", sections=2))
    shape, contacts = ContactShape(layout, ASSUMED), contacts_in_space(12, 0.0, 3)
    driving = np.zeros(contacts.q.shape)
    driving[:, : finger_in_space().segments] = finger_in_space().pressure_torque(contacts.pressure)
    readings = layout.read(contacts.q)
    given = readings, driving, contacts.gravity
    contact, known = shape(*given).contact, shape.posterior(*given)
    checked = 0
    for i in np.flatnonzero(np.linalg.norm(contact.vector, axis=-1) > 0):
        sample = tuple(values[i : i + 1] for values in given)
        found = shape._explain(shape._gaussian(*sample).q, *sample)[0].cell_fits
        forces, density = dense(found, shape.contact.mechanics.usual_force, ASSUMED.largest_force)
        number = density.max(axis=0).argmax()
        assert known.force_interval[i, 0] <= forces[number] * 1.001
        assert known.force_interval[i, 2] >= forces[number] * 0.999
        cell = density.max(axis=1).argmax()
        assert np.linalg.norm(contact.vector[i]) == pytest.approx(forces[number], rel=0.2), "friction adds to it"
        assert contact.side[i] == shape.contact.surface.angle[cell]
        rms = np.sqrt((density.sum(axis=0) * (forces - forces[number]) ** 2).sum())
        assert np.sqrt(np.trace(contact.vector_covariance[i])) > 0.9 * rms
        checked += 1
    assert checked > 4

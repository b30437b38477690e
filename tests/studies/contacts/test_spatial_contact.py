"""Contacts in space: what a force does to the readings, forces found again, and the posterior by dense conditioning."""

from dataclasses import fields, replace

import numpy as np
import pytest

from soft_gripper.estimators.contact import ContactShape, _force_vectors, _vector_with_covariance
from soft_gripper.estimators.force_posterior import NOTHING
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.fingers.spatial_chain import resting_positions, spatial_chain, weights
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from studies.contacts.contacts import Contacts
from studies.contacts.statics import contacts_in_space, finger_in_space

GRAVITY = np.array([0.0, 0.0, 9.81])
INNER, LEFT, OUTER, RIGHT = 1, 3, 5, 7


WAYS = ("bending", "sideways", "twist")


def estimator(sections=2, name="four_faces_and_diagonal", **assumed):
    layout = sensor_layout(finger_in_space(), SensorConfig(layout=name, sections=sections))
    return ContactShape(layout, Uncertainty(**{"bend_per_pressure": EXACT, **assumed}))


def driving(pressure, finger=None):
    finger = finger or finger_in_space()
    torque = finger.pressure_torque(np.asarray(pressure, dtype=float))
    return np.concatenate([torque, np.zeros((*torque.shape[:-1], 2 * finger.segments))], axis=-1)


def read(found, contacts, noise=0.0):
    """Readings, driving torque and gravity of contacts."""
    exact = found.layout.predict(contacts.q)
    noisy = exact + noise * np.random.default_rng(7).standard_normal(exact.shape)
    return found.layout.response.reading(1 + noisy), driving(contacts.pressure), contacts.gravity


@pytest.mark.slow
def test_smooth_forces_on_all_faces_are_found():
    """Medians: 3 % of the magnitude, 5 degrees of the direction, 2 % of the length, beyond a third of it."""
    contacts, found = contacts_in_space(130, 0.0, 11), estimator()
    contacts = contacts.subset(contacts.arc_length > finger_in_space().length / 3)
    shape = found(*read(found, contacts))
    contact, true = shape.contact, np.linalg.norm(contacts.force, axis=-1)
    size = np.linalg.norm(contact.vector, axis=-1)
    cosine = (contact.vector * contacts.force).sum(axis=-1) / np.maximum(size, 1e-9) / true
    assert np.median(np.abs(size / true - 1)) < 0.03
    assert np.median(np.degrees(np.arccos(np.clip(cosine, -1, 1)))) < 5
    assert np.nanmedian(np.abs(contact.arc_length - contacts.arc_length)) < 0.02 * finger_in_space().length
    known = found.posterior(*read(found, contacts))
    within = (known.force_set[:, 0] <= contacts.normal_force) & (contacts.normal_force <= known.force_set[:, 1])
    assert within.mean() > 0.92
    assert not (contacts.normal_force > known.force_bounds[:, 0]).mean() > 0.08


@pytest.mark.slow
def test_stated_deviations_cover_the_vector():
    contacts, found = contacts_in_space(120, 0.3, 12), estimator(4, reading=1e-3)
    contact = found(*read(found, contacts, 1e-3)).contact
    touched = np.linalg.norm(contact.vector, axis=-1) > 0
    std = np.sqrt(np.diagonal(contact.vector_covariance[touched], axis1=-2, axis2=-1))
    error = np.abs(contact.vector - contacts.force)[touched] < 2 * std
    assert (error.mean(axis=0) > 0.85).all()


def free_fingers(pressures):
    """Contacts without a force."""
    finger, gravity = finger_in_space(), np.tile(GRAVITY, (len(pressures), 1))
    chain = spatial_chain(finger)
    torque = chain.interleaved({"bending": finger.pressure_torque(pressures)})
    q = resting_positions(chain, chain.interleaved(finger.stiffnesses), torque, weights(finger, chain, gravity))
    nothing = np.zeros(len(pressures))
    forces, none = np.zeros((len(nothing), 3)), np.zeros_like(q)
    return Contacts(
        finger,
        q[:, np.argsort(chain.position_indices(WAYS))],
        pressures,
        gravity,
        nothing,
        forces,
        none,
        *[nothing] * 3,
    )


def test_nothing_touches_a_finger_that_is_free():
    found, contacts = estimator(), free_fingers(np.array([0.0, 40e3, 90e3]))
    shape = found(*read(found, contacts))
    assert (shape.contact.vector == 0).all()
    assert np.isnan(shape.contact.arc_length).all()
    assert np.isnan(shape.contact.side).all()
    known = found.posterior(*read(found, contacts))
    assert (known.answer == NOTHING).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [21, 23, 28, 30, 31])
def test_the_posterior_is_that_of_dense_conditioning(seed):
    """Every cell with every force, and with what is uncertain in it at that force, instead of at the likeliest one.

    Where a force is hardly seen, which it is not here, this makes a difference: the lower end is too small there.
    """
    found = estimator(reading=1e-3, largest_force=3.0, friction=0.45)
    contacts = contacts_in_space(6, 0.2, seed)
    sample = contacts.subset(np.array([int(np.argmax(contacts.arc_length))]))
    given, largest = read(found, sample, 1e-3), found.uncertainty.largest_force
    fit = found._explain(found._gaussian(*given).q, *given)[0].cell_fits
    r, c, spreads, prior = fit.r[0], fit.cells.response[0], fit.cells.deviations[0], fit.cells.prior
    forces = largest * np.logspace(-3, 0, 1201)
    inside, density = spreads.swapaxes(-1, -2) @ spreads, np.empty(len(forces))
    for i, force in enumerate(forces):
        covariance, rest = np.eye(len(r)) + force**2 * inside, r - force * c
        explained = (rest * np.linalg.solve(covariance, rest[..., None])[..., 0]).sum(axis=-1)
        usual = np.exp(-((force / found.contact.mechanics.usual_force) ** 2) / 2)
        density[i] = usual * (prior * np.exp(-explained / 2) / np.sqrt(np.linalg.det(covariance))).sum()
    known = found.posterior(*given)
    share = np.append(0.0, np.cumsum(density[1:] + density[:-1]))
    least, median, most = known.force_interval[0]
    below, above = np.interp([least, most], forces, share / share[-1])
    assert median == pytest.approx(np.interp(0.5, share / share[-1], forces), rel=0.05)
    assert (
        0.925 < above - below < 0.985
    )  # both intervals of 95 % hold up to 97.5 %; the likeliest force costs up to 2 %


def test_deviations_of_a_vector_are_those_of_its_size_and_friction():
    """The covariance is propagated by finite differences of the force in every uncertain number."""
    rng = np.random.default_rng(5)
    directions, force, std, z = rng.normal(size=(3, 3)), np.array(0.8), np.array(0.05), rng.normal(size=5)
    half, R = rng.normal(size=(5, 5)), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    of_z, turn = half @ half.T, rng.normal(size=5)

    def vector(force, z):
        return force * R @ (directions[0] + z[0] * directions[1] + z[1] * directions[2])

    step = 1e-6
    by_z = np.transpose([(vector(force, z + step * e) - vector(force, z)) / step for e in np.eye(5)])
    by_force = (vector(force + step, z + step * turn) - vector(force, z)) / step  # a larger force takes back friction
    local = _force_vectors(directions[None], force[None], std[None], z[None], of_z[None], turn[None])
    found, covariance = _vector_with_covariance(np.ones(1), local @ R.T)
    np.testing.assert_allclose(found, vector(force, z), rtol=1e-12)
    np.testing.assert_allclose(covariance, by_z @ of_z @ by_z.T + std**2 * np.outer(by_force, by_force), rtol=1e-6)


@pytest.mark.parametrize("reading", [1e3, 1e-7])
def test_a_place_is_as_uncertain_as_readings_leave_it_within_the_cell_that_is_pressed(bent, reading):
    """Readings without information leave the whole length of a cell, of which 1 / sqrt(12) is the deviation."""
    shape = estimator(reading=reading, angle=0.0, bend_per_pressure=0.0)
    q, surface = 0.05 * bent(36), shape.contact.surface
    (number,) = np.flatnonzero((surface.side == INNER) & (surface.place == 37) & ~surface.rough)
    one = {field.name: getattr(surface, field.name)[[number]] for field in fields(surface)}
    vars(shape.contact)["surface"] = replace(surface, **one)
    left, _ = shape._linearize(q, shape.layout.read(q), np.zeros(36), GRAVITY)
    left = left._replace(residual=shape.contact.cells(left.q, left.bent, left.slopes).response[0])
    contact, *_ = shape.contact.best_contact(shape.contact.explain(left))
    length = shape.layout.finger.length / (surface.place.max() + 1)
    if reading > 1:
        assert contact.arc_length_std == pytest.approx(length / np.sqrt(12), rel=1e-6)
    else:
        assert contact.arc_length_std < 0.1 * length
    assert contact.arc_length == pytest.approx(surface.arc_length[number], abs=0.1 * length)

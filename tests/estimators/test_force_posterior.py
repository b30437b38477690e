"""The posterior of one force, compared with dense sums over forces and with random draws from the prior."""

import numpy as np
import pytest
from loaded_fingers import Push, in_balance, vector
from scipy.optimize import nnls
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import chdtri, ndtr

from soft_gripper.estimators.batches import LazyArray
from soft_gripper.estimators.contact import ContactShape, SurfaceContact
from soft_gripper.estimators.force_posterior import (
    _MAX_STDS,
    _NODES_PER_STD,
    HERE,
    NOTHING,
    SOMEWHERE,
    Cells,
    ForcePrior,
    _extend_piece,
    _interval,
    _normal_integral,
    cell_posterior,
    contact_posterior,
    fit_cells,
    whiten,
)
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

LENGTH, LARGEST, NEAREST = 0.12, 10.0, 0.036  # m, N, m
POSSIBLE = ForcePrior(2.0, LARGEST)
COVARIANCE = np.array([[4.0, 1.0], [1.0, 2.0]]) * 1e-6  # rad^2
FORCES = np.geomspace(LARGEST / 1000, LARGEST, 40_001)


def few_cells(count=12, width=0.0):
    """Those of a cantilever of two sections, on both sides; with a width, they overlap."""
    place, side = np.tile(np.arange(count), 2), np.repeat([-1, 1], count)
    lever = (place + 0.5) / count
    across = 0.05 * np.stack([lever**2, np.maximum(lever - 0.5, 0) ** 2], axis=-1)
    spreads = width * np.stack([np.gradient(lever)[:, None] * across, across[:, ::-1]], axis=-2)
    return Cells(side[:, None] * across, spreads, place, side, np.full(2 * count, 0.5 / count), np.pi * (side < 0))


def posterior(r, covariance, read, cells, forces=POSSIBLE):
    """The posterior of one force on a finger at rest."""
    found = fit_cells(*whiten(r, covariance, cells), forces.max_force)
    in_cells = cell_posterior(found, read, forces)
    return contact_posterior(
        found, in_cells, LazyArray(lambda: in_cells), read, LENGTH, forces, NEAREST, np.zeros(()), found.cells
    )


def dense(r, cells):
    """Chi-squared, (C, K), and likelihood relative to that of nothing, by full matrices for every cell and force."""
    precision, chi_squared, likelihood = np.linalg.inv(COVARIANCE), [], []
    for c, spreads in zip(cells.response, cells.deviations, strict=True):
        best = np.clip(c @ precision @ r / (c @ precision @ c), 0, LARGEST)
        R = COVARIANCE + best**2 * spreads.T @ spreads
        left = r - FORCES[:, None] * c
        misfit = np.einsum("ks,st,kt->k", left, np.linalg.inv(R), left)
        chi_squared.append(misfit)
        density = np.exp(-misfit / 2 + r @ precision @ r / 2) / np.sqrt(np.linalg.det(R) / np.linalg.det(COVARIANCE))
        likelihood.append(density)
    return np.array(chi_squared), np.array(likelihood)


@pytest.mark.parametrize("width", [0.0, 0.3])
@pytest.mark.parametrize("r", [(0.03, 0.004), (0.008, 0.0), (-0.02, -0.006), (0.002, 0.001)])
def test_the_posterior_is_the_dense_sum(r, width):
    """Median and both intervals of 95 %, the shortest and that with equal tails, within 3 % or 2 mN; the mean force,
    by cells, within 2 % or 70 mN; the probability of a contact within 1e-3; set and bounds within a step.
    """
    cells = few_cells(width=width)
    found = posterior(np.array(r), COVARIANCE, np.array(2), cells)
    chi_squared, likelihood = dense(np.array(r), cells)
    assert found.misfit < 1
    prior = np.exp(-((FORCES / POSSIBLE.usual_force) ** 2) / 2)  # of forces that are equally spaced in their logarithm
    by_force = cells.prior @ likelihood * prior
    of_cells = cell_posterior(fit_cells(*whiten(np.array(r), COVARIANCE, cells), LARGEST), np.array(2), POSSIBLE)
    assert of_cells.weight @ of_cells.mean == pytest.approx(by_force @ FORCES / by_force.sum(), rel=0.02, abs=0.07)
    upto = by_force.cumsum() / by_force.sum()
    lows = np.linspace(0, 0.05, 501)
    low, high = (np.interp(lows + share, upto, FORCES) for share in (0.0, 0.95))
    both = [int((high - low).argmin()), 250]
    expected = low[both].min(), np.interp(0.5, upto, FORCES), high[both].max()
    np.testing.assert_allclose(found.force_interval, expected, rtol=0.03, atol=2e-3)
    assert found.probability == pytest.approx(1 / (1 + prior.mean() / by_force.mean()), abs=1e-3)
    inside = FORCES[(chi_squared <= chi_squared.min() + 3.84).any(axis=0)]
    np.testing.assert_allclose(found.force_set, [inside[0], inside[-1]], rtol=2e-3, atol=LARGEST / 1000)
    ends = (cells.place + 1) / 12 * LENGTH
    for bound, possible in zip(
        np.nan_to_num(found.force_bounds[:2], nan=LARGEST), (ends > 0, ends > NEAREST), strict=True
    ):
        these = chi_squared[possible]
        assert bound == pytest.approx(FORCES[(these <= these.min() + 2.71).any(axis=0)][-1], rel=2e-3)


def test_the_second_mode_is_the_likeliest_place_that_does_not_adjoin_the_first():
    place, side = np.tile(np.arange(3), 2), np.repeat([-1, 1], 3)
    response = side[:, None] * np.tile([[0.05, 0.0], [0.0, 0.05], [0.04, 5e-4]], (2, 1))
    cells = Cells(response, np.zeros((6, 0, 2)), place, side, np.full(6, 1 / 6), np.pi * (side < 0))
    found = posterior(response[3], COVARIANCE, np.array(2), cells)
    np.testing.assert_allclose(found.mode_forces, [1.0, 1.25], rtol=0.01)
    np.testing.assert_allclose(found.mode_arc_lengths, LENGTH / 6 * np.array([1, 5]))
    np.testing.assert_array_equal(found.mode_sides, 0)


def test_the_interval_encloses_that_with_equal_tails_on_the_flat_side_of_the_density():
    force = np.linspace(0, 1, 1001)
    assert _interval(force[None] ** 8, force[None])[0, 0] == pytest.approx(0.025 ** (1 / 8), abs=1e-4)
    assert _interval(1 - (1 - force[None]) ** 8, force[None])[0, 2] == pytest.approx(1 - 0.025 ** (1 / 8), abs=1e-4)


def test_the_table_of_the_normal_integral_is_exact_to_3e_8_and_keeps_nan():
    x = np.append(np.linspace(-40, 40, 100_003), [np.nan, -1e9, 1e9])
    np.testing.assert_allclose(_normal_integral((x + _MAX_STDS) * _NODES_PER_STD), ndtr(x), rtol=0, atol=3e-8)


def test_what_is_drawn_from_the_prior_lies_in_its_intervals():
    """Errors as believed, half of the samples without contact: coverage, and as many contacts as is believed."""
    rng, cells, count = np.random.default_rng(2), few_cells(), 2000
    cell = rng.choice(len(cells.prior), count, p=cells.prior)
    share = np.exp(-((FORCES / POSSIBLE.usual_force) ** 2) / 2)
    force = rng.choice(FORCES, count, p=share / share.sum()) * (rng.uniform(size=count) < 0.5)
    r = force[:, None] * cells.response[cell] + rng.multivariate_normal(np.zeros(2), COVARIANCE, count)
    found = posterior(r, COVARIANCE, np.full(count, 2), cells)
    pressed, low, high = force > 0, found.force_interval[:, 0], found.force_interval[:, 2]
    assert 0.95 < ((low <= force) & (force <= high))[pressed].mean() < 0.985
    assert ((found.force_set[:, 0] <= force) & (force <= found.force_set[:, 1])).mean() > 0.935
    assert (force <= np.nan_to_num(found.force_bounds[:, 0], nan=LARGEST)).mean() > 0.935
    for least, most in ((0.0, 0.4), (0.4, 0.95), (0.95, 1.0)):
        chosen = (least <= found.probability) & (found.probability <= most)
        spread = 3 * np.sqrt(0.25 / chosen.sum())
        assert found.probability[chosen].mean() == pytest.approx(pressed[chosen].mean(), abs=spread)


def read(layout, pushes, pressure=60e3):
    q = in_balance(layout.finger, pressure, 9.81, pushes)
    driving = layout.finger.pressure_torque(pressure)
    return layout.response.reading(extension_ratios(layout, q)), driving, vector(9.81)


@pytest.mark.parametrize("sections", [2, 4])
def test_three_answers(shipped_finger, sections):
    """Nothing; somewhere on the first section; at the tip."""
    layout, length = SensorLayout(shipped_finger, sections), shipped_finger.length
    cases = ([], [Push(0.2 * length, 1.0)], [Push(0.95 * length, 0.5)])
    shape = ContactShape(layout, Uncertainty(bend_per_pressure=EXACT))
    found = [shape.posterior(*read(layout, pushes)) for pushes in cases]
    assert [float(each.answer) for each in found] == [NOTHING, SOMEWHERE, HERE]
    assert [each.probability > 0.95 for each in found] == [False, True, True]
    assert np.isnan([*found[0].arc_length_set, *found[0].mode_forces, *found[0].mode_arc_lengths]).all()
    for each, force, place in ((found[1], 1.0, 0.2), (found[2], 0.5, 0.95)):
        assert each.force_interval[0] < force < each.force_interval[2]
        assert each.force_set[0] < force < each.force_set[1]
        assert not each.force_bounds[0] > each.force_set[1]
        assert each.arc_length_set[0] < place * length < each.arc_length_set[1]
    assert np.isnan(found[1].force_bounds[0])  # close to the base, almost any force bends as little
    assert 0.5 < found[2].force_bounds[0] < 0.8


def test_the_largest_force_of_the_scene_bounds_what_is_not_seen(shipped_finger):
    layout = SensorLayout(shipped_finger, 2)
    for largest in (2.0, 8.0):
        found = ContactShape(layout, Uncertainty(largest_force=largest)).posterior(*read(layout, []))
        assert found.force_set[1] == pytest.approx(largest)
        assert np.isnan(found.force_bounds[0])


def test_two_contacts_that_no_single_force_explains_show_in_the_misfit(shipped_finger):
    layout, s = SensorLayout(shipped_finger, 4), np.array([0.45, 0.9]) * shipped_finger.length
    shape = ContactShape(layout, Uncertainty(bend_per_pressure=EXACT))
    found = shape.posterior(*read(layout, [Push(s[0], 0.8), Push(s[1], 0.5)]))
    alone = shape.posterior(*read(layout, [Push(s[1], 0.5)]))
    assert found.misfit > 1 > alone.misfit
    assert np.isnan([*found.force_interval, *found.force_set, *found.arc_length_set]).all()
    assert found.answer == SOMEWHERE
    assert np.isnan(found.force_bounds[0])
    assert 1.3 < found.force_bounds[1] == found.force_bounds[2] < 2.6


@pytest.mark.parametrize("r", [(0.03, 0.004), (0.01, 0.002), (0.02, 0.001)])
def test_the_bound_of_several_forces_is_that_of_the_dual_problem(r):
    """Every y with  c^T y >= 1  for all responses c bounds the sum by  r^T y + |y|  times what may be left of r."""
    cells, W = few_cells(), np.linalg.inv(np.linalg.cholesky(COVARIANCE))
    columns = W @ cells.response[(cells.side == 1) & ((cells.place + 1) / 12 * LENGTH > NEAREST)].T
    around = np.linspace(0, 2 * np.pi, 400_001)
    directions = np.stack([np.cos(around), np.sin(around)], axis=-1)
    least = (directions @ columns).min(axis=-1)
    left = np.sqrt(nnls(columns, W @ r)[1] ** 2 + 2.71)
    bounds = (directions @ W @ r + left)[least > 0] / least[least > 0]
    found = posterior(np.array(r), COVARIANCE, np.array(2), cells)
    expected = max(bounds.min(), found.force_bounds[1])  # which allows more where one force alone leaves more
    assert found.force_bounds[2] == pytest.approx(expected, rel=1e-4)


def test_what_no_forces_explain_widens_the_bound_of_several_as_larger_variances_do():
    """The variances are scaled until noise alone leaves as much in 1 of 1000 samples (Birge)."""
    cells, r = few_cells(), np.array([0.01, -0.02])  # neither side bends the sections in opposite ways
    W = np.linalg.inv(np.linalg.cholesky(COVARIANCE))
    left = min(nnls(W @ cells.response[cells.side == side].T, W @ r)[1] ** 2 for side in (-1, 1))
    scale = left / chdtri(1, 1e-3)
    assert scale > 2
    bounds = [
        posterior(r, covariance, np.array(2), cells, ForcePrior(2.0, 1000.0)).force_bounds[2]
        for covariance in (COVARIANCE, scale * COVARIANCE)
    ]
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-6)
    assert bounds[0] < 1000


@pytest.mark.parametrize("around", [False, True])
def test_a_piece_of_the_likelihood_set_is_a_connected_component(around):
    """Places adjoin along the finger and, in space, from side to side around it; the oracle is that of graphs."""
    rng, sides, places = np.random.default_rng(8), 6, 9
    number = np.arange(sides * places).reshape(sides, places)
    for likely in rng.random((40, sides, places)) < 0.6:
        pairs = [(number[:, :-1], number[:, 1:]), *([(number, np.roll(number, 1, axis=0))] if around else [])]
        edges = np.concatenate([np.stack([one.ravel(), other.ravel()]) for one, other in pairs], axis=-1)
        edges = edges[:, likely.ravel()[edges].all(axis=0)]
        graph = coo_array((np.ones(len(edges[0])), tuple(edges)), shape=(number.size, number.size))
        component = connected_components(graph, directed=False)[1].reshape(sides, places)
        begin = np.zeros_like(likely)
        begin[tuple(rng.choice(np.argwhere(likely)))] = True
        expected = likely & (component == component[begin])
        np.testing.assert_array_equal(_extend_piece(begin, likely, around), expected)


@pytest.mark.parametrize("sections", [2, 4])
def test_friction_at_the_cone_bounds_what_any_friction_does(shipped_finger, sections):
    """The bound of several forces with the most friction alone is that of forces in all cells."""
    layout, possible, rng = SensorLayout(shipped_finger, sections), ForcePrior(2.0, 100.0), np.random.default_rng(3)
    q = in_balance(shipped_finger, 60e3, 9.81, [Push(0.08, 0.5)])
    contact = SurfaceContact(Mechanics(layout, Uncertainty(friction=0.45)))
    cells = contact.cells(q, contact.mechanics.bent_finger(q), layout.matrix / 1e-3)
    r = cells.response[[100, 420]].sum(axis=0) + rng.standard_normal((4, sections))
    found = fit_cells(r, cells, possible.max_force)
    in_cells, read = cell_posterior(found, np.full(4, sections), possible), np.full(4, sections)
    bounds = [
        contact_posterior(
            found, in_cells, LazyArray(lambda: in_cells), read, LENGTH, possible, NEAREST, np.zeros(4), several
        ).force_bounds
        for several in (cells, contact._cone_cells(cells))
    ]
    assert len(contact._cone_cells(cells).place) < len(cells.place) / 2
    np.testing.assert_allclose(bounds[1], bounds[0], rtol=1e-6)

"""ContactDetector: thresholds on a torque that is given, no false alarm in motion, and no late one."""

import numpy as np
import pytest
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.load.contact_detector import THRESHOLD, ContactDetector
from soft_gripper.scenario.scenario_file import load_scenario

PERIOD = 0.01  # s
FINGERS = ("left_finger", "right_finger")
PORTS = ("contact", "contact_residual", "contact_time")
NONE, CERTAIN = np.zeros(4), np.zeros(4)  # N m, no torque, no tolerance


class Detector:
    """A ContactDetector of four joints, two of them at the base, whose samples are given by hand, one a period."""

    def __init__(self, block=None):
        self.block = block or ContactDetector(4, 2, PERIOD)
        self.context = self.block.CreateDefaultContext()
        self.samples = 0

    def sample(self, torque, tolerance=CERTAIN):
        """Contact, residual and time of contact at the next sample."""
        self.context.SetTime(self.samples * PERIOD)
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        self.samples += 1
        self.block.GetInputPort("external_torque").FixValue(self.context, torque)
        self.block.GetInputPort("torque_tolerance").FixValue(self.context, tolerance)
        return [float(self.block.GetOutputPort(name).Eval(self.context)[0]) for name in PORTS]


def at_base(size):
    """Torques whose mean at the base is `size` times the threshold."""
    return THRESHOLD * np.array([1.5 * size, 0.5 * size, 70.0, -90.0])


def test_contact_begins_beyond_the_threshold_and_ends_below_half_of_it():
    detector = Detector()
    sizes = np.interp(np.arange(1600), [0, 200, 400, 800, 1000, 1600], [0, 0.9, 0.6, 1.4, 0.6, -1.4])
    contact, residual, since = np.array([detector.sample(at_base(size)) for size in sizes]).T
    changes = np.flatnonzero(np.diff(contact)) + 1
    size = np.abs(residual) / THRESHOLD
    np.testing.assert_array_equal(contact[changes], [1, 0, 1])
    np.testing.assert_allclose(size[changes], [1.0, 0.5, 1.0], atol=0.01)
    np.testing.assert_array_equal(size[changes] > size[changes - 1], [True, False, True])
    begun = changes[[0, 2]]
    expected = np.select([np.arange(1600) >= begin for begin in begun[::-1]], begun[::-1] * PERIOD, np.nan)
    np.testing.assert_allclose(since, expected)


def test_tolerance_counts_against_every_change():
    """Its mean at the base, whichever way the torque points."""
    detector, tolerance = Detector(), at_base(0.3)
    script = ((1.25, 0.0), (-1.25, 0.0), (-1.35, 1.0), (0.25, 1.0), (0.15, 0.0))
    for size, contact in script:
        assert detector.sample(at_base(size), tolerance)[0] == contact


@pytest.mark.parametrize("unknown", [(np.nan, np.nan), (-np.inf, np.inf), (np.inf, np.nan)], ids=str)
@pytest.mark.parametrize(("size", "contact"), [(0.0, 0.0), (0.7, 1.0), (-0.7, 1.0)])
def test_contact_is_held_while_the_torque_is_not_finite(size, contact, unknown):
    """As a ForceEstimator puts torque and tolerance out of readings that are not."""
    detector = Detector()
    detector.sample(at_base(2.0 * contact))
    before = detector.sample(at_base(size))
    assert before[0] == contact
    with np.errstate(invalid="ignore"):
        held, residual, since = detector.sample(*(np.full(4, value) for value in unknown))
    assert held == contact
    assert not np.isfinite(residual)
    np.testing.assert_equal(since, before[2])
    np.testing.assert_array_equal(detector.sample(at_base(size)), before)


def first(flags):
    """Index of the first flag that is set."""
    assert flags.any()
    return int(np.argmax(flags))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box_grasp", "irregular_grasp"])
@pytest.mark.parametrize("pressure", [50e3, 120e3])
def test_the_touch_of_an_object_is_detected_within_50_ms_and_not_before(name, pressure):
    short = ("pressure.settle=0.49", "pressure.hold_samples=1", f"pressure.steps.all=[0, {pressure}]")
    recording = simulate(load_scenario(name, [*short, f"estimator.contact_threshold={THRESHOLD}"]))
    for finger in FINGERS:
        contact, since = (recording[f"{finger}.{signal}"].values.squeeze() for signal in ("contact", "contact_time"))
        touched, detected = first(recording[f"{finger}.true_external_torque"].values.any(axis=1)), first(contact > 0)
        assert 0 <= (detected - touched) * PERIOD <= 0.05
        assert since[-1] == pytest.approx((detected - 1) * PERIOD)  # a recording shows the sample before
        assert contact[detected:].all()


@pytest.mark.parametrize(("time_step", "threshold"), [(0.01, THRESHOLD), (0.0025, 1e-3)])
def test_in_free_air_no_step_of_the_pressure_is_taken_for_contact(time_step, threshold):
    overrides = (f"plant_config.time_step={time_step}", f"estimator.contact_threshold={threshold}")
    recording = simulate(free_bending([-50e3, 210e3, 0.0, 100e3, -50e3], 0.4, *overrides))
    for finger in FINGERS:
        names = ("external_torque", "contact_residual", "contact", "contact_time", "true_external_torque")
        # A recording shows the sample before: the first is in its second row.
        torque, residual, contact, since, truth = (recording[f"{finger}.{name}"].values[1:].squeeze() for name in names)
        assert np.isnan(residual[:4]).all()
        np.testing.assert_allclose(residual[4:], torque[4:, :3].mean(axis=1), atol=1e-15)
        assert np.abs(residual[4:]).max() > threshold  # which the tolerance has to cover
        assert not contact.any()
        assert not truth.any()
        assert np.isnan(since).all()

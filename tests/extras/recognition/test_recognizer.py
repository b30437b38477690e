"""ObjectRecognizer: when it has seen enough, what it forgets, and the same as the model in a small diagram."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from refusals import refused

from soft_gripper.extras.recognition.object_classifier import ObjectClassifier
from soft_gripper.extras.recognition.recognizer import SAMPLES, TOLERANCE, ObjectRecognizer
from soft_gripper.signals import signal_of

PERIOD = 0.01  # s
FINGERS = ("thumb", "index")
LEVELS = np.array([50e3, 80e3])  # Pa
JOINTS = 3
RNG = np.random.default_rng(1)
FEATURES = 4 * len(LEVELS) * JOINTS
MODEL = ObjectClassifier(
    ("ball", "can"),
    len(FINGERS),
    JOINTS,
    3,
    LEVELS,
    center=np.zeros(FEATURES),
    components=RNG.normal(size=(2, FEATURES)),
    means=np.array([[0.1, 0.0], [-0.2, 0.3]]),
    covariances=np.array([9.0 * np.eye(2), 16.0 * np.eye(2)]),
    limit=6.0,
)
ANGLES, TORQUES = RNG.normal(size=(2, len(LEVELS), len(FINGERS), JOINTS))
EXPECTED = MODEL.probabilities(ANGLES, TORQUES)


class Recognizer:
    """A ObjectRecognizer whose samples are given by hand, one a period."""

    def __init__(self):
        self.block = ObjectRecognizer(MODEL, FINGERS, PERIOD)
        self.context = self.block.CreateDefaultContext()

    def sample(self, pressures, angles=ANGLES[0], torques=TORQUES[0]):
        """Probabilities after a sample of pressures (F) Pa, and angles and torques (F, N)."""
        for i, finger in enumerate(FINGERS):
            for signal, value in (
                ("sampled_pressure", [pressures[i]]),
                ("estimated_joint_angles", angles[i]),
                ("external_torque", torques[i]),
            ):
                self.block.GetInputPort(f"{finger}.{signal}").FixValue(self.context, value)
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        return self.block.get_output_port().Eval(self.context).copy()

    def hold(self, level):
        """As many samples at a level as count, after the first."""
        for _ in range(1 + SAMPLES):
            found = self.sample([LEVELS[level]] * 2, ANGLES[level], TORQUES[level])
        return found


def test_ports():
    block = ObjectRecognizer(MODEL, FINGERS, PERIOD)
    found = [block.get_input_port(i) for i in range(block.num_input_ports())]
    signals = {"estimated_joint_angles": JOINTS, "external_torque": JOINTS, "sampled_pressure": 1}
    expected = [(f"{finger}.{name}", size) for name, size in signals.items() for finger in FINGERS]
    assert [(port.get_name(), port.size()) for port in found] == expected
    port = block.GetOutputPort("object_probabilities")
    assert signal_of(port).unit == "1"
    assert signal_of(port).axes == {"shape": ("ball", "can", "unknown")}


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_probabilities_are_those_of_the_model_once_every_level_was_held(order):
    recognizer = Recognizer()
    assert np.isnan(recognizer.hold(order[0])).all()
    np.testing.assert_allclose(recognizer.hold(order[1]), EXPECTED)


def test_passing_through_a_level_does_not_count():
    recognizer = Recognizer()
    recognizer.hold(0)
    recognizer.sample([65e3, 65e3])
    for _ in range(SAMPLES):
        assert np.isnan(recognizer.sample([LEVELS[1]] * 2, ANGLES[1], TORQUES[1])).all()
    np.testing.assert_allclose(recognizer.sample([LEVELS[1]] * 2, ANGLES[1], TORQUES[1]), EXPECTED)


def test_the_mean_of_the_last_samples_at_a_level_counts():
    recognizer = Recognizer()
    for _ in range(9):
        recognizer.sample([LEVELS[0]] * 2, 5 * ANGLES[0], TORQUES[1])
    for share in (0.8, 1.2, 1.0, 0.9, 1.1):
        recognizer.sample([LEVELS[0]] * 2, share * ANGLES[0], TORQUES[0])
    np.testing.assert_allclose(recognizer.hold(1), EXPECTED)


@pytest.mark.parametrize(("off", "counts"), [(0.9 * TOLERANCE, True), (-1.1 * TOLERANCE, False)])
def test_all_fingers_are_to_be_at_the_level(off, counts):
    recognizer = Recognizer()
    recognizer.hold(0)
    for _ in range(1 + SAMPLES):
        found = recognizer.sample([LEVELS[1], LEVELS[1] + off], ANGLES[1], TORQUES[1])
    assert np.isfinite(found).all() == counts


def test_samples_that_are_not_finite_are_left_out():
    recognizer = Recognizer()
    recognizer.hold(0)
    lost = np.full((2, JOINTS), np.nan)
    for _ in range(3):
        assert np.isnan(recognizer.sample([LEVELS[1]] * 2, ANGLES[1], lost)).all()
    np.testing.assert_allclose(recognizer.hold(1), EXPECTED)
    np.testing.assert_allclose(recognizer.sample([LEVELS[1]] * 2, lost, lost), EXPECTED)


def test_letting_go_forgets_and_a_little_less_pressure_does_not():
    recognizer = Recognizer()
    recognizer.hold(0)
    recognizer.hold(1)
    np.testing.assert_allclose(recognizer.sample([0.6 * LEVELS[0]] * 2), EXPECTED)
    assert np.isnan(recognizer.sample([LEVELS[1], 0.0])).all()
    assert np.isnan(recognizer.hold(1)).all()


def test_in_a_diagram_it_recognizes_while_it_runs():
    """The pressure steps at 0.1 s; angles and torques change with it."""
    builder = DiagramBuilder()
    block = builder.AddSystem(ObjectRecognizer(MODEL, FINGERS, PERIOD))
    for i, finger in enumerate(FINGERS):
        for signal, values in (
            ("sampled_pressure", LEVELS[None]),
            ("estimated_joint_angles", ANGLES[:, i].T),
            ("external_torque", TORQUES[:, i].T),
        ):
            steps = PiecewisePolynomial.ZeroOrderHold([0.0, 0.1, 0.2], np.column_stack([values, values[:, -1]]))
            source = builder.AddSystem(TrajectorySource(steps))
            builder.Connect(source.get_output_port(), block.GetInputPort(f"{finger}.{signal}"))
    log = LogVectorOutput(block.get_output_port(), builder, PERIOD)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.2)
    found = log.FindLog(simulator.get_context())
    times, probabilities = found.sample_times(), found.data().T
    assert np.isnan(probabilities[times < 0.115]).all()
    np.testing.assert_allclose(probabilities[-1], EXPECTED)


def test_another_number_of_fingers_is_refused():
    with refused("fingers", ["thumb"]) as error:
        ObjectRecognizer(MODEL, ["thumb"], PERIOD)
    assert "thumb" in str(error.value)

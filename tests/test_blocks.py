"""Every block of arrays that is found in the core: its ports, its memory, and its functions over a recording."""

import re
from importlib import import_module
from pkgutil import iter_modules, walk_packages

import numpy as np
import pytest
from creeping_fingers import GRIPPER, write_creeping
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, PortDataType

import soft_gripper
from soft_gripper.array_block import ArrayBlock
from soft_gripper.control.grip import GripForce, LowSelector
from soft_gripper.diagrams.station import add_station, make_private_station, make_station
from soft_gripper.errors import InputError
from soft_gripper.estimators.calibration_range import CalibrationRange
from soft_gripper.estimators.finger_shape import FingerShape
from soft_gripper.fingers.pressure_drive import Leak
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.calibrated_states import CalibratedStates
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.link_sensors import CurvatureSensors
from soft_gripper.sensors.sensor_block import SensorBlock
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.signals import signal_of

PERIOD, SAMPLES = 0.01, 12  # s
SENSORS = "sensor.sections=2", "sensor.errors.preset=realistic", "sensor.errors.delay=1"
ALL = "estimator.alongside=[arcs, spline, contact, recursive]", "estimator.contact_threshold=2.5e-3"
SPACE = "models.0.fingers.all.yields=bending sideways twist", "sensor.layout=four_faces_and_diagonal"
STATIONS = (
    ("box_grasp", [*SENSORS, "sensor.pressure_errors.delay=2", *ALL, "estimator.type=gaussian"]),
    ("box_grasp", [*SPACE, "estimator.type=gaussian", "estimator.alongside=[contact, recursive]"]),
    ("box_grasp", ["models.0.file={creeping}", "sensor.one_sided=true"]),
    ("pick_and_place_box", []),
    ("tendon_grasp", []),
    ("three_chambers", ["models.0.fingers.all.yields=bending sideways twist"]),
)
SIZES = {"pressure": 5e4, "strain": 0.02, "driving_torque": 0.05, "standard_normal": 1.0, "sampled_state": 0.1}
# What the name of an output says of its unit, the first that is found in it.
UNITS = {
    r"force.*covariance": "N^2",
    r"force|contact_total": "N",
    r"torque|residual": "N m",
    r"pressure": "Pa",
    r"covariance": "rad^2",
    r"arc_length|position|width|center|_error$": "m",
    r"angles|theta|twist|side$|sides$|direction": "rad",
    r"kappa": "1/m",
    r"curvature": "rad/m",
    r"area": "m^2",
    r"time": "s",
    r"strain|ratio|probability|contact$|loaded": "1",
}
# During a run alone is what they put out known.
DURING_A_RUN_ALONE = {
    "BasePoseSensor",
    "ErrorBlock",
    "PidController",
    "ReadingErrorBlock",
    "TaskMachine",
    "TrueContact",
}


def subclasses(kind):
    return {kind}.union(*map(subclasses, kind.__subclasses__()))


def block_classes():
    """Every class of blocks that a module of the core declares."""
    for part in iter_modules(soft_gripper.__path__, "soft_gripper."):
        if part.ispkg and part.name not in ("soft_gripper.extras", "soft_gripper.commands"):
            for module in walk_packages(import_module(part.name).__path__, f"{part.name}."):
                import_module(module.name)
    own = (each for each in subclasses(ArrayBlock) - {ArrayBlock} if each.__module__.startswith("soft_gripper."))
    core = (each for each in own if ".extras." not in each.__module__ and not each.__name__.startswith("_"))
    return sorted(core, key=lambda each: each.__name__)


def blocks(system):
    if isinstance(system, Diagram | DiagramBuilder):
        return [block for inner in system.GetSystems() for block in blocks(inner)]
    return [system] if isinstance(system, ArrayBlock) else []


def ports(block):
    """Names of the outputs, and sizes of the inputs, 0 of those that are no vectors."""
    inputs = [block.get_input_port(i) for i in range(block.num_input_ports())]
    return {port.get_name(): port.size() * (port.get_data_type() == PortDataType.kVectorValued) for port in inputs}


@pytest.fixture(scope="module")
def examples(tmp_path_factory):
    """Blocks by class, one for each set of ports."""
    creeping, stations = write_creeping(GRIPPER, tmp_path_factory.mktemp("creeping"), 0.2, 0.5), []
    for name, overrides in STATIONS:
        changes = [override.replace("{creeping}", str(creeping)) for override in overrides]
        stations.append(make_station(load_scenario(name, changes)))
    dead = load_scenario("tip_distance_steps", ["sensor.faults=[{finger: left_finger}]", "estimator.type=gaussian"])
    stations.append(make_private_station(dead))
    builder = DiagramBuilder()
    composed = add_station(builder, dead, composed=True)
    found = [block for station in stations for block in blocks(station.diagram)] + blocks(builder)
    finger = stations[0].fingers[0].finger
    found += [FingerShape(finger), SensorBlock(CurvatureSensors(finger, 2), PERIOD)]
    states = FittedStates(np.zeros((1, 7)), np.full(7, 0.02))
    calibrated = CalibratedStates(states, Widths(np.array([1e-3]), 1e-3), 2.0, sections=2)
    found.append(CalibrationRange(SensorLayout(finger, 2), calibrated, np.array([0.0, 0.0, -9.81])))
    found += [LowSelector(), GripForce(["left", "right"]), Leak(np.array([0.3, 0.0]), 0.05)]
    distinct = {(type(block), block.period, *block.outputs, *ports(block).items()): block for block in found}
    yield {kind: [block for block in distinct.values() if type(block) is kind] for kind in map(type, found)}
    del stations, composed, builder


def pose(random):
    return RigidTransform(RollPitchYaw(random.uniform(-1, 1, 3)), random.uniform(-1, 1, 3)).GetAsMatrix34().ravel()


def drawn(block, random):
    """Inputs of a block, (T, size) each, by name; flags are 0 or 1, and one sample is not known."""
    values = {}
    for name, size in ports(block).items():
        kind = name.rpartition(".")[2]
        scale = next((scale for end, scale in SIZES.items() if kind.endswith(end)), 0.05)
        values[name] = scale * random.uniform(-1, 1, (SAMPLES, size))
        if kind == "X_WB":
            values[name] = np.array([pose(random) for _ in range(SAMPLES)])
        elif kind == "contact":
            values[name] = np.round(random.uniform(0.2, 1, (SAMPLES, size)))
        elif kind != "driving_torque" and size:
            values[name][7, 0] = np.nan
    return values


class Run:
    """One run of a block alone, of inputs that are held from sample to sample."""

    def __init__(self, block, inputs):
        self.block, self.inputs, self.rows = block, inputs, []
        self.simulator = Simulator(block, block.CreateDefaultContext())

    def advance(self, samples):
        """Goes on by so many samples, and keeps what is put out when each has come."""
        for _ in range(samples):
            self.take(len(self.rows))
            self.rows.append(self.outputs(followed(self.block)))

    def take(self, number):
        """Goes on to a sample, and gives its inputs."""
        if number:
            self.simulator.AdvanceTo(number * PERIOD)
        for name, values in self.inputs.items():
            if values.shape[1]:
                self.block.GetInputPort(name).FixValue(self.simulator.get_mutable_context(), values[number])
        if not number:
            self.simulator.Initialize()

    def outputs(self, names):
        return {name: self.block.GetOutputPort(name).Eval(self.simulator.get_context()) for name in names}

    def values(self):
        return {name: np.array([row[name] for row in self.rows]) for name in self.rows[0]}


def followed(block):
    """Outputs that follow from inputs at all samples of a recording."""
    inputs = {name for name, size in ports(block).items() if size}
    return [name for name in block.outputs if block.follows(name, PERIOD) and inputs.issuperset(block.leaves(name))]


@pytest.mark.parametrize("kind", block_classes())
def test_ports_are_as_large_as_their_axes_and_have_a_unit_for_every_entry(examples, kind):
    for block in examples[kind]:
        assert len(block.outputs) > 0
        for name in block.outputs:
            port, (unit, axes, _) = block.GetOutputPort(name), signal_of(block.GetOutputPort(name))
            sizes = [len(labels) for labels in axes.values()]
            assert np.prod(sizes) == port.size()
            assert all([unit] if isinstance(unit, str) else [*unit, len(unit) == sizes[-1]])
            assert "entry" not in axes
            assert next((each for said, each in UNITS.items() if re.search(said, name)), unit) == unit


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("kind", block_classes())
def test_over_a_recording_a_block_puts_out_what_it_does_sample_by_sample(examples, kind):
    """All that it remembers lies in the context: a second run goes on while the first one waits."""
    known = [block for block in examples[kind] if followed(block)]
    assert known or kind.__name__ in DURING_A_RUN_ALONE
    for block in known:
        inputs = drawn(block, np.random.default_rng(1))
        run, other = Run(block, inputs), Run(block, {name: 0.5 * values for name, values in inputs.items()})
        for each in (run, other, run):
            each.advance(SAMPLES // 2)
        expected = block.over_time(PERIOD * np.arange(SAMPLES), inputs, followed(block))
        for name, values in run.values().items():
            scale = np.abs(values[np.isfinite(values)]).max(initial=1e-300)
            np.testing.assert_allclose(values, expected[name], rtol=0, atol=1e-6 * scale, err_msg=name)


HOSTILE = {2: np.nan, 3: np.inf, 4: 1e308}  # by sample


def last_outputs(block, inputs, hostile=None):
    """Outputs at the last sample; only a sample of a `hostile` input, and the update after it, may be refused."""
    run, refusals = Run(block, inputs), []
    for number in range(SAMPLES):
        try:
            run.take(number)
        except InputError as refusal:
            refusals.append((number - 1, refusal))
            block.GetInputPort(hostile).FixValue(run.simulator.get_mutable_context(), inputs[hostile][0])
            run.take(number)
        try:
            found = run.outputs(block.outputs)
        except InputError as refusal:
            refusals.append((number, refusal))
    for number, refusal in refusals:
        assert number in HOSTILE
        assert (refusal.where, refusal.field) == (block.GetSystemPathname(), hostile)
    return found


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("kind", block_classes())
def test_a_block_goes_on_after_inputs_that_are_not_finite(examples, kind):
    """It puts out NaN, or names itself and the input, as long as it remembers them, and numbers again after that."""
    for block in examples[kind]:
        sizes = ports(block)
        if not all(sizes.values()):
            continue
        sane = {
            name: np.nan_to_num(values, nan=0.01) for name, values in drawn(block, np.random.default_rng(1)).items()
        }
        expected = last_outputs(block, sane)
        for name in sizes:
            hostile = sane[name].copy()
            for number, value in HOSTILE.items():
                hostile[number] = value
            for output, value in last_outputs(block, {**sane, name: hostile}, name).items():
                assert np.isfinite(value[np.isfinite(expected[output])]).all(), (type(block), name, output)

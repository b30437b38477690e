"""Parts of fingers as one block, of one finger and of several, put out what their blocks do."""

import numpy as np
import pytest
from creeping_fingers import GRIPPER, write_creeping
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring.composed import FusedBlock, add_parts
from soft_gripper.diagrams.wiring.estimation import make_estimation
from soft_gripper.diagrams.wiring.named_wires import inputs, vector_outputs
from soft_gripper.diagrams.wiring.sensors import make_sensors
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.signals import signal_of

PERIOD, SAMPLES, FINGERS = 0.01, 8, ("left", "middle", "right")
GRAVITY = np.array([0.3, 0.1, -9.7])
SENSORS = "sensor.sections=2", "sensor.errors.preset=realistic", "sensor.errors.delay=2", "sensor.errors.dropout=0.1"
SPACE = "models.0.fingers.all.yields=bending sideways twist", "sensor.layout=four_faces_and_diagonal"
CASES = {
    "sensors": ("sensors", [*SENSORS, "sensor.pressure_errors={noise: 500.0, delay: 2, offset: 1000.0}"]),
    "arcs": ("estimation", ["estimator.contact_threshold=2.5e-3"]),
    "creep": ("estimation", ["models.0.file={creeping}"]),
    "contact": ("estimation", ["estimator.type=contact", "estimator.contact_threshold=2.5e-3"]),
    "gaussian in space": ("estimation", ["estimator.type=gaussian", *SPACE]),
}


@pytest.fixture(scope="module", params=CASES)
def make(request, tmp_path_factory):
    """Makes equal parts."""
    kind, overrides = CASES[request.param]
    creeping = write_creeping(GRIPPER, tmp_path_factory.mktemp("creeping"), 0.2, 0.5)
    changes = [override.replace("{creeping}", str(creeping)) for override in overrides]
    scenario = load_scenario("box_grasp", changes)
    finger = make_station(scenario).fingers[0].finger
    if kind == "sensors":
        return lambda: make_sensors(finger, scenario.sensor)
    layout = read_nominal_model(scenario.nominal).layout(finger, scenario.sensor)
    return lambda: make_estimation(layout, scenario.estimator, scenario.sensor, GRAVITY)


def drawn(part, fingers=FINGERS):
    """Inputs over time, by finger."""
    random, sizes = np.random.default_rng(7), {name: port.size() for name, port in inputs(part).items()}
    scales = {"pressure": 5e3, "joint_angles": 0.02, "strain": 2e-3}
    values = {
        finger: {n: scales.get(n, 1.0) * random.normal(size=(SAMPLES, size)) for n, size in sizes.items()}
        for finger in fingers
    }
    for each in values.values():
        if "X_WB" in each:
            each["X_WB"] = np.tile(np.eye(3, 4).ravel(), (SAMPLES, 1))
    return values


def run(builder, parts, values):
    """Outputs of parts over time, by finger, and their units and axes."""
    for finger, part in parts.items():
        for name, port in part.inputs.items():
            builder.ExportInput(port, f"{finger}.{name}")
        for name, port in part.outputs.items():
            builder.ExportOutput(port, f"{finger}.{name}")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context, found = simulator.get_mutable_context(), []
    for i in range(SAMPLES):
        if i > 0:
            simulator.AdvanceTo(i * PERIOD)
        for finger, each in values.items():
            for name, value in each.items():
                diagram.GetInputPort(f"{finger}.{name}").FixValue(context, value[i])
        if i == 0:
            simulator.Initialize()
        found.append({name: port.Eval(context) for name, port in vector_outputs(diagram).items()})
    return {name: np.array([each[name] for each in found]) for name in found[0]}


def added(make, keys, fingers=FINGERS):
    builder = DiagramBuilder()
    return builder, add_parts(builder, "part", {finger: make() for finger in fingers}, keys)


@pytest.mark.parametrize("keys", [dict.fromkeys(FINGERS, 0), {"left": 0, "middle": 1, "right": 0}])
def test_composed_parts_put_out_what_their_blocks_do(make, keys):
    """To rounding, which far centres of arcs magnify: matrices of several fingers are multiplied at once."""
    values = drawn(make())
    builder, blocks = added(make, None)
    composer, composed = added(make, keys)
    kinds = sorted(type(system).__name__ for system in composer.GetSystems())
    assert kinds == (["BatchedBlock"] if len({*keys.values()}) == 1 else ["BatchedBlock", "FusedBlock"])
    for finger, part in blocks.items():
        assert composed[finger].inputs.keys() == part.inputs.keys()
        for name, port in part.outputs.items():
            assert signal_of(composed[finger].outputs[name]) == signal_of(port)
    found, expected = run(composer, composed, values), run(builder, blocks, values)
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        scale = np.abs(value[np.isfinite(value)]).max(initial=1e-300)
        np.testing.assert_allclose(found[name], value, rtol=0, atol=1e-6 * scale, err_msg=name)


def test_over_a_recording_they_put_out_what_they_do_sample_by_sample(make):
    one = FusedBlock.from_diagram(make())
    values, time = drawn(one), PERIOD * np.arange(SAMPLES)
    builder, parts = added(make, dict.fromkeys(FINGERS, 0))
    (block,) = builder.GetSystems()
    known = {f"{finger}.{name}": value for finger, each in values.items() for name, value in each.items()}
    outputs = [name for name in block.outputs if block.follows(name, PERIOD)]
    assert {name.partition(".")[2] for name in outputs} <= one.outputs.keys()
    for name in outputs:
        read = {leaf.partition(".")[0] for leaf in block.leaves(name)}
        assert read in ({name.partition(".")[0]}, {*FINGERS})  # all, if a loop over the samples is shared
    over_time = block.over_time(time, known, outputs)
    found = run(builder, parts, values)
    for name in outputs:
        value = found[name]
        scale = np.abs(value[np.isfinite(value)]).max(initial=1e-300)
        np.testing.assert_allclose(over_time[name], value, rtol=0, atol=1e-6 * scale, err_msg=name)

"""Contact: what is estimated of it, finger by finger and between two of them, and the truth beside it."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.geometry import Role, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import Adder, Gain

from soft_gripper.contact_detector import ContactDetector
from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.diagrams.sensing import sensor_layout
from soft_gripper.finger_links import link_name
from soft_gripper.object_width import ObjectWidth
from soft_gripper.true_contact import Shapes, TrueContact

Ports = dict[str, OutputPort]


def add_contact_sensing(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    fingers: Sequence[PlantFinger],
    signals: Mapping[str, OutputPort],
) -> Ports:
    """Adds `{finger}.contact_detector`, `true_contact` and, for two fingers, `object_width`; returns the signals."""
    found: Ports = {}
    for finger in fingers:
        detector = _add_detector(builder, scenario, finger, signals)
        found |= {f"{finger.name}.{name}": port for name, port in _outputs(detector).items()}
    truth = TrueContact({finger.name: _shapes(plant, scene_graph, finger) for finger in fingers})
    builder.AddNamedSystem("true_contact", truth)
    builder.Connect(plant.get_contact_results_output_port(), truth.get_input_port())
    of_truth = _outputs(truth)
    width = of_truth.pop("width")
    found |= of_truth
    if len(fingers) == 2:
        found |= _add_width(builder, scenario, fingers, {**signals, **found}, width)
    return found


def _add_detector(
    builder: DiagramBuilder, scenario: Scenario, finger: PlantFinger, signals: Mapping[str, OutputPort]
) -> ContactDetector:
    sensor = scenario.sensor
    layout = sensor_layout(scenario, finger)
    detector = ContactDetector(layout, np.array(scenario.gravity), sensor.period, sensor.contact_threshold)
    builder.AddNamedSystem(f"{finger.name}.contact_detector", detector)
    for name, signal in (("theta", "theta"), ("pressure", "sampled_pressure")):
        builder.Connect(signals[f"{finger.name}.{signal}"], detector.GetInputPort(name))
    base = builder.GetSubsystemByName(f"{finger.name}.base_pose")
    builder.Connect(base.get_output_port(), detector.GetInputPort("X_WB"))
    return detector


def _outputs(system: System) -> Ports:
    ports = (system.get_output_port(i) for i in range(system.num_output_ports()))
    return {port.get_name(): port for port in ports}


def _shapes(plant: MultibodyPlant, scene_graph: SceneGraph, finger: PlantFinger) -> Shapes:
    """The collision shapes of a finger."""
    bodies = (plant.GetBodyByName(link_name(finger.name, i), finger.model) for i in range(finger.finger.segments + 1))
    inspector = scene_graph.model_inspector()
    frames = (plant.GetBodyFrameIdOrThrow(body.index()) for body in bodies)
    return frozenset(shape for frame in frames for shape in inspector.GetGeometries(frame, Role.kProximity))


def _add_width(
    builder: DiagramBuilder,
    scenario: Scenario,
    fingers: Sequence[PlantFinger],
    signals: Mapping[str, OutputPort],
    truth: OutputPort,
) -> Ports:
    """The width of what two fingers hold, and its error."""
    first, second = fingers
    X_B1B2 = first.X_WB.inverse() @ second.X_WB
    width = ObjectWidth(sensor_layout(scenario, first), sensor_layout(scenario, second), X_B1B2)
    builder.AddNamedSystem("object_width", width)
    for finger, which in ((first, "first"), (second, "second")):
        for signal in ("theta", "external_torque", "contact"):
            builder.Connect(signals[f"{finger.name}.{signal}"], width.GetInputPort(f"{which}_{signal}"))
    minus_truth = builder.AddNamedSystem("minus_true_width", Gain(-1.0, 1))
    error = builder.AddNamedSystem("object_width_error", Adder(2, 1))
    builder.Connect(truth, minus_truth.get_input_port())
    builder.Connect(width.get_output_port(), error.get_input_port(0))
    builder.Connect(minus_truth.get_output_port(), error.get_input_port(1))
    return {
        "grip.object_width": width.get_output_port(),
        "grip.true_object_width": truth,
        "grip.object_width_error": error.get_output_port(),
    }

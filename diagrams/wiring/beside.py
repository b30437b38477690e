"""Estimators beside that of a scenario, applied: their shapes are recorded and scored, and nothing depends on them."""

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System

from soft_gripper.arrays import Array
from soft_gripper.diagrams.schema.scenario import EstimatorConfig
from soft_gripper.diagrams.wiring.choices import find_estimator, make_block, seen_from
from soft_gripper.diagrams.wiring.estimation import estimation_inputs, shape_wires
from soft_gripper.diagrams.wiring.named_wires import Ports, connect_known, vector_outputs
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.driving_torque import DRIVING_TORQUE
from soft_gripper.truth.metrics import PoseError


class ShapeBeside(Diagram):
    """One more estimate of the shape of a finger.

    ::

        strain --------------------------> estimator ---> estimated_joint_angles ---> FingerShape ---> pose
        X_WB (12) [R | p] -------------------^ ^
        pressure (1) Pa --> DrivingTorque -----+

    As in FingerEstimation; the memory of a finger that creeps is that of this estimator's shapes.
    """

    def __init__(self, estimator: System, finger: Finger, period: float):
        """
        Raises:
            InputError: if the estimator does not estimate the joint angles of the finger.
        """
        super().__init__()
        wires = shape_wires(estimator, finger, period)
        del wires.outputs[DRIVING_TORQUE]
        wires.build_into(self)


def add_beside(
    builder: DiagramBuilder,
    finger: PlantFinger,
    layout: SensorLayout,
    config: EstimatorConfig,
    period: float,
    known: Mapping[str, OutputPort],
) -> Ports:
    """Adds `{finger}.{type}.estimation` and `{finger}.{type}.scoring` for every type in `config.beside`.

    Args:
        builder: of a diagram with the finger's plant.
        finger: in the finalized plant.
        layout: sensors and finger as they are believed to be.
        config: the `estimator` part of a scenario.
        period: of all samples, s.
        known: the outputs of the sensors, and `sampled_joint_angles`.

    Returns:
        the signals by their names without the finger's, `{type}.{signal}`.

    Raises:
        InputError: if there is no such estimator.
    """
    gravity: Array = np.array(finger.plant.gravity_field().gravity_vector()) * config.compensate_gravity
    signals: Ports = {}
    for kind in config.beside:
        make = find_estimator(kind, config.uncertainty, "estimator.beside")
        estimator = make_block("estimator.beside", kind, make, layout, gravity, period)
        with seen_from("estimator.beside", kind):
            estimation = ShapeBeside(estimator, layout.finger, period)
            builder.AddNamedSystem(f"{finger.name}.{kind}.estimation", estimation)
            connect_known(builder, estimation, estimation_inputs(known), "estimator")
        scoring = builder.AddNamedSystem(f"{finger.name}.{kind}.scoring", PoseError(finger.finger))
        found = vector_outputs(estimation)
        connect_known(builder, scoring, {**known, **found}, "score")
        signals |= {f"{kind}.{name}": port for name, port in (found | vector_outputs(scoring)).items()}
    return signals

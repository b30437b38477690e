"""The tasks in this project: plant, drive and logs; with the blocks of sensing if requested."""

from time import process_time

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper import add_estimation, add_logs, add_pressure_drive, add_sensors, read_logs
from soft_gripper.diagrams import solver_config
from soft_gripper.diagrams.private_run import remove_unread_blocks
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.wiring.drive import add_steps
from soft_gripper.diagrams.wiring.plant_signals import add_plant_signals
from soft_gripper.diagrams.wiring.sensors import add_joint_angles
from soft_gripper.fingers import PlantFinger, forward_kinematics
from soft_gripper.scenario import sensor_layout
from studies.peers.task import PeerTask, PeerTrial, Run, Setting


def make_run(task: PeerTask, setting: Setting) -> Run:
    """A diagram of the task; `setting` has fields of `plant_config`."""
    scenario, builder = task.scenario, DiagramBuilder()
    for field, value in setting.items():
        setattr(scenario.plant_config, field, value)
    scene = add_plant(builder, scenario, visuals=False)
    drive = add_pressure_drive(builder, scene.fingers, scenario.pressure)
    add_steps(builder, "pressure", scenario.pressure.steps, scenario.step_duration, drive.pressure_commands)
    signals = {}
    if task.grasped_body is not None:
        pose = f"{task.grasped_body.name}.pose"
        signals[pose] = add_plant_signals(builder, scene, [task.grasped_body.name])[pose]
    for finger in scene.fingers:
        signals |= _sense(builder, task, finger, drive.pressures[finger.name])
    logs = add_logs(builder, signals, task.period)
    remove_unread_blocks(builder, signals)  # as `simulate` and sweeps do
    diagram = builder.Build()

    def run() -> PeerTrial:
        simulator = Simulator(diagram)
        ApplySimulatorConfig(solver_config(scenario), simulator)
        simulator.Initialize()
        start = process_time()
        simulator.AdvanceTo(scenario.duration)
        seconds = process_time() - start
        recording = read_logs(logs, simulator.get_context())
        if task.sensed:  # signals that nothing in the loop reads may be computed when they are read
            seconds = process_time() - start
        q = np.array([recording.samples(f"{finger.name}.joint_angles") for finger in scene.fingers])
        tips = forward_kinematics(q, task.fingers[0].segment_length).tip.T
        return PeerTrial(seconds, tips, task.object_positions(recording))

    return run


def _sense(builder: DiagramBuilder, task: PeerTask, finger: PlantFinger, pressure: OutputPort) -> dict[str, OutputPort]:
    """The signals of one finger: its joint angles alone, or all that is measured and estimated."""
    scenario = task.scenario
    if not task.sensed:
        return {f"{finger.name}.joint_angles": add_joint_angles(builder, finger)}
    measurements = add_sensors(builder, finger, scenario.sensor, pressure)
    layout, gravity = sensor_layout(finger.finger, scenario.sensor), np.array(scenario.gravity)
    estimated = add_estimation(builder, finger.name, layout, scenario.estimator, scenario.sensor, gravity, measurements)
    return {f"{finger.name}.{name}": port for name, port in {**measurements, **estimated}.items()}

"""Soft, sensing grippers on Drake's systems framework: the public names, each loaded when it is first used.

from soft_gripper import load_scenario, simulate

recording = simulate(load_scenario("box_grasp"))
"""

from importlib import import_module
from typing import Any

_MODULES = {
    # Scenarios, stations, runs.
    "diagrams.schema.scenario": "Scenario ModelConfig MeshConfig PressureConfig ControlConfig ArmConfig TaskConfig"
    " PhaseConfig PoseErrorConfig SensorConfig StrainErrorsConfig DeadSensorConfig PressureErrorsConfig EstimatorConfig"
    " BelievedConfig FingerConfig TrialsConfig",
    "diagrams.schema.scenario_file": "load_scenario changed_scenario dump_scenario scenario_names",
    "diagrams.station": "add_station make_station",
    "diagrams.simulation": "simulate run_station make_simulator solver_config",
    "diagrams.recording.recording": "Recording read_logs",
    "diagrams.recording.signal_logs": "add_logs",
    "diagrams.recording.phase_spans": "phase_spans",
    "diagrams.random_seed": "seed_random_sources",
    "signals": "describe",
    "array_block": "ArrayBlock",
    "piecewise_linear": "PiecewiseLinear",
    "piecewise_linear_block": "PiecewiseLinearBlock",
    # In a diagram of one's own.
    "diagrams.loading.model_files": "add_fingers find_fingers model_path",
    "diagrams.wiring.drive": "add_pressure_drive",
    "diagrams.wiring.sensing": "add_sensing SensingConfig",
    "diagrams.wiring.sensors": "add_sensors sensor_layout",
    "diagrams.wiring.estimation": "add_estimation FingerEstimation",
    "diagrams.wiring.scoring": "add_scoring",
    "diagrams.wiring.grip_control": "add_grip_control",
    "diagrams.manipulation.arm": "make_arm",
    # Fingers.
    "fingers.cross_section": "CrossSection",
    "fingers.finger": "Finger",
    "fingers.finger_parts": "ContactMaterial ElasticLaw CreepBranch PressureLaw TipLoad",
    "fingers.creep": "advance memory_torque",
    "fingers.creep_torque": "CreepTorque",
    "fingers.materials": "SILICONES",
    "fingers.urdf": "expand_urdf",
    "fingers.plant_finger": "PlantFinger",
    "fingers.kinematics": "forward_kinematics as_points as_planar",
    "fingers.statics": "gravity_torque free_bending_angles resting_angles softened",
    "fingers.pressure_drive": "PressureDrive pressure_torque_map",
    # Sensors.
    "sensors.sensor_layout": "SensorLayout extension_ratios",
    "sensors.response_curve": "ResponseCurve",
    "sensors.calibrated_response": "CalibratedResponse",
    "sensors.strain_sensor": "StrainSensor",
    "sensors.strain_errors": "StrainErrors Draws disturb draw",
    "sensors.strain_error_block": "StrainErrorBlock",
    "sensors.pressure_errors": "PressureErrors disturb_pressure",
    "sensors.error_block": "ErrorBlock ErrorModel",
    "diagrams.schema.sensor_presets": "strain_errors pressure_errors",
    "sensors.base_pose_sensor": "BasePoseSensor",
    "sensors.fixed_base_pose": "FixedBasePose",
    # Estimation.
    "shape.estimate": "ShapeEstimate ShapeFunction ContactForce",
    "shape.driving_torque": "DrivingTorque recorded_driving driving_torques",
    "shape.uncertainty": "Uncertainty",
    "shape.sensor_uncertainty": "uncertainty_of",
    "shape.section_bends": "section_bends",
    "shape.position_band": "position_std",
    "estimators.shape_functions": "SHAPE_FUNCTIONS",
    "estimators.shape_estimator": "ShapeEstimator",
    "estimators.recursive_estimator": "RecursiveEstimator",
    "estimators.recursive_shape": "RecursiveShape",
    "estimators.gaussian": "GaussianShape",
    "estimators.contact_shape": "ContactShape",
    "shape.arcs": "points_on_arcs",
    "estimators.section_arcs": "arcs_from_readings joints_on_arcs",
    "estimators.bend_sharing": "BendSharing",
    "shape.bending_plane": "pose_entries bending_plane",
    "estimation.torque_balance": "TorqueBalance Motion windows",
    "estimators.arc_pose_estimator": "ArcPoseEstimator",
    "shape.finger_shape": "FingerShape",
    "estimation.force_estimator": "ForceEstimator",
    "estimation.contact_detector": "ContactDetector",
    "estimation.gripper_opening": "Gripper GripperOpening",
    "estimation.object_width": "ObjectWidth",
    "estimation.shape_model": "ShapeModel grasp_features",
    "estimation.shape_recognizer": "ShapeRecognizer",
    "estimation.shape_training": "train_shape_model",
    "estimation.calibration": "calibrate FreeBending Calibration",
    "diagrams.loading.calibration_file": "load_calibration save_calibration",
    "evaluation.calibrate_recordings": "calibrate_recordings",
    "diagrams.loading.shape_model_file": "load_shape_model save_shape_model",
    # Control and manipulation.
    "control.pid_controller": "SampledPidController PidGains",
    "manipulation.arm_kinematics": "movable_joints",
    "manipulation.arm_motion": "ArmLimits",
    "manipulation.task_phases": "Outcome QUIET_TIME",
    # What is known in simulation only, and what is made of it.
    "truth.metrics": "PoseError pose_error fingertip_error",
    "truth.true_contact": "TrueContact",
    "evaluation.paper.held_steps": "held_samples",
    "evaluation.paper.readings_again": "read_again external_torque_again",
    "evaluation.phase_table": "phase_table outcome",
    "evaluation.step_table": "step_table true_opening",
    "evaluation.step_figure": "step_figure",
    "evaluation.pid_regimes": "regime_scenarios regimes_figure",
    "evaluation.tuning": "tune step_response gains_from_step_response",
    "evaluation.contacts.dataset": "load_contacts Contacts",
    "evaluation.trials.trial": "trial_row",
    "evaluation.trials.trial_run": "detection_delay",
    # Recordings of hardware.
    "diagrams.hardware.find_recordings": "find_recordings",
    "diagrams.hardware.hardware_recording": "HardwareRecording",
    "evaluation.identify.measured_motion": "measured_motion MeasuredMotion",
    "evaluation.identify.simulated_motion": "simulated_markers Setup",
    "evaluation.identify.identify": "identify Identified",
    "evaluation.identify.identify_figure": "identify_figure",
    "evaluation.identify.finger_file": "read_finger with_finger",
    "evaluation.executor.executor": "open_executor",
    "evaluation.sweep.variation_run": "run_variation",
    "evaluation.sweep.axes": "points Values Range",
    "evaluation.sweep.sweep": "run_sweep",
    # Learning.
    "learning.environment": "SoftGripperEnv",
    "learning.schema.environment_file": "load_environment environment_names",
    "learning.gentle_grasp.policies": "GentleGrasp GentleParameters HandTuned grip_torque",
    "learning.gentle_grasp.episodes": "hand_tuned_environment run_episodes",
    "learning.gentle_grasp.learn": "learn",
    "learning.gentle_grasp.learned": "load_learned",
    "learning.gentle_grasp.compare": "summary saved_force",
    "learning.gentle_grasp.learning_figure": "learning_figure",
    # Pictures.
    "diagrams.view.block_diagram": "graphviz save_block_diagram",
    "diagrams.view.torque_colors": "add_torque_bar",
    "pictures.rendering": "SceneRenderer",
    "pictures.shape_figure": "shape_figure",
    "pictures.phases_figure": "phases_figure",
    "evaluation.figure_style": "section_style COLORS",
    # Mistakes.
    "errors": "InputError SimulationDivergedError WorkerDiedError",
}
_HOMES = {name: module for module, names in _MODULES.items() for name in names.split()}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'soft_gripper' has no attribute '{name}'")
    value = getattr(import_module(f"soft_gripper.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__

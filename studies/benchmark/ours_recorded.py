"""Fits our estimators and models to the training recordings of hardware, for the tasks of the benchmark.

The bands of a fitted model are those of its errors in the training set.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from soft_gripper.arrays import Array
from soft_gripper.errors import SimulationDivergedError
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.hardware.identification.free_parameters import Model, free_parameters
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.settled_states import (
    SettledStates,
    fit_states,
    predicted_markers,
    resting_positions,
)
from soft_gripper.extras.hardware.recording_schema import PRESSURE, RecordingConfig, load_description
from soft_gripper.extras.hardware.recordings import frame_axes, read_recording
from soft_gripper.extras.hardware.replay.arm_estimation import (
    ArmRecording,
    ReplayInputs,
    arm_recording,
    estimate_recording,
)
from soft_gripper.extras.hardware.replay.geometry_band import body_band
from soft_gripper.extras.hardware.replay.held_out import FittedArm, fit_arm
from soft_gripper.fingers.creep import advance, memory_torque
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.kinematics import as_points, forward_kinematics, gravity_torque, in_space, rotated
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.model_files import model_path
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from studies.benchmark.baselines import Mean, add_stds, error_function
from studies.benchmark.benchmark_task import Estimator, Predict, Predicted, Question, Recorded
from studies.benchmark.ours_simulated import add_tip_std
from studies.benchmark.tasks import tip_motion


def _finger(description: str) -> Finger:
    """First guess of the finger of a shipped description."""
    return read_finger(model_path(f"package://soft_gripper/recordings/{description}.urdf"))


def _paths(train: Sequence[Recorded]) -> list[Path]:
    return [recorded.path for recorded in train if recorded.path is not None]


def _period(task: Question) -> float:
    assert task.period is not None
    return task.period


def _add_training_stds(mean: Mean, train: Sequence[Recorded]) -> Predict:
    """Adds the standard deviations of the training errors to a fitted model."""
    return add_stds(mean, map(error_function(mean), train))


_ARM_NAME = "two_segment_arm"
_RADIUS_95 = 2.448  # deviations along an axis, within which 95 % of a planar normal distribution lie


@lru_cache(maxsize=1)
def _fitted_arm(paths: tuple[Path, ...]) -> tuple[FittedArm, ArmRecording]:
    """Arm fitted to recordings, and the first recording."""
    description = load_description(_ARM_NAME)
    recordings = [read_recording(path, description) for path in paths]
    gravity = recordings[0].gravity
    assert gravity is not None
    arms = [arm_recording(recording) for recording in recordings]
    return fit_arm(arms, _finger(_ARM_NAME), gravity), arms[0]


def arm_tip(name: str) -> Estimator:
    """Estimates the tip of the arm by an estimator of the shape with two sensors per side, as `replay` does.

    The band of `arcs` is that of `replay`, which widens away from the fitted states.
    """

    def estimator(task: Question, train: Sequence[Recorded]) -> Predict:
        description = load_description(_ARM_NAME)
        fitted, template = _fitted_arm(tuple(_paths(train)))

        def mean(inputs: Array) -> Array:
            wires, pressures = _arm_readings(description, np.vstack([inputs, inputs[-1:]]))
            no_poses = np.full((len(wires), 2, 2), np.nan)
            replay = ReplayInputs(_period(task), wires, pressures, template.bodies, no_poses)
            signals = estimate_recording(fitted.arm, replay, {name: (name, 2)}, {})
            tip: Array = signals.samples(f"{name}.body_positions")[:, -1]
            return tip * [1, -1]  # the arm hangs

        def predict(inputs: Array) -> tuple[Array, Array]:
            wires, pressures = _arm_readings(description, inputs)
            no_poses = np.full(wires.shape[:2], np.nan)
            recording = replace(
                template,
                time=_period(task) * np.arange(len(wires)),
                inner=wires[:, 0],
                outer=wires[:, 1],
                pressures=pressures,
                positions=no_poses.astype(np.complex128),
                headings=no_poses,
            )
            std = body_band(fitted.band, fitted.geometry, recording, _finger(_ARM_NAME)).radius[:, -1:] / _RADIUS_95
            return mean(inputs), np.broadcast_to(std, (len(std), 2))

        return predict if name == "arcs" else _add_training_stds(mean, train)

    return estimator


def _arm_readings(description: RecordingConfig, inputs: Array) -> tuple[Array, Array]:
    """Wires (T, 2, 2) m and pressures (T, 6) Pa of inputs, in the order of the description."""
    lengths = description.lengths
    assert lengths is not None
    assert lengths.scale is not None
    inner_1, outer_1, outer, inner = lengths.scale * inputs[:, :4].T
    wires = np.stack([np.stack([inner_1, inner], axis=1), np.stack([outer_1, outer], axis=1)], axis=1)
    return wires, PRESSURE["psi"] * inputs[:, 4:]


_BEAM_NAME = "clamped_beam"
_TURN_NOISE = 2e-3  # rad, of the turn by three markers
_USUAL_LOAD = 0.1  # N m at its base: 100 g at its tip
# A chamber that is never under pressure, since estimators relate usual loads to the torque of a pressure.
_SMALL_CHAMBER = 1e-3  # m
_BEAM_GRAVITY = 9.81j  # m/s^2: the beam is horizontal, and sags toward its inner side


def _marker_place(train: Sequence[Recorded], description: str, finger: Finger) -> complex:
    """Middle of the markers in the frame of the tip, m, z + i x."""
    middles = [tip_motion(description, path)[0].reference.mean() for path in _paths(train)]
    return complex(np.mean(middles)) - finger.length


def _displaced(finger: Finger, place: complex, q: Array) -> Array:
    """Displacement of markers at a place beyond the tip from the straight finger, (..., N) rad -> (..., 2) m."""
    chain = forward_kinematics(q, finger.segment_length)
    position = chain.tip + rotated(np.array(place), chain.headings[..., -1])
    return as_points(position - finger.length - place)


def beam_tip(name: str) -> Estimator:
    """Estimates the tip of the beam; the rotation of its end is the reading of a sensor along its whole length.

    Its dimensions and its material are those of the data sheet.
    """

    def estimator(task: Question, train: Sequence[Recorded]) -> Predict:
        chamber = {
            "chamber_width": _SMALL_CHAMBER,
            "chamber_thickness": _SMALL_CHAMBER,
            "chamber_center": -_SMALL_CHAMBER,
        }
        finger = _finger(_BEAM_NAME).with_sections(lambda part: replace(part, **chamber))
        sensors, place = SensorLayout(finger, 1), _marker_place(train, _BEAM_NAME, finger)
        noise = _TURN_NOISE * float(np.abs(sensors.offsets).max()) / finger.length
        load = _USUAL_LOAD / float(finger.pressure_gain.max())
        function = estimator_function(name, sensors, Uncertainty(reading=noise, load_pressure=load), _period(task))

        def predict(inputs: Array) -> Predicted:
            readings = sensors.response.reading(extension_ratios(sensors, sensors.shared_equally(inputs)))
            estimate: ShapeEstimate = function(
                readings, np.zeros((len(inputs), finger.segments)), in_space(np.array(_BEAM_GRAVITY))
            )
            return add_tip_std(_displaced(finger, place, estimate.q), finger, estimate)

        return predict

    return estimator


_SAG_COLUMN = 1  # column of the inputs: displacement of the tip across the beam
_MAX_LOAD, _MASS_COUNT = 0.25, 26  # kg on a beam at most, and how many are computed


def beam_load(task: Question, train: Sequence[Recorded]) -> Predict:
    """Estimates the mass that explains the sag of a beam at rest; its modulus is fitted to the training set."""
    nominal, masses = _finger(_BEAM_NAME), np.linspace(0.0, _MAX_LOAD, _MASS_COUNT)
    load_place = load_description(_BEAM_NAME).load_place
    place = _marker_place(train, _BEAM_NAME, nominal)
    assert load_place is not None

    def sags(modulus: float) -> Array:
        """Sag under every mass, m."""
        finger = nominal.with_sections(lambda section: replace(section, youngs_modulus=modulus))
        beams = [finger, *(replace(finger, tip_load=TipLoad(float(mass), *load_place)) for mass in masses[1:])]
        return np.array([_displaced(beam, place, resting_angles(beam, 0.0, _BEAM_GRAVITY))[0] for beam in beams])

    sag = np.array([recorded.inputs[:, _SAG_COLUMN].mean() for recorded in train])
    mass = np.array([1e-3 * recorded.outputs.mean() for recorded in train])
    start = np.log(nominal.base.youngs_modulus)
    fitted = least_squares(lambda x: np.interp(mass, masses, sags(np.exp(x[0]))) - sag, [start]).x
    fitted_sags = sags(float(np.exp(fitted[0])))
    return _add_training_stds(lambda inputs: 1e3 * np.interp(inputs[:, [_SAG_COLUMN]], fitted_sags, masses), train)


_SEGMENT_NAME = "pneumatic_segment"
_SEGMENT_KEYS = ("pressure_law", "creep.share")
_STRIDE = 5  # one in so many samples is fitted


def segment_tip(task: Question, train: Sequence[Recorded]) -> Predict:
    """Balances pressure, weight and creep of a finger; pressure law and creep are fitted to the training set."""
    finger, period = _finger(_SEGMENT_NAME), _period(task)
    place = _marker_place(train, _SEGMENT_NAME, finger)
    free = free_parameters(finger, _SEGMENT_KEYS, [1e3 * float(recorded.inputs.max()) for recorded in train])

    def mean(finger_: Finger, inputs: Array, stride: int = 1) -> Array:
        q = _creeping_angles(finger_, 1e3 * inputs[::stride, 0], stride * period)
        return _displaced(finger_, place, q)

    def errors(x: Array) -> Array:
        model = free.build_model(x).finger
        differences = [
            (mean(model, recorded.inputs, _STRIDE) - recorded.outputs[::_STRIDE]) / np.abs(recorded.outputs).max()
            for recorded in train
        ]
        return np.vstack(differences).ravel()

    bounds = free.bounds
    start = np.clip(free.start, *bounds)
    model = free.build_model(least_squares(errors, start, bounds=bounds, x_scale=free.scales, diff_step=1e-3).x).finger
    sorted_recordings = sorted(train, key=lambda recorded: float(recorded.inputs.max()))
    pressures = [float(recorded.inputs.max()) for recorded in sorted_recordings]
    differences = [mean(model, recorded.inputs) - recorded.outputs for recorded in sorted_recordings]
    stds = np.array([np.sqrt((recording_errors**2).mean(axis=0)) for recording_errors in differences])

    def predict(inputs: Array) -> tuple[Array, Array]:
        """Mean and band: errors grow with pressure, so the band is interpolated at the highest pressure so far."""
        highest = np.maximum.accumulate(inputs[:, 0])
        return mean(model, inputs), np.stack([np.interp(highest, pressures, std) for std in stds.T], axis=-1)

    return predict


def _creeping_angles(finger: Finger, pressures: Array, period: float) -> Array:
    """Joint angles of a hanging finger under pressures (T,) Pa that are held for a period, (T, N) rad; no inertia."""
    angles: Array = np.zeros((len(pressures), finger.segments))
    q: Array = np.zeros(finger.segments)
    z: Array = np.zeros((len(finger.creep), finger.segments))
    for row, pressure in zip(angles, pressures, strict=True):
        driving = finger.pressure_torque(pressure) + memory_torque(finger, z, pressure)
        q = finger.angle(driving + gravity_torque(finger, q, np.array(abs(_BEAM_GRAVITY))), pressure)
        bend = q / finger.softening(pressure)
        z = advance(finger.creep, z, bend, bend, period)
        row[:] = q
    return angles


@dataclass(frozen=True)
class _TendonBody:
    """A finger that rests where its tendons, springs and weight balance, and the description of its recordings."""

    finger: Finger
    description: RecordingConfig
    columns: tuple[str, ...]  # of its tendons, in the order of the inputs

    def pulled(self, inputs: Array) -> Array:
        """Lengths of its tendons that are pulled in, m, from inputs (T, columns)."""
        config = self.description.tendons
        assert config is not None
        names = [tendon.name for tendon in self.finger.tendons]
        signs = np.array([-1.0 if name in config.antagonists else 1.0 for name in names])
        columns = config.columns | config.antagonists
        return config.scale * signs * inputs[:, [self.columns.index(columns[name]) for name in names]]

    def states(self, inputs: Array, outputs: Array, load: float = 0.0) -> SettledStates:
        """Rows with markers (T, 3 M) m in the axes of the recording, with a load at the tip, kg."""
        markers, config = self.description.markers, self.description
        assert markers is not None
        gravity = np.zeros(3) if config.gravity is None else np.array(config.gravity)
        return SettledStates(
            "benchmark",
            self.pulled(inputs),
            outputs.reshape(len(outputs), -1, 3) @ frame_axes(self.description),
            np.array(list(markers.places.values())),
            np.full(len(inputs), ""),
            gravity @ frame_axes(self.description),
            np.array([markers.at.get(name, 1.0) for name in markers.places]),
            load,
        )

    def fit(self, keys: Sequence[str], states: Sequence[SettledStates]) -> tuple[Model, Array]:
        """Fits keys to states: the model, and the position of its base in the axes of the recording, (3,) m."""
        parameters = free_parameters(self.finger, keys, [])
        model = fit_states(parameters, states).model
        differences = [recording.markers - _markers(model, recording) for recording in states]
        return model, np.concatenate(differences).mean(axis=(0, 1)) @ frame_axes(self.description).T


def _markers(model: Model, states: SettledStates) -> Array:
    """Predicted markers in B, (T, M, 3) m; rows without a balance repeat those before.

    Raises:
        SimulationDivergedError: if the finger finds no balance in any row.
    """
    markers = predicted_markers(model.finger, states, resting_positions(model, states))[0]
    is_balanced = np.isfinite(markers).all(axis=(1, 2))
    if not is_balanced.any():
        raise SimulationDivergedError("the finger finds no shape in balance with its tendons")
    last = np.maximum.accumulate(np.where(is_balanced, np.arange(len(is_balanced)), is_balanced.argmax()))
    return markers[last]


def _balance(
    body: _TendonBody, keys: Sequence[str], train: Sequence[Recorded], stride: int = 1, load: float = 0.0
) -> Predict:
    """Predicts markers by a model whose keys are fitted to one in `stride` training rows, under a load, kg.

    Tests are predicted with the load of the training set.
    """
    thinned = [Recorded(recorded.inputs[::stride], recorded.outputs[::stride]) for recorded in train]
    states = [body.states(recorded.inputs, recorded.outputs, load) for recorded in thinned]
    model, base = body.fit(keys, states)

    def mean(inputs: Array) -> Array:
        no_markers = np.zeros((len(inputs), states[0].markers[0].size))
        markers: Array = _markers(model, body.states(inputs, no_markers, load)) @ frame_axes(body.description).T + base
        return markers.reshape(len(inputs), -1)

    return _add_training_stds(mean, thinned)


def tendons_tip(task: Question, train: Sequence[Recorded]) -> Predict:
    """Balances a robot's springs and tendons, as `identify` does."""
    name = f"tendon_robot_{task.name.split('_')[1]}"
    description = load_description(name)
    assert description.tendons is not None
    body = _TendonBody(_finger(name), description, tuple(description.tendons.columns.values()))
    return _balance(body, ("tendon.angle", "tendon.slack", "tendon.stiffness", "dry_friction"), train)


_TRUNK_KEYS = ("youngs_modulus", "tendon.lever", "tendon.angle", "tendon.slack", "tendon.stiffness")
_FITTED_ROWS = 100  # rows of the training set that are fitted
_LOAD_STRIDE = 240  # one in so many training rows is fitted
_WEIGHED, _WINDOW_ROWS = 10, 300  # one in so many rows is weighed; last weighed rows that count: 30 s


def _trunk(description: str = "soft_trunk", motor: str = "phi") -> _TendonBody:
    motors = tuple(f"{motor}{number}" for number in range(1, 7))
    return _TendonBody(_finger(description), load_description(description), motors)


def trunk_shape(task: Question, train: Sequence[Recorded]) -> Predict:
    """Balances the trunk's springs, tendons and weight, as `identify` does."""
    return _balance(_trunk(), _TRUNK_KEYS, train, _shape_stride(train))


_TRAINED_LOAD = 0.2  # kg, at the tip of the trunk with other motors


def trunk_dc_shape(task: Question, train: Sequence[Recorded]) -> Predict:
    """Balances a trunk with other motors and a load, without the delay of its description, which looks ahead."""
    return _balance(_trunk("trunk_dc", "u"), _TRUNK_KEYS, train, _shape_stride(train), _TRAINED_LOAD)


def _shape_stride(train: Sequence[Recorded]) -> int:
    return max(sum(len(recorded.inputs) for recorded in train) // _FITTED_ROWS, 1)


def trunk_load(task: Question, train: Sequence[Recorded]) -> Predict:
    """Estimates the mass with which the fitted trunk agrees best with the disks of the last 30 s, as `weigh` does."""
    body, masses = _trunk(), [1e-3 * float(recorded.outputs[0, 0]) for recorded in train]
    stride = slice(None, None, _LOAD_STRIDE)
    states = [
        body.states(recorded.inputs[stride, _DISKS:], recorded.inputs[stride, :_DISKS], mass)
        for recorded, mass in zip(train, masses, strict=True)
    ]
    model, base = body.fit(("density", *_TRUNK_KEYS), states)
    middle, half = (max(masses) + min(masses)) / 2, (max(masses) - min(masses)) / 2

    def mean(inputs: Array) -> Array:
        disks = inputs[::_WEIGHED, :_DISKS] - np.tile(base, _DISKS // 3)
        test_states = body.states(inputs[::_WEIGHED, _DISKS:], disks)
        light, center, heavy = (_markers(model, replace(test_states, load=middle + u * half)) for u in (-1, 0, 1))
        masses_ = middle + half * _best_load_shift(
            test_states.markers - center, (heavy - light) / 2, (heavy + light) / 2 - center
        )
        return 1e3 * np.repeat(np.maximum(masses_, 0.0), _WEIGHED)[: len(inputs), None]

    return _add_training_stds(mean, train)


_NEWTON_STEPS = 4  # of Gauss and Newton


def _best_load_shift(error: Array, slope: Array, curving: Array) -> Array:
    """Least-squares u of  error = slope u + curving u^2  in the window before every row, (T, ...) -> (T,)."""
    # Window sums of the products of slope b, curving c and error e.
    bb, bc, cc = _window_sums(slope**2), _window_sums(slope * curving), _window_sums(curving**2)
    be, ce = _window_sums(slope * error), _window_sums(curving * error)
    u: Array = np.zeros(len(error))
    for _ in range(_NEWTON_STEPS):
        descent = be + u * (2 * ce - bb) - 3 * bc * u**2 - 2 * cc * u**3
        u = u + descent / (bb + 4 * bc * u + 4 * cc * u**2)
    return u


_DISKS = 9  # coordinates


def _window_sums(values: Array) -> Array:
    """Sums over the window that ends with each row, (T, ...) -> (T,)."""
    total = np.concatenate([[0.0], values.sum(axis=(1, 2)).cumsum()])
    ends = np.arange(1, len(total))
    return total[ends] - total[np.maximum(ends - _WINDOW_ROWS, 0)]

"""A free object in a recording: its poses, its motion on the fingers, and the signals by which its grasp is judged."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import GeometryId

from soft_gripper.arrays import Array
from soft_gripper.control.task import Phase
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import first_body
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.spatial_chain import vector_product
from soft_gripper.runs.scores.grasp import GraspSignals
from soft_gripper.truth.contact import combined_friction

NORMAL = "grip_normal_force"
_SIGNALS = (NORMAL, "grip_friction_force", "grip_force", "grip_area", "grip_pressure")
Rows = NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class RecordedObject:
    """An object and F fingers at the T samples of a recording."""

    station: Station
    recording: Recording
    name: str

    def values(self, signal: str) -> Array:
        """A signal of the object, (T, ...)."""
        return self.recording.values(f"{self.name}.{signal}")

    @property
    def phases(self) -> Array:
        """Number of the phase of the task, (T,)."""
        return self.recording.values("task.phase").ravel()

    @cached_property
    def samples(self) -> Rows:
        """Samples of known contact; in a task, only those of `precedes_put_down`."""
        is_known = np.isfinite(self.values(NORMAL)).all(axis=1)
        if self.station.task is not None:
            is_known &= precedes_put_down(self.phases, self.station.task.phases)
        return np.flatnonzero(is_known)

    @cached_property
    def poses(self) -> Array:
        """Poses of the object in the world, (T, 3, 4) [R | p]."""
        from scipy.spatial.transform import Rotation

        pose = self.values("pose")
        rotations = Rotation.from_quat(pose[:, :4], scalar_first=True).as_matrix()
        return np.concatenate([rotations, pose[:, 4:, None]], axis=-1)

    @cached_property
    def base_poses(self) -> Array:
        """Poses of the bases of the fingers in the world, (F, T, 3, 4) [R | p]."""
        plant, fingers = self.station.plant, self.station.fingers
        if all(finger.is_anchored for finger in fingers):
            fixed_poses = [[finger.X_WB.GetAsMatrix34()] for finger in fingers]
            return np.broadcast_to(fixed_poses, (len(fingers), len(self.poses), 3, 4))
        context, X_WB = plant.CreateDefaultContext(), np.empty((len(fingers), len(self.poses), 3, 4))
        for i, state in enumerate(self.recording.values("plant.state")):
            plant.SetPositionsAndVelocities(context, state)
            X_WB[:, i] = [finger.base.EvalPoseInWorld(context).GetAsMatrix34() for finger in fingers]
        return X_WB

    @cached_property
    def link_poses(self) -> Sequence[Array]:
        """Poses of the links of each finger in its base, (T, N, 3, 4) [R | p]."""
        states = self.recording.values("plant.state")
        return [finger.screws.poses(states)[:, :-1] for finger in self.station.fingers]

    @cached_property
    def contact_centers(self) -> Array:
        """True centres of contact of the fingers in the world, (F, T, 3) m; NaN without contact."""
        return np.stack([self.recording.values(f"{finger.name}.contact_center") for finger in self.station.fingers])

    @cached_property
    def coefficients(self) -> Array:
        """Static coefficients of friction between the fingers and the object, (F,), of the smoothest geometry."""
        if (friction := self.station.parts.frictions.get(self.name)) is None:
            friction = _static_friction(self.station, self._geometries)
        finger_frictions = (finger_friction(self.station, finger) for finger in self.station.fingers)
        return np.array([combined_friction(other, friction) for other in finger_frictions])

    @property
    def _geometries(self) -> Sequence[GeometryId]:
        """Collision geometries of the object's first link."""
        if self.name in self.station.parts.deformables:
            return [self.station.parts.deformables[self.name].geometry]
        plant = self.station.plant
        return plant.GetCollisionGeometriesForBody(first_body(plant, self.name))

    @property
    def mass(self) -> float:
        """The mass of all its links, kg."""
        plant, parts = self.station.plant, self.station.parts
        if self.name in parts.deformables:
            return parts.deformables[self.name].mass
        if self.name in parts.masses:
            return parts.masses[self.name]
        bodies = plant.GetBodyIndices(plant.GetModelInstanceByName(self.name))
        return float(sum(plant.get_body(index).default_mass() for index in bodies))

    @cached_property
    def signals(self) -> GraspSignals:
        """Signals that judge the grasp of the object, at `samples`."""
        samples, time = self.samples, self.recording.values("time")[self.samples]
        normal, friction, force, area, pressure = (self.values(name)[samples] for name in _SIGNALS)
        gravity = np.array(self.station.plant.gravity_field().gravity_vector())
        pull = float(np.linalg.norm(gravity))
        other_force = self.values("contact_wrench")[samples, 3:] - force.sum(axis=1)
        support = -other_force @ gravity / pull if pull > 0 else np.zeros(len(samples))
        X_WO, X_WB = self.poses[samples], self.base_poses[0, samples]
        R_BW = np.swapaxes(X_WB[..., :3], -1, -2)
        place, turn = (R_BW @ (X_WO[..., 3:] - X_WB[..., 3:]))[..., 0], R_BW @ X_WO[..., :3]
        return GraspSignals(
            *(time, normal, friction, area, pressure, support, place, turn),
            *(self.mass * pull, self.coefficients),
        )

    def shifts(self, samples: Rows) -> Array:
        """Shift of the object along each of the F touching fingers since the first of some samples, (K, F, 2) m.

        At the first sample, the true contact centre of each finger marks a point on the object and one on the nearest
        link. The shift leads from one to the other along the link's inner face (its y and z axes).
        """
        if not len(samples):
            return np.empty((0, 0, 2))
        X_WO, shifts = self.poses[samples], []
        places = (self.base_poses[:, samples], self.contact_centers[:, samples], self.link_poses)
        for finger, X_WB, p_WC, link_poses in zip(self.station.fingers, *places, strict=True):
            if np.isfinite(p_WC[0]).all():
                X_BL = link_poses[samples]
                link, on_link = nearest_link(finger, X_BL[0], seen_from(X_WB[0], p_WC[0]))
                on_object = (p_WC[0] - X_WO[0, :, 3]) @ X_WO[0, :, :3]
                p_WO = X_WO[..., :3] @ on_object + X_WO[..., 3]
                shifts.append(face_shifts(X_BL[:, link], seen_from(X_WB, p_WO), on_link))
        return np.stack(shifts, axis=1) if shifts else np.empty((len(samples), 0, 2))

    def slip(self, samples: Rows) -> Array:
        """Length of `shifts`, averaged over the touching fingers, (K,) m; NaN without contact at the first sample."""
        shifts = self.shifts(samples)
        if not shifts.shape[1]:
            return np.full(len(shifts), np.nan)
        return np.linalg.norm(shifts, axis=-1).mean(axis=1)

    def sliding_speeds(self, samples: Rows) -> Array:
        """Speed at which a rigid object slides along each finger, (K, F) m/s; NaN where they do not touch.

        It is that of the object relative to the nearest link, at the true centre of contact. In all directions: where
        the edge of a tip touches, the object does not slide along the link's inner face.
        """
        plant, fingers = self.station.plant, self.station.fingers
        if self.name in self.station.parts.deformables:
            return np.full((len(samples), len(fingers)), np.nan)
        p_WC = np.swapaxes(self.contact_centers[:, samples], 0, 1)
        states = self.recording.values("plant.state")[samples]
        touches = np.isfinite(p_WC).all(axis=-1)
        link_numbers, p_WL = np.zeros(touches.shape, int), np.empty_like(p_WC)
        for j, X_WB in enumerate(self.base_poses[:, samples]):
            X_BL = self.link_poses[j][samples]
            link_numbers[:, j], _ = nearest_link(fingers[j], X_BL, seen_from(X_WB, p_WC[:, j]))
            p_BL = X_BL[np.arange(len(samples)), link_numbers[:, j], :, 3]
            p_WL[:, j] = (X_WB[..., :3] @ p_BL[..., None])[..., 0] + X_WB[..., 3]
        body, context = first_body(plant, self.name), plant.CreateDefaultContext()
        V = np.full((2, *touches.shape, 6), np.nan)
        for i in np.flatnonzero(touches.any(axis=1)):
            plant.SetPositionsAndVelocities(context, states[i])
            V[0, i] = body.EvalSpatialVelocityInWorld(context).get_coeffs()
            for finger in np.flatnonzero(touches[i]):
                link = fingers[finger].links[link_numbers[i, finger]]
                V[1, i, finger] = link.EvalSpatialVelocityInWorld(context).get_coeffs()
        p_WO = self.poses[samples][:, None, :, 3]
        return np.asarray(np.linalg.norm(_velocity(V[0], p_WC - p_WO) - _velocity(V[1], p_WC - p_WL), axis=-1))


def precedes_put_down(numbers: Array, phases: Sequence[Phase]) -> NDArray[np.bool_]:
    """The samples up to the end of the last phase that carries an object, (T).

    The last of several phases that hold it puts it down if another phase follows, and does not count. Without phases
    that hold an object, or if none was reached, all samples count. `numbers` are those of the phases, (T).
    """
    holding = [number for number, phase in enumerate(phases) if phase.holds]
    if len(holding) > 1 and phases[holding[-1]].follower < len(phases):
        holding.pop()
    carries = np.isin(numbers, holding)
    is_before: NDArray[np.bool_] = np.logical_or.accumulate(carries[::-1])[::-1]
    return is_before if carries.any() else ~is_before


def finger_friction(station: Station, finger: PlantFinger) -> float:
    """Static coefficient of friction of a finger's smoothest geometry."""
    geometries = [geometry for link in finger.links for geometry in station.plant.GetCollisionGeometriesForBody(link)]
    return _static_friction(station, geometries)


def _static_friction(station: Station, geometries: Sequence[GeometryId]) -> float:
    """The least static coefficient of friction of collision geometries; 0 if there are none."""
    inspector = station.parts.scene_graph.model_inspector()
    properties = [values for values in map(inspector.GetProximityProperties, geometries) if values is not None]
    return min(
        (values.GetProperty("material", "coulomb_friction").static_friction() for values in properties), default=0.0
    )


def _velocity(V: Array, p: Array) -> Array:
    """Velocities at points, (..., 3) m/s, from spatial velocities [angular, linear] at origins p away, (..., 6)."""
    return np.asarray(V[..., 3:] + vector_product(V[..., :3], p))


def face_shifts(X: Array, p: Array, on_link: Array) -> Array:
    """Shifts of a point p of the object from a point of a link, along the link's inner face, (..., 2) m.

    X is the pose of the link, (..., 3, 4), in the frame of p, (..., 3) m; `on_link`, (3,) m, is in that of the link.
    """
    return np.asarray((seen_from(X, p) - on_link)[..., 1:])


def seen_from(X: Array, p: Array) -> Array:
    """Points seen from a frame whose pose is X, (..., 3, 4) [R | p] and (..., 3) m -> (..., 3) m."""
    return np.asarray(((p - X[..., 3])[..., None, :] @ X[..., :3])[..., 0, :])


def nearest_link(finger: PlantFinger, X: Array, p: Array) -> tuple[NDArray[np.int_], Array]:
    """The number of the link whose centre is nearest to a point, (...), and the point in its frame, (..., 3) m.

    `X` are the poses of all links in any frame, (..., L, 3, 4), and `p` the point in it, (..., 3) m.
    """
    points = seen_from(X, p[..., None, :])
    middles = np.diff(finger.finger.link_ends) / 2
    link = np.argmin(np.linalg.norm(points - np.outer(middles, [0.0, 0.0, 1.0]), axis=-1), axis=-1)
    return link, np.take_along_axis(points, link[..., None, None], axis=-2)[..., 0, :]

"""Ground truth of a soft object: its pose, its squeeze, and its largest strain.

All follow from the vertices of its finite elements. T samples of V vertices are computed at once, after the run.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import GeometryConfigurationVector, GeometryId
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import DeformableBody
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.diagrams.wiring.plant_signals import POSE, POSE_UNITS, WRENCH, WRENCH_UNITS
from soft_gripper.errors import SimulationDivergedError
from soft_gripper.extras.soft.tetrahedra import Tetrahedra
from soft_gripper.scenario.deformables import Deformable
from soft_gripper.signals import XYZ
from soft_gripper.truth.contact import patches

if TYPE_CHECKING:  # imported when a signal is read
    import xarray as xr


@dataclass(frozen=True, eq=False)
class SoftBody(Deformable):
    """A soft object of a finalized plant."""

    name: str
    body: DeformableBody
    rest: Tetrahedra  # undeformed, in the frame of its file

    @property
    def geometry(self) -> GeometryId:
        return self.body.geometry_id()

    @property
    def mass(self) -> float:
        return float(self.body.config().mass_density() * self.rest.volumes.sum())

    def vertices(self, context: Context) -> Array:
        return self.body.GetPositions(context).T

    def restore(self, context: Context, signals: "xr.Dataset") -> None:
        self.body.SetPositions(context, signals[f"{self.name}.vertices"].values.T)

    def check(self, context: Context) -> None:
        """Raises an error if an element is inside out, which Drake does not."""
        if not self.rest._replace(vertices=self.vertices(context)).volumes.min() > 0:  # or NaN
            raise SimulationDivergedError(
                f"the soft object '{self.name}' was crushed before t = {context.get_time():.4g} s: an element is inside"
                " out; likely cause: a force that its modulus does not bear, or friction below 0.2"
            )

    def add_signals(self, builder: DiagramBuilder, plant: MultibodyPlant) -> dict[str, OutputPort]:
        block = builder.AddNamedSystem(f"{self.name}.shape", SoftObject(self))
        configurations = plant.get_deformable_body_configuration_output_port()
        builder.Connect(configurations, block.GetInputPort("configurations"))
        builder.Connect(plant.get_contact_results_output_port(), block.GetInputPort("contact_results"))
        return {f"{self.name}.{signal}": port for signal, port in vector_outputs(block).items()}


def fitted_pose(rest: Tetrahedra, vertices: Array) -> Array:
    """The pose of the undeformed body that fits the deformed one best, (..., V, 3) m -> (..., 7).

    By least squares over the volume, in which points move linearly between the vertices of an element (Kabsch, Acta
    Crystallographica A32, 1976). A quaternion w x y z, and the position of the frame of the file, in the world.
    """
    from scipy.spatial.transform import Rotation

    weight = np.bincount(rest.cells.ravel(), np.repeat(rest.volumes / 4, 4)) / rest.volumes.sum()
    rest_center, center = weight @ rest.vertices, weight @ vertices
    cross_moments = np.swapaxes(vertices - center[..., None, :], -1, -2) @ _moments(rest, rest.vertices - rest_center)
    left_basis, _, right_basis = np.linalg.svd(cross_moments)
    left_basis[..., 2] *= np.linalg.det(left_basis @ right_basis)[..., None]  # a rotation, not a reflection
    rotation = left_basis @ right_basis
    quaternion = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_quat(canonical=True, scalar_first=True)
    return np.concatenate([quaternion.reshape(*rotation.shape[:-2], 4), center - rotation @ rest_center], axis=-1)


def _moments(rest: Tetrahedra, points: Array) -> Array:
    """Integrates points, (V, 3), times the shape function of each vertex over the volume: (V, 3)."""
    cell_moments = (
        rest.volumes[:, None, None] / 20 * (points[rest.cells] + points[rest.cells].sum(axis=1, keepdims=True))
    )
    moments = np.zeros_like(points)
    np.add.at(moments, rest.cells, cell_moments)
    return moments


def squeeze(rest: Tetrahedra, vertices: Array) -> Array:
    """Squeeze of a body, (..., V, 3) m -> (...) m.

    That is the largest decrease of the distance between any two vertices of its surface: between fingers that press on
    opposite sides, it includes the indentations that they make, which depend on the size of the elements.
    """
    from scipy.spatial.distance import pdist

    surface = np.unique(rest.boundary)
    rest_distances = pdist(rest.vertices[surface])
    deformed_points = vertices[..., surface, :].reshape(-1, len(surface), 3)
    decrease = np.array([np.max(rest_distances - pdist(points)) for points in deformed_points])
    return decrease.reshape(vertices.shape[:-2])


def largest_strain(rest: Tetrahedra, vertices: Array) -> Array:
    """The largest principal strain in any element, stretched or compressed, (..., V, 3) m -> (...).

    A principal stretch minus 1, in absolute value.
    """
    edges, rest_edges = (np.diff(points[..., rest.cells, :], axis=-2) for points in (vertices, rest.vertices))
    gradient = np.swapaxes(np.linalg.solve(rest_edges, edges), -1, -2)  # rows of edges: edges = rest_edges @ gradient'
    stretch = np.linalg.svd(gradient, compute_uv=False)
    return np.abs(stretch - 1).max(axis=(-1, -2))


def move_wrench(wrench: Array, pose: Array) -> Array:
    """Moves wrenches about the origin, (..., 6) N m and N, to the positions of poses, (..., 7)."""
    torque, force = wrench[..., :3], wrench[..., 3:]
    return np.concatenate([torque - np.cross(pose[..., 4:], force), force], axis=-1)


class SoftObject(ArrayBlock):
    """Outputs the shape of a soft object of the plant.

    ::

                            +------------+ ---> vertices       (V x 3) m in the world
        configurations ---> | SoftObject | ---> pose           (7) q_w, q_x, q_y, q_z, x, y, z; m in the world
        contact_results --> |            | ---> squeeze        (1) m
                            |            | ---> largest_strain (1)
                            +------------+ ---> contact_wrench (6) torque at the pose's position, force; N m, N

    The pose is that of the undeformed body that fits it best, see `fitted_pose`. The wrench is that of all contacts.
    """

    def __init__(self, soft: SoftBody):
        super().__init__()
        rest = soft.rest
        self._geometry = soft.geometry.get_value()
        model = Value(GeometryConfigurationVector())
        self._configurations = self.DeclareAbstractInputPort("configurations", model)
        self.show("configuration", self._collect, {self._configurations.ticket()})
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self.show("wrench_at_origin", self._wrench, {self._results.ticket()})
        self.derive("points", np.asarray, "configuration", over_time=np.array)
        self.derive("wrench", np.asarray, "wrench_at_origin", over_time=np.array)
        self.derive("fitted", lambda points: fitted_pose(rest, points), "points")
        labels: dict[str, Sequence[Any]] = {"vertex": range(len(rest.vertices)), "xyz": XYZ}
        self.put_out("vertices", lambda points: points, "points", unit="m", **labels)
        self.put_out("pose", lambda pose: pose, "fitted", unit=POSE_UNITS, pose_entry=POSE)
        self.put_out("squeeze", lambda points: squeeze(rest, points), "points", unit="m")
        self.put_out("largest_strain", lambda points: largest_strain(rest, points), "points")
        self.put_out("contact_wrench", move_wrench, "wrench", "fitted", unit=WRENCH_UNITS, wrench=WRENCH)

    def _wrench(self, context: Context) -> Array:
        """Wrench of all contacts about the origin of the world: torque and force, (6) N m and N."""
        wrench = np.zeros(6)
        for patch in patches(self._results.Eval(context), {self._geometry}):
            sign = 1.0 if patch.geometries[0] == self._geometry else -1.0
            wrench += sign * np.concatenate([patch.torque + np.cross(patch.place, patch.force), patch.force])
        return wrench

    def _collect(self, context: Context) -> Array:
        """The vertices, (V, 3) m in the world."""
        configurations = self._configurations.Eval(context)
        (identifier_,) = (identifier for identifier in configurations.ids() if identifier.get_value() == self._geometry)
        return configurations.value(identifier_).reshape(-1, 3)

"""Compares soft bodies between two rigid plates with closed forms: a compressed block, and a ball.

The lower plate is fixed. The upper one slides along z and is pushed by a force that grows slowly; gravity is off.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple, cast

import numpy as np
from pydrake.geometry import AddContactMaterial, AddRigidHydroelasticProperties, Box, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, default_model_instance
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from scipy.special import eval_legendre

from soft_gripper.arrays import Array
from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.extras.soft.adds import SoftMesh
from soft_gripper.extras.soft.objects.make_soft import block
from soft_gripper.extras.soft.soft_kind import SoftKind
from soft_gripper.extras.soft.tetrahedra import Tetrahedra, orient_cells
from soft_gripper.scenario.schema import MeshConfig, ModelConfig
from studies.verification.tables import DocTable, Row

TIME_STEP = 0.005  # s
RAMP_TIME, HOLD_TIME, RAMP_STEPS = 0.5, 0.5, 50  # s, and the steps in which the force grows
PLATE, MASS, PLATE_DAMPING = (0.12, 0.12, 0.02), 0.02, 2.0  # m, kg, N s/m
DENSITY = 1000.0  # kg/m^3
RADIUS = 0.022  # m, of the ball
BLOCK_SIZE = (0.044, 0.04, 0.06)  # m


@dataclass(frozen=True)
class Material:
    """Material of a soft body."""

    modulus: float = 5e4  # Pa
    poissons_ratio: float = 0.3
    friction: float = 0.3  # of body and plates


class Pressed(NamedTuple):
    """A body at rest between the plates."""

    rest: Tetrahedra
    displacement: Array  # (V, 3) m, of the vertices
    forces: tuple[float, float]  # N along z on the body, of the lower and the upper plate
    approach: float  # m, of the plates


def pressed(mesh: Tetrahedra, material: Material, force: float) -> Pressed:
    """Presses the upper plate down with a force, N."""
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=TIME_STEP, discrete_contact_approximation="sap")
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    _add_body(plant, mesh, material)
    _add_plates(plant, float(mesh.vertices[:, 2].min()), float(mesh.vertices[:, 2].max()), material.friction)
    plant.Finalize()
    soft = SoftKind().objects(plant, scene_graph.model_inspector(), ["body"])["body"]
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for part in range(1, RAMP_STEPS + 1):
        plant.get_actuation_input_port().FixValue(context, [force * part / RAMP_STEPS])
        simulator.AdvanceTo(RAMP_TIME * part / RAMP_STEPS)
    simulator.AdvanceTo(RAMP_TIME + HOLD_TIME)
    return Pressed(
        soft.rest,
        soft.vertices(context) - soft.rest.vertices,
        _forces(plant, context),
        plant.GetPositions(context).item(),
    )


def _add_body(plant: MultibodyPlant, mesh: Tetrahedra, material: Material) -> None:
    """Adds a soft body as a scenario does, from a file."""
    properties, mass = MeshConfig(), DENSITY * float(mesh.volumes.sum())
    soft = cast(SoftMesh, properties)
    soft.youngs_modulus, soft.poissons_ratio = material.modulus, material.poissons_ratio
    with TemporaryDirectory() as folder:
        path = Path(folder) / "body.vtk"
        path.write_text(mesh.as_vtk(), encoding="utf-8")
        config = ModelConfig("body", str(path), free=True, mass=mass, friction=material.friction, mesh=properties)
        load_model(plant, config, "models[0]")


def _add_plates(plant: MultibodyPlant, low: float, high: float, friction: float) -> None:
    """Adds boxes whose faces are at two heights, m."""
    upper = plant.AddRigidBody("plate", default_model_instance(), SpatialInertia.SolidBoxWithMass(MASS, *PLATE))
    for body, middle in ((plant.world_body(), low - PLATE[2] / 2), (upper, high + PLATE[2] / 2)):
        properties = ProximityProperties()
        AddContactMaterial(friction=CoulombFriction(friction, friction), properties=properties)
        AddRigidHydroelasticProperties(PLATE[2], properties)
        name = f"{body.name()}_face"
        plant.RegisterCollisionGeometry(body, RigidTransform([0.0, 0.0, middle]), Box(*PLATE), name, properties)
    press_joint = PrismaticJoint("down", plant.world_frame(), upper.body_frame(), [0, 0, -1], damping=PLATE_DAMPING)
    plant.AddJointActuator("press", plant.AddJoint(press_joint))


def _forces(plant: MultibodyPlant, context: Context) -> tuple[float, float]:
    results = plant.get_contact_results_output_port().Eval(context)
    contacts = map(results.deformable_contact_info, range(results.num_deformable_contacts()))
    axial_forces = [float(contact.F_Ac_W().translational()[2]) for contact in contacts]
    return sum(force for force in axial_forces if force > 0), sum(force for force in axial_forces if force < 0)


def ball(cells: int) -> Tetrahedra:
    """A ball of 6 cells^3 tetrahedra with the volume of a true one: a cube whose layers are moved to spheres."""
    cube = block((2.0, 2.0, 2.0), (cells, cells, cells))
    layer, distance = np.abs(cube.vertices).max(axis=1), np.linalg.norm(cube.vertices, axis=1)
    scale = np.divide(layer, distance, out=np.zeros_like(layer), where=distance > 0)
    mesh = orient_cells(Tetrahedra(cube.vertices * scale[:, None], cube.cells))
    return mesh.scaled(RADIUS * float(4 / 3 * np.pi / mesh.volumes.sum()) ** (1 / 3))


class BallDeformation(NamedTuple):
    """Deformation of a ball, m."""

    halves: float  # approach of the centres of mass of its upper and its lower half
    equator: float  # mean growth of its diameter there
    poles: float  # approach of the two, indentations included


def change(pressed_ball: Pressed) -> BallDeformation:
    """Deformation of a simulated ball."""
    mesh, displacement = pressed_ball.rest, pressed_ball.displacement
    height, axial = mesh.vertices[:, 2], displacement[:, 2]
    is_above = height[mesh.cells].mean(axis=1) > 0
    low, high = (
        np.average(axial[mesh.cells[half]].mean(axis=1), weights=mesh.volumes[half]) for half in (~is_above, is_above)
    )
    distance = np.linalg.norm(mesh.vertices[:, :2], axis=1)
    is_equator = (np.abs(height) < 1e-9) & (distance > 0.95 * RADIUS)
    outward = (displacement[is_equator, :2] * mesh.vertices[is_equator, :2]).sum(axis=1) / distance[is_equator]
    poles = float(axial[np.argmin(height)] - axial[np.argmax(height)])
    return BallDeformation(float(low - high), 2 * float(outward.mean()), poles)


_SERIES_TERMS, _INTEGRAL_NODES = 400, 100  # of the series, and of the integrals


class PressedBall:
    """A ball pressed at its poles with the pressure of Hertz, in linear elasticity.

    Displacements are series of Legendre polynomials that satisfy the equations of equilibrium (Lur'e, Three-Dimensional
    Problems of the Theory of Elasticity, 1964, chapter 6); their coefficients follow from those of the pressure.
    """

    def __init__(self, force: float, material: Material):
        self._nu = nu = material.poissons_ratio
        reduced, shear = material.modulus / (1 - nu**2), material.modulus / (2 * (1 + nu))
        contact = (3 * force * RADIUS / (4 * reduced)) ** (1 / 3)  # m, radius
        self._n = n = np.arange(0, _SERIES_TERMS, 2)
        cosine, weights = _gauss(np.sqrt(1 - (contact / RADIUS) ** 2))
        pressure = np.sqrt(np.maximum(1 - (1 - cosine**2) * (RADIUS / contact) ** 2, 0))
        pressure *= force / (2 * np.pi * RADIUS**2 * float(weights @ (pressure * cosine)))
        stress = -(2 * n + 1) * (eval_legendre(n[:, None], cosine) @ (weights * pressure)) / (2 * shear)
        ratio = (n**2 + 2 * n - 1 + 2 * nu) / (n - 1)  # without shear at the surface
        self._a = stress / ((n + 1) * (n**2 - n - 2 - 2 * nu) - n * (n - 1) * ratio)
        self._b = -self._a * ratio

    def change(self) -> BallDeformation:
        """Deformation of the ball."""
        share, share_weights = _gauss(0.0)
        cosine, cosine_weights = _gauss(0.0)
        axial = self._axial(share[:, None, None], cosine[:, None])
        halves = -6 * float(share_weights * share**2 @ axial @ cosine_weights)  # over the volume of one, 2 pi / 3
        equator, pole = self._radial(1.0, np.array([[0.0], [1.0]])) @ np.ones(len(self._n))
        return BallDeformation(halves, 2 * float(equator), -2 * float(pole))

    def _radial(self, share: Array | float, cosine: Array) -> Array:
        """Terms of the displacement outward, m, at a share of the radius and an angle from the pole; (..., terms)."""
        n, nu = self._n, self._nu
        growth = self._a * (n + 1) * (n - 2 + 4 * nu) * share ** (n + 1.0) + self._b * n * share ** (n - 1.0)
        return RADIUS * growth * eval_legendre(n, cosine)

    def _axial(self, share: Array, cosine: Array) -> Array:
        """Displacement along the axis, m."""
        n, nu = self._n, self._nu
        growth = self._a * (n + 5 - 4 * nu) * share ** (n + 1.0) + self._b * share ** (n - 1.0)
        slope = n * (eval_legendre(np.maximum(n - 1, 0), cosine) - cosine * eval_legendre(n, cosine))  # sin^2 P_n'
        return (self._radial(share, cosine) * cosine + RADIUS * growth * slope).sum(axis=-1)


def _gauss(begin: float) -> tuple[Array, Array]:
    """Nodes and weights of the integral from `begin` to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(_INTEGRAL_NODES)
    return begin + (1 - begin) * (nodes + 1) / 2, (1 - begin) / 2 * weights


def hertz(force: float, material: Material) -> float:
    """Approach of two plates to each other with a ball between them, m, if contacts are small (Hertz, 1881)."""
    plane_modulus = material.modulus / (1 - material.poissons_ratio**2)
    return 2 * float((9 * force**2 / (16 * plane_modulus**2 * RADIUS)) ** (1 / 3))


def shortening(pressed_block: Pressed) -> float:
    """Mean decrease of the height of a block over its ends, m."""
    height, axial = pressed_block.rest.vertices[:, 2], pressed_block.displacement[:, 2]
    ends = [np.isclose(height, end) for end in (height.min(), height.max())]
    return float(axial[ends[0]].mean() - axial[ends[1]].mean())


BLOCK_FORCE, BALL_FORCE = 1.0, 0.34  # N
FOAM = (Material(2e4, 0.0, 0.5), Material(2e4, 0.3, 0.0), Material(2e4, 0.3, 0.5))
CELL_COUNTS = (2, 4, 6, 8)


def block_rows() -> Iterator[Row]:
    """A block of 216 tetrahedra under three kinds of plates and materials."""
    width, depth, height = BLOCK_SIZE
    for material in FOAM:
        expected = BLOCK_FORCE * height / (material.modulus * width * depth)
        shortening_ = shortening(pressed(block(BLOCK_SIZE, (3, 3, 4)), material, BLOCK_FORCE))
        text = f"{material.poissons_ratio} | {material.friction}"
        yield text, [1e3 * shortening_, 1e3 * expected, 100 * (shortening_ / expected - 1)]


def ball_rows(cells: Sequence[int] = CELL_COUNTS) -> Iterator[Row]:
    """Rows of balls with several meshes."""
    material = Material()
    expected = PressedBall(BALL_FORCE, material).change()
    for count in cells:
        mesh = ball(count)
        body = pressed(mesh, material, BALL_FORCE)
        errors = [100 * (simulated / exact - 1) for simulated, exact in zip(change(body), expected, strict=True)]
        plates = 100 * (body.approach / hertz(BALL_FORCE, material) - 1)
        yield f"{len(mesh.cells)}", [*errors, plates]


BLOCKS = DocTable(
    "Poisson's ratio | friction | shortening by [mm] | F h / (E A) [mm] | difference [%]", (3, 3, 2), block_rows
)
BALLS = DocTable("tetrahedra | halves [%] | equator [%] | poles [%] | plates [%]", (1, 1, 1, 1), ball_rows)

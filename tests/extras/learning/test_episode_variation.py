"""What differs from episode to episode, in the context alone; objects of another size, by volumes of their shapes."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.geometry import Box, CalcVolume, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from refusals import refused

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.extras.learning.config import VariationConfig
from soft_gripper.extras.learning.episode_variation import (
    Draw,
    apply_draw,
    draw,
    scaled_shape,
    set_mass,
    varied_fingers,
)


def begun(station, drawn):
    """A simulator at the beginning of an episode."""
    context = station.diagram.CreateDefaultContext()
    size = station.diagram.GetInputPort("action").size()
    station.diagram.GetInputPort("action").FixValue(context, -np.ones(size))
    apply_draw(station, context, drawn)
    simulator = Simulator(station.diagram, context)
    ApplySimulatorConfig(solver_config(station.parts.scenario), simulator)
    simulator.Initialize()
    return simulator


def own(station, simulator):
    return station.parts.plant.GetMyContextFromRoot(simulator.get_context())


def corners(station, simulator):
    """Of the object's shapes, as they are in the context, (M, 3) m."""
    scene_graph = station.parts.scene_graph
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(simulator.get_context()))
    inspector, plant = query.inspector(), station.parts.plant
    spans = []
    for shape in plant.GetCollisionGeometriesForBody(station.object):
        capsule, X_WG = inspector.GetShape(shape), query.GetPoseInWorld(shape)
        reach = np.array([capsule.radius()] * 2 + [capsule.radius() + capsule.length() / 2])
        spans += [X_WG.translation() - reach, X_WG.translation() + reach]
    return np.array(spans)


def test_draws_are_those_of_the_seed_and_within_their_limits():
    config = VariationConfig(offset=0.01, mass=[0.02, 0.06], size=[0.9, 1.1], stiffness=[1e3, 1e5])
    drawn = [draw(np.random.default_rng(seed), config) for seed in range(200)]
    assert drawn[3] == draw(np.random.default_rng(3), config)
    assert all(0.02 <= each.mass <= 0.06 and 0.9 <= each.size <= 1.1 and abs(each.offset) <= 0.01 for each in drawn)
    offsets = [each.offset for each in drawn]
    assert (min(offsets), max(offsets)) == pytest.approx((-0.01, 0.01), abs=5e-4)
    assert all(each.friction is None for each in drawn)
    assert len({each.sensor_seed for each in drawn}) == len(drawn)
    assert np.median([each.stiffness for each in drawn]) == pytest.approx(1e4, rel=0.3)  # even in its logarithm


def test_mass_and_inertia_go_with_mass_and_size(grasp_station):
    body = grasp_station.object
    plain, changed = (
        body.CalcSpatialInertiaInBodyFrame(own(grasp_station, begun(grasp_station, drawn)))
        for drawn in (Draw(), Draw(mass=0.06, size=1.1))
    )
    assert changed.get_mass() == pytest.approx(0.06)
    factor = 1.1**2 * 0.06 / plain.get_mass()
    np.testing.assert_allclose(
        changed.CopyToFullMatrix6(), np.diag([factor] * 3 + [1.5] * 3) @ plain.CopyToFullMatrix6()
    )


@pytest.mark.parametrize("size", [0.8, 1.2])
def test_an_object_of_another_size_stands_where_it_stood(grasp_station, size):
    plain, scaled = (corners(grasp_station, begun(grasp_station, drawn)) for drawn in (Draw(), Draw(size=size)))
    assert scaled[:, 2].min() == pytest.approx(plain[:, 2].min(), abs=1e-6)
    np.testing.assert_allclose(np.ptp(scaled, axis=0), size * np.ptp(plain, axis=0), rtol=1e-9)
    np.testing.assert_array_equal(corners(grasp_station, begun(grasp_station, Draw())), plain)  # for one episode only


def test_friction_is_what_the_object_slides_by(grasp_station):
    """Gravity leans by 10 degrees; of a friction and the table's 0.5 Drake takes the harmonic mean.

    What an object that sticks moves is taken off: it rocks on its rods.
    """
    plant, lean, moved = grasp_station.parts.plant, np.radians(10), []
    before = plant.gravity_field().gravity_vector().copy()
    try:
        for friction in (0.05, 0.9):
            simulator = begun(grasp_station, Draw(friction=friction))
            plant.mutable_gravity_field().set_gravity_vector(9.81 * np.array([np.sin(lean), 0.0, -np.cos(lean)]))
            simulator.AdvanceTo(0.1)
            place = grasp_station.object.EvalPoseInWorld(own(grasp_station, simulator)).translation()
            moved.append(place[0])
    finally:
        plant.mutable_gravity_field().set_gravity_vector(before)
    combined = 2 * 0.05 * 0.5 / 0.55
    sliding = 0.5 * 9.81 * (np.sin(lean) - combined * np.cos(lean)) * 0.1**2
    assert moved[0] - moved[1] == pytest.approx(sliding, rel=0.3)


def test_stiffness_is_how_deep_the_object_stands(grasp_station):
    """Four rods carry it: each goes m g / 4 k deep, k being that of rod and table in series."""
    depth = {}
    for stiffness in (500.0, 1000.0):
        simulator = begun(grasp_station, Draw(stiffness=stiffness))
        simulator.AdvanceTo(0.5)
        depth[stiffness] = -corners(grasp_station, simulator)[:, 2].min()
    assert depth[500.0] == pytest.approx(0.04 * 9.81 / 4 / 500, rel=0.1)
    assert depth[500.0] == pytest.approx(2 * depth[1000.0], rel=0.1)


def test_sensors_err_by_the_seed(grasp_station):
    signals = [begun(grasp_station, Draw(sensor_seed=seed)).get_context() for seed in (1, 1, 2)]
    port = grasp_station.diagram.GetOutputPort("observation")
    first, again, other = (port.Eval(context) for context in signals)
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_fingers_differ_and_their_estimators_do_not_know(grasp_environment):
    config = replace(grasp_environment.config.variation, grippers=3, youngs_modulus=0.1)
    soft, plain, hard = (varied_fingers(grasp_environment.scenario, config, i) for i in range(3))
    gripper = {model.name: model for model in soft.models}["gripper"]
    assert gripper.fingers["all"]["youngs_modulus"] == "-10 %"
    assert float(soft.nominal.finger["youngs_modulus"].rstrip(" %")) == pytest.approx(100 / 0.9 - 100)
    assert hard.nominal.finger["youngs_modulus"].startswith("-")
    assert {model.name: model for model in plain.models}["gripper"].fingers["all"]["youngs_modulus"] == "+0 %"


SHAPES = (Sphere(0.1), Box(0.1, 0.2, 0.3), Capsule(0.1, 0.3), Cylinder(0.1, 0.3), Ellipsoid(0.1, 0.2, 0.3))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_volumes_go_with_the_third_power_of_lengths(shape):
    scaled = scaled_shape(shape, 1.2)
    assert type(scaled) is type(shape)
    assert CalcVolume(scaled) == pytest.approx(1.2**3 * CalcVolume(shape))


def test_shapes_without_lengths_are_refused():
    with refused("size", "HalfSpace"):
        scaled_shape(HalfSpace(), 1.2)


def solid_box(mass, size):
    """A box off its frame, all of whose lengths are multiplied."""
    center = size * np.array([0.01, -0.02, 0.03])
    about_center = UnitInertia.SolidBox(*(size * np.array([0.1, 0.2, 0.3])))
    return SpatialInertia(mass, center, about_center.ShiftFromCenterOfMass(center))


@pytest.mark.parametrize(("mass", "expected"), [(0.7, 0.7), (None, 0.4)])
def test_the_inertia_of_a_scaled_box_is_that_of_a_box_of_that_size(mass, expected):
    plant = MultibodyPlant(0.01)
    body = plant.AddRigidBody("box", solid_box(0.4, 1.0))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    set_mass(context, body, mass, 1.3)
    found = body.CalcSpatialInertiaInBodyFrame(context).CopyToFullMatrix6()
    np.testing.assert_allclose(found, solid_box(expected, 1.3).CopyToFullMatrix6(), atol=1e-12)

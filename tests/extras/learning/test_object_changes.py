"""An object of another size: by its shapes' volumes, and what of it is changed."""

import numpy as np
import pytest
from pydrake.geometry import Box, CalcVolume, Capsule, Cylinder, Ellipsoid, HalfSpace, Role, Sphere
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from refusals import refused

from soft_gripper.extras.learning.episode_variation import scale_geometries, scaled_shape, set_mass

SHAPES = (Sphere(0.1), Box(0.1, 0.2, 0.3), Capsule(0.1, 0.3), Cylinder(0.1, 0.3), Ellipsoid(0.1, 0.2, 0.3))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_volumes_go_with_the_third_power_of_lengths(shape):
    scaled = scaled_shape(shape, 1.2)
    assert type(scaled) is type(shape)
    assert CalcVolume(scaled) == pytest.approx(1.2**3 * CalcVolume(shape))


def test_shapes_without_lengths_are_refused():
    with refused("size", "HalfSpace"):
        scaled_shape(HalfSpace(), 1.2)


@pytest.mark.parametrize("seen", [False, True])
def test_what_is_seen_is_scaled_where_somebody_looks(grasp_station, seen):
    parts, body = grasp_station.parts, grasp_station.object
    root = grasp_station.diagram.CreateDefaultContext()
    context = parts.scene_graph.GetMyMutableContextFromRoot(root)
    scale_geometries(parts.scene_graph, context, parts.plant, body, 1.2, seen)
    before = parts.scene_graph.model_inspector()
    after = parts.scene_graph.get_query_output_port().Eval(context).inspector()
    frame = parts.plant.GetBodyFrameIdOrThrow(body.index())
    for role, factor in ((Role.kProximity, 1.2), (Role.kPerception, 1.2 if seen else 1.0)):
        shapes = before.GetGeometries(frame, role)
        assert shapes
        for shape in shapes:
            volumes = [CalcVolume(inspector.GetShape(shape)) for inspector in (before, after)]
            assert volumes[1] == pytest.approx(factor**3 * volumes[0])


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

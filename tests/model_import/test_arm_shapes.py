"""Shapes of URDF files as they are found: each is rendered and touched with the size and colour of the source."""

import numpy as np
import pytest
from arm_urdfs import GREEN, RED, SIZE, arm_urdf, box, link, load, shape, write_urdf
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.geometry import ClippingRange, ColorRenderCamera, Convex, Mesh, RenderCameraCore, Role
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.sensors import CameraInfo


def extents(loaded, geometry):
    """Size along x, y, z of a geometry, m, as Drake sees it."""
    bounds = loaded.query().ComputeObbInWorld(geometry)
    return np.abs(bounds.pose().rotation().matrix()) @ (2 * bounds.half_width())


@pytest.mark.parametrize("kind", ["visual", "collision"])
@pytest.mark.parametrize("mesh", ["box.stl", "box.dae", "box.obj", "file", "package"])
@pytest.mark.parametrize("scale", ["", "1 -0.5 2"])
def test_meshes_are_found_and_have_the_size_of_the_source_times_the_scale(tmp_path, kind, mesh, scale):
    names = {"file": f"file://{box(tmp_path / 'a.stl')}", "package": "package://acme/meshes/b.stl"}
    box(tmp_path / "acme" / "meshes" / "b.stl")
    if mesh not in names:
        box(tmp_path / mesh)
    attributes = f"filename='{names.get(mesh, mesh)}' " + (scale and f"scale='{scale}'")
    loaded = load(write_urdf(tmp_path, link("base", shape(kind, attributes))))
    ((found, geometry),) = loaded.geometries(Role.kIllustration if kind == "visual" else Role.kProximity)
    factor = np.abs([float(x) for x in (scale or "1 1 1").split()])
    np.testing.assert_allclose(extents(loaded, geometry), SIZE * factor, atol=1e-6)
    assert type(found) is (Mesh if kind == "visual" else Convex)


def test_what_drake_reads_and_what_lies_in_packages_it_knows_stays_where_it_is(tmp_path):
    known = "package://soft_gripper/objects/irregular.obj"
    own = box(tmp_path / "box.obj")
    text = arm_urdf(
        write_urdf(
            tmp_path, link("base", shape("visual", f"filename='{known}'") + shape("visual", "filename='box.obj'"))
        )
    )
    assert f'"{known}"' in text
    assert f'"file://{own}"' in text
    assert not (tmp_path / "cache").exists()


def test_a_shape_that_is_made_for_drake_keeps_its_true_surface(tmp_path):
    box(tmp_path / "box.stl")
    rigid = "<drake:proximity_properties xmlns:drake='http://drake.mit.edu'><drake:rigid_hydroelastic/>"
    path = write_urdf(
        tmp_path, link("base", shape("collision", "filename='box.stl'", f"{rigid}</drake:proximity_properties>"))
    )
    ((found, _),) = load(path).geometries(Role.kProximity)
    assert type(found) is Mesh


def color_at_the_middle(loaded):
    """Red, green, blue of what a camera sees that looks from x = 1 m to the origin."""
    core = RenderCameraCore("vtk", CameraInfo(16, 16, 0.3), ClippingRange(0.01, 10.0), RigidTransform())
    X_WC = RigidTransform(RotationMatrix(AngleAxis(-np.pi / 2, [0, 1, 0])), [1.0, 0.0, 0.0])
    world = loaded.scene_graph.world_frame_id()
    image = loaded.query().RenderColorImage(ColorRenderCamera(core), world, X_WC).data
    return image[8, 8, :3] / 255.0


@pytest.mark.parametrize(
    ("mesh", "color", "material", "expected"),
    [
        ("box.dae", RED, "", [1, 0, 0]),
        ("box.dae", RED, GREEN, [1, 0, 0]),  # as in ROS, a mesh's own colours come first
        ("box.stl", None, GREEN, [0, 1, 0]),
        ("box.stl", None, "<material name='blue'/>", [0, 0, 1]),
        ("box.stl", None, "<material name='nosuch'/>", [1, 0.5, 0.11]),  # the renderer's own
    ],
)
def test_colours(tmp_path, mesh, color, material, expected):
    box(tmp_path / mesh, color)
    blue = "<material name='blue'><color rgba='0 0 0.8 1'/></material>"
    visual = shape("visual", f"filename='{mesh}'", material)
    seen = color_at_the_middle(load(write_urdf(tmp_path, blue + link("base", visual)), render=True))
    np.testing.assert_allclose(seen / seen.max(), expected, atol=0.1)


def test_a_material_may_be_defined_again(tmp_path):
    ball = (
        "<visual><geometry><sphere radius='0.1'/></geometry><material name='m'><color rgba='{}'/></material></visual>"
    )
    twice = "".join(f"<material name='m'><color rgba='{blue} 0 1 1'/></material>" for blue in (0, 1))
    loaded = load(write_urdf(tmp_path, twice + link("base", ball.format("1 0 0 1") + ball.format("0 1 0 1"))))
    inspector = loaded.scene_graph.model_inspector()
    properties = [inspector.GetIllustrationProperties(i) for _, i in loaded.geometries(Role.kIllustration)]
    colors = [p.GetProperty("phong", "diffuse").rgba[:3].tolist() for p in properties]
    assert sorted(colors) == [[0, 1, 0], [1, 0, 0]]

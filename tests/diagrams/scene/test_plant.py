"""The plant: models where a scenario has them, and nothing inside of anything."""

import numpy as np
import pytest
from refusals import refused
from scenario_plants import scenario_of

from soft_gripper.diagrams.simulation import make_simulator
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

FINGER = "package://soft_gripper/grippers/finger.urdf"
GRIPPER = "package://soft_gripper/grippers/two_finger.urdf"
PEG = "package://soft_gripper/objects/peg.sdf"
BOX = "package://soft_gripper/objects/box.sdf"


def station(tmp_path, *models):
    return make_station(scenario_of(tmp_path, *models))


def test_segments_of_the_scenario_take_the_place_of_the_files(tmp_path):
    beside = "X_PC: {translation: [0, 1, 0]}"
    built = station(tmp_path, f"name: a, file: '{FINGER}', segments: 5", f"name: b, file: '{FINGER}', {beside}")
    assert [finger.finger.segments for finger in built.fingers] == [5, 12]
    assert built.plant.num_positions() == 17


def test_a_model_is_welded_to_a_frame_of_another(tmp_path):
    built = station(
        tmp_path,
        f"name: a, file: '{FINGER}', X_PC: {{translation: [0, 0, 1]}}",
        f"name: b, file: '{FINGER}', parent: 'a::mount', child: b_tip, X_PC: {{translation: [0.1, 0, 0]}}",
    )
    _, b = built.fingers
    np.testing.assert_allclose(b.X_WB.translation(), [0.1, 0, 1 - 0.12], atol=1e-12)


def test_a_free_model_begins_where_it_is_put(tmp_path):
    built = station(tmp_path, f"name: box, file: '{BOX}', free: true, X_PC: {{translation: [1, 2, 3]}}")
    box = built.plant.GetBodyByName("box")
    pose = built.plant.EvalBodyPoseInWorld(built.plant.CreateDefaultContext(), box)
    np.testing.assert_array_equal(pose.translation(), [1, 2, 3])
    assert built.plant.num_velocities() == 6


@pytest.mark.parametrize(
    ("model", "field", "value"),
    [
        (f"file: '{FINGER}', parent: 'b::mount'", "parent", "b::mount"),
        (f"file: '{FINGER}', child: palm", "child", "a::palm"),
        ("file: package://soft_griper/a.urdf", "file", "package://soft_griper/a.urdf"),
        ("file: none.urdf", "file", "{here}/none.urdf"),
        ("file: broken.sdf", "file", "broken.sdf"),
    ],
)
def test_models_that_cannot_be_added(tmp_path, model, field, value):
    (tmp_path / "broken.sdf").write_text("<sdf version='1.7'><model>")
    with refused(field, value.format(here=tmp_path)):
        station(tmp_path, f"name: a, {model}")


def test_a_model_with_fingers_is_welded(tmp_path):
    """The sensing knows where a finger's base stands; a free base would move away from there."""
    with refused("free", True):
        station(tmp_path, f"name: a, file: '{FINGER}', free: true")


TABLE = "package://soft_gripper/objects/table.sdf"


def resting_box(tmp_path, table, points=False):
    """Height of a box, m, that was put on a table, and the number of faces on which it rests."""
    box = f"name: box, file: '{BOX}', free: true, X_PC: {{translation: [0.013, 0.007, 0.13001]}}"
    finger = f"name: finger, file: '{FINGER}', X_PC: {{translation: [0, 1, 0.2]}}"
    path = tmp_path / "resting.yaml"
    contact = "contact: points\n" if points else ""
    path.write_text(f"{contact}models:\n- {{{table}}}\n- {{{box}}}\n- {{{finger}}}\n")
    built = make_station(load_scenario(str(path)))
    simulator = make_simulator(built)
    simulator.AdvanceTo(0.5)
    context = built.plant.GetMyContextFromRoot(simulator.get_context())
    results = built.plant.get_contact_results_output_port().Eval(context)
    faces = [results.hydroelastic_contact_info(i) for i in range(results.num_hydroelastic_contacts())]
    pose = built.plant.GetBodyByName("box").EvalPoseInWorld(context)
    return pose.translation()[2], sum(info.contact_surface().num_faces() for info in faces)


@pytest.mark.parametrize("points", [False, True])
@pytest.mark.parametrize(("child", "height"), [("", 0.08), ("child: surface, ", 0.1)])
def test_a_box_rests_on_a_half_space_as_on_the_table_that_it_replaces(tmp_path, child, height, points):
    table = f"name: table, file: '{TABLE}', {child}X_PC: {{translation: [0, 0, {height}]}}"
    on_table, of_table = resting_box(tmp_path, table, points)
    on_half_space, of_half_space = resting_box(tmp_path, f"{table}, half_space: true", points)
    assert on_table == pytest.approx(0.13, abs=1e-4)
    assert on_half_space == pytest.approx(on_table, abs=1e-7)
    assert of_half_space < of_table


@pytest.mark.parametrize(
    "model",
    [
        f"name: peg, file: '{PEG}'",
        f"name: hand, file: '{GRIPPER}'",
        f"name: table, file: '{TABLE}', parent: 'finger::mount'",
    ],
)
def test_only_a_welded_box_is_a_half_space(tmp_path, model):
    finger = f"name: finger, file: '{FINGER}', X_PC: {{translation: [0, 1, 0.2]}}"
    with refused("half_space", True):
        station(tmp_path, finger, f"{model}, half_space: true")


ANOTHER_BOX = "{name: other, file: package://soft_gripper/objects/box.sdf, free: true}"


def at(model, x, y, z):
    return f"models.{model}.X_PC.translation=[{x}, {y}, {z}]"


# Scenario, what is moved (m), and the models that are then in each other. Half the box is 22 x 20 x 30 mm. The fingers
# of its scenario reach from x = 35 mm outward and from z = 147 mm down, the palm from there up, the table from 0 down.
# The peg has a radius of 10 mm, and stands beside a finger that reaches from x = -35 mm outward.
INSIDE = {
    "object in a finger": ("box_grasp", [at(2, -0.03, 0, 0.09)], {"gripper::left_finger", "box::box"}),
    "object in the palm": ("box_grasp", [at(2, 0, 0, 0.13)], {"gripper::palm", "box::box"}),
    "mesh in a finger": ("irregular_grasp", [at(2, 0.03, 0, 0.09)], {"gripper::right_finger", "irregular::irregular"}),
    "finger in a finger": ("free_bending", [at(1, -0.13, 0, 0.2)], {"left_finger::", "right_finger::"}),
    "object in an object": ("box_grasp", [f"models.1={ANOTHER_BOX}", at(1, 0, 0, 0.05)], {"other::box", "box::box"}),
}


@pytest.mark.parametrize(("name", "overrides", "models"), INSIDE.values(), ids=INSIDE)
def test_a_start_inside_is_refused(name, overrides, models):
    with refused("X_PC") as caught:
        make_station(load_scenario(name, overrides))
    assert all(model in str(caught.value) for model in models)

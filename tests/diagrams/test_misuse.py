"""Calls in a diagram of one's own that cannot work are refused in a line, before anything is built from them."""

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from refusals import refused

import soft_gripper as sg

TWO = "package://soft_gripper/grippers/two_finger.urdf"


class Scene:
    """A builder, and two fingers in a plant."""

    def __init__(self, is_finalized=True):
        self.builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(self.builder, 0.005)
        self.fingers = sg.add_fingers(Parser(self.plant), TWO, "hand")
        if is_finalized:
            self.plant.Finalize()


class Named(LeafSystem):
    """A sensor or estimator that puts out more than it should, under a name that is taken."""

    def __init__(self, layout, needed, size, taken):
        super().__init__()
        for name, entries in ((needed, size), (taken, 1)):
            self.DeclareVectorOutputPort(name, entries, lambda context, output: None, {self.nothing_ticket()})


def test_blocks_wait_for_the_plant_to_be_finalized():
    scene = Scene(is_finalized=False)
    for add in (lambda: sg.add_pressure_drive(scene.builder, scene.fingers), lambda: sense(scene, {})):
        with refused("plant", "left_finger"):
            add()


def sense(scene, pressures):
    return sg.add_sensing(scene.builder, scene.fingers, pressures)


def test_a_pressure_is_missing():
    with refused("pressures", []):
        sense(Scene(), {})


def test_a_model_has_one_drive():
    scene = Scene()
    sg.add_pressure_drive(scene.builder, scene.fingers)
    with refused("model", "hand"):
        sg.add_pressure_drive(scene.builder, scene.fingers)


@pytest.mark.parametrize("name", ["", "hand"])  # of nothing, and of another model
def test_names_of_models(name):
    scene = Scene(is_finalized=False)
    with refused("name", name):
        sg.add_fingers(Parser(scene.plant), TWO, name)


def test_fingers_are_read_before_the_plant_is_finalized():
    with refused("plant", "finalized"):
        sg.add_fingers(Parser(Scene().plant), TWO, "other")


@pytest.mark.parametrize("taken", ["joint_angles", "pressure", "sampled_pressure", "X_WB", "pose_error"])
def test_a_sensor_takes_no_name_of_another_signal(taken):
    with refused("output ports", taken):
        sg.make_station(
            sg.load_scenario("obstructed_inside"),
            make_sensor=lambda layout, period: Named(layout, "strain", layout.readings, taken),
        )


@pytest.mark.parametrize("taken", ["torque_tolerance", "contact", "strain", "pose_error"])
def test_an_estimator_takes_no_name_of_another_signal(taken):
    def make(layout, gravity, period):
        return Named(layout, "estimated_joint_angles", layout.finger.segments, taken)

    with refused("output ports", taken):
        sg.make_station(sg.load_scenario("obstructed_inside"), make_estimator=make)


@pytest.mark.parametrize("port", ["tip_pose", "external_torque"])
def test_what_an_estimator_knows_better_has_the_size_of_the_contract(port):
    def make(layout, gravity, period):
        return Named(layout, "estimated_joint_angles", layout.finger.segments, port)

    with pytest.raises(sg.InputError) as error:
        sg.make_station(sg.load_scenario("obstructed_inside"), make_estimator=make)
    assert (error.value.field, error.value.value) == (f"output port '{port}'", 1)


def test_a_scenario_of_python_is_checked_too():
    with refused("external[0]", "presure"):
        sg.make_station(sg.Scenario(models=[sg.ModelConfig(name="hand", file=TWO)], external=["presure"]))


def test_a_recording_names_the_users_own_blocks():
    def make(layout, gravity, period):
        return sg.estimators.ShapeEstimator(sg.estimators.ArcShape(layout), layout, gravity)

    station = sg.make_station(sg.load_scenario("obstructed_inside"), make_estimator=make)
    assert station.parts.attributes["sensor"] == "strain"
    assert station.parts.attributes["estimator"].endswith(f"{make.__qualname__}")


@pytest.mark.parametrize("plants", ["another station", "a plant"])
def test_a_diagram_holds_one_station(plants):
    """Drake would end the process when the diagram is built."""
    builder, scenario = DiagramBuilder(), sg.load_scenario("free_bending")
    if plants == "a plant":
        AddMultibodyPlantSceneGraph(builder, 0.005)
    else:
        sg.add_station(builder, scenario)
    with pytest.raises(sg.InputError) as error:
        sg.add_station(builder, scenario)
    assert (error.value.field, error.value.value) == ("builder", "plant")

"""Two equal grippers in a plant of your own: drive, sensing and logs."""

from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

import soft_gripper as sg

builder = DiagramBuilder()
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.005)
fingers = []
for hand, x in (("left_hand", -0.2), ("right_hand", 0.2)):
    fingers += sg.add_fingers(
        Parser(plant),
        "package://soft_gripper/grippers/two_finger.urdf",
        hand,
    )
    palm = plant.GetFrameByName("palm", plant.GetModelInstanceByName(hand))
    plant.WeldFrames(
        plant.world_frame(), palm, RigidTransform([x, 0.0, 0.2])
    )
plant.Finalize()

drive = sg.add_pressure_drive(builder, fingers)
signals = sg.add_sensing(builder, fingers, drive.pressures)
for finger, command in drive.commands.items():
    pressure = 50e3 if finger.startswith("left_hand") else 25e3  # Pa
    source = builder.AddSystem(ConstantVectorSource([pressure]))
    builder.Connect(source.get_output_port(), command)
logs = sg.add_logs(builder, signals, period=0.01)

simulator = Simulator(builder.Build())
simulator.AdvanceTo(1.0)
recording = sg.read_logs(logs, simulator.get_context())
figure = recording.plot(
    "left_hand.left_finger.theta",
    "right_hand.left_finger.theta",
    "left_hand.left_finger.pose_error",
)

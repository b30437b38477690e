"""A finished station in another diagram, a port logged as Drake does."""

from matplotlib.figure import Figure
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

import soft_gripper as sg

station = sg.make_station(sg.load_scenario("box_grasp"))
builder = DiagramBuilder()
builder.AddSystem(station.diagram)
# (12) N m
torque = station.diagram.GetOutputPort("left_finger.external_torque")
logger = LogVectorOutput(torque, builder, publish_period=0.01)
diagram = builder.Build()

simulator = Simulator(diagram)
simulator.AdvanceTo(12.0)
now = torque.Eval(
    diagram.GetSubsystemContext(station.diagram, simulator.get_context())
)
log = logger.FindLog(simulator.get_context())

figure = Figure()
axes = figure.subplots()
axes.plot(log.sample_times(), 1e3 * log.data().T)
axes.set(
    xlabel="time [s]",
    ylabel="external torque [mN m]",
    title=f"{1e3 * now[0]:.1f} mN m at the base",
)

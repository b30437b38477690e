"""A station whose pressures come from outside, stepped at 20 Hz.

Here a law closes until both fingers touch.
"""

import soft_gripper as sg

TOUCH = 0.02  # N m, torque at the base that opens a finger
STEP = 0.05  # s

overrides = ["external=[pressure]", "estimator.contact_threshold=2.5e-3"]
station = sg.make_station(sg.load_scenario("box_grasp", overrides))
simulator = sg.make_simulator(station)
context = simulator.get_mutable_context()
commands = {
    finger.name: station.diagram.GetInputPort(
        f"{finger.name}.pressure_command"
    )
    for finger in station.fingers
}
pressure = dict.fromkeys(commands, 0.0)
for command in commands.values():
    command.FixValue(context, [0.0])
simulator.Initialize()

for step in range(60):
    for finger, command in commands.items():
        torque = station.diagram.GetOutputPort(
            f"{finger}.external_torque"
        ).Eval(context)[0]
        # Pa; before the first estimate the torque is NaN
        pressure[finger] += 2e3 if not -torque > TOUCH else 0.0
        command.FixValue(context, [pressure[finger]])
    simulator.AdvanceTo((step + 1) * STEP)

recording = station.recording(simulator.get_context())
figure = recording.plot(
    "left_finger.pressure",
    "left_finger.external_torque",
    "left_finger.contact",
    "box.pose",
)

"""A sensor of your own with three additional outputs, which are logged."""

import numpy as np
from pydrake.systems.framework import LeafSystem

import soft_gripper as sg


class WarmSensor(LeafSystem):
    """Reads the strain, drifts as it warms up, reports its condition."""

    def __init__(self, layout, period):
        super().__init__()
        self.layout = layout
        joints = layout.finger.segments
        self.angles = self.DeclareVectorInputPort("joint_angles", joints)
        places = {
            "path": layout.path_names,
            "section": range(layout.sections),
        }
        outputs = {
            "strain": ("1", layout.readings, places),
            "temperature": ("degC", 1, {}),
            "drift": ("1", 1, {}),
            "saturated": ("1", layout.readings, places),
        }
        for name, (unit, size, axes) in outputs.items():
            state = self.DeclareDiscreteState(size)
            port = self.DeclareStateOutputPort(name, state)
            sg.describe(port, unit, **axes)
        self.DeclareInitializationDiscreteUpdateEvent(self.sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self.sample)

    def sample(self, context, values):
        q = self.angles.Eval(context)
        strain = sg.sensors.extension_ratios(self.layout, q) - 1
        temperature = 20 + 15 * (1 - np.exp(-context.get_time() / 10))
        drift = 2e-4 * (temperature - 20)
        read = np.clip(strain + drift, -0.1, 0.1)
        saturated = abs(strain) > 0.1
        for i, value in enumerate(
            (read, [temperature], [drift], saturated)
        ):
            values.set_value(i, value)


if __name__ == "__main__":
    changes = ["pressure.hold_samples=10"]
    scenario = sg.load_scenario("obstructed_inside", changes)
    station = sg.make_station(scenario, make_sensor=WarmSensor)
    recording = sg.run_station(station)
    signals = ("temperature", "drift", "saturated", "pose_error")
    figure = recording.plot(
        *(f"left_finger.{signal}" for signal in signals)
    )

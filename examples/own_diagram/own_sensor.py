"""A sensor of your own with three additional outputs, each of which gets a log."""

import numpy as np
from pydrake.systems.framework import LeafSystem

import soft_gripper as sg


class WarmSensor(LeafSystem):
    """Reads the strain, drifts as it warms up, and reports temperature, drift and whether it is saturated."""

    def __init__(self, layout, period):
        super().__init__()
        self.layout = layout
        self.angles = self.DeclareVectorInputPort("joint_angles", layout.finger.segments)
        sizes = {"strain": layout.readings, "temperature": 1, "drift": 1, "saturated": layout.readings}
        states = {name: self.DeclareDiscreteState(size) for name, size in sizes.items()}
        ports = {name: self.DeclareStateOutputPort(name, state) for name, state in states.items()}
        places = {"path": layout.path_names, "section": range(layout.sections)}
        sg.describe(ports["strain"], "1", **places)
        sg.describe(ports["temperature"], "degC")
        sg.describe(ports["drift"], "1")
        sg.describe(ports["saturated"], "1", **places)
        self.DeclareInitializationDiscreteUpdateEvent(self.sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self.sample)

    def sample(self, context, values):
        strain = sg.sensors.extension_ratios(self.layout, self.angles.Eval(context)) - 1
        temperature = 20 + 15 * (1 - np.exp(-context.get_time() / 10))
        drift = 2e-4 * (temperature - 20)
        for i, value in enumerate((np.clip(strain + drift, -0.1, 0.1), [temperature], [drift], np.abs(strain) > 0.1)):
            values.set_value(i, value)


if __name__ == "__main__":
    scenario = sg.load_scenario("obstructed_inside", ["pressure.hold_samples=10"])
    recording = sg.run_station(sg.make_station(scenario, make_sensor=WarmSensor))
    signals = ("temperature", "drift", "saturated", "pose_error")
    figure = recording.plot(*(f"left_finger.{signal}" for signal in signals))

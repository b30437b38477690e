"""The ports of a station as a Drake user reads them: logged by LogVectorOutput around a station that is finished."""

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from soft_gripper.diagrams.simulation import seed_random_sources, solver_config
from soft_gripper.diagrams.station import make_station
from soft_gripper.estimators.finger_shape import ARC


class LoggedStation:
    """A station with a log for each of the signals that a function chooses from all names."""

    def __init__(self, scenario, choose=list):
        self.station, builder = make_station(scenario), DiagramBuilder()
        builder.AddSystem(self.station.diagram)
        ports = {name: self.station.diagram.GetOutputPort(name) for name in choose(self.station.parts.signals)}
        self._logs = {name: LogVectorOutput(port, builder, scenario.sensor.period) for name, port in ports.items()}
        self._diagram = builder.Build()

    def simulator(self, begin=0.0):
        """A simulator that has not been initialized, at a time, s."""
        simulator, scenario = Simulator(self._diagram), self.station.scenario
        ApplySimulatorConfig(solver_config(scenario), simulator)
        seed_random_sources(self.station.diagram, simulator.get_mutable_context(), scenario.sensor.seed)
        simulator.get_mutable_context().SetTime(begin)
        return simulator

    def read(self, simulator):
        """All signals now."""
        diagram = self.station.diagram
        context = diagram.GetMyContextFromRoot(simulator.get_context())
        return {name: diagram.GetOutputPort(name).Eval(context) for name in self.station.parts.signals}

    def logged(self, simulator):
        """What has been logged, (T, size) each."""
        return {name: log.FindLog(simulator.get_context()).data().T for name, log in self._logs.items()}

    def recorded(self, simulator):
        """The same signals as they are recorded, and all others."""
        recording = self.station.recording(simulator.get_context())
        return {name: values.values.reshape(len(values), -1) for name, values in recording.data.items()}


def logged_ports(scenario, duration, signals=None):
    """Signals of a station, or all, (T, size) each, by logs of their ports."""
    station = LoggedStation(scenario, lambda names: signals or names)
    simulator = station.simulator()
    simulator.AdvanceTo(duration)
    return station.logged(simulator)


ERROR_TERMS = 0.1  # m, N m: size of the positions, widths and torques whose differences are errors


def assert_same(found, expected, share=1e-12):
    """Compares signals to rounding: a share of the size of a signal, which the fit of a contact to bends multiplies.

    An error is as exact as the estimate and the truth from which it is computed, however small it is: processors
    round these differently.
    """
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        expected_values, found_values = well_conditioned(name, values), well_conditioned(name, found[name])
        # A misfit is a difference of sums of squares, and judged against 1.
        least = ERROR_TERMS if name.endswith("_error") else 1.0 if name.endswith("misfit") else 0.0
        scale = np.abs(expected_values[np.isfinite(expected_values)]).max(initial=least)
        fits_contact = ".contact." in name or ".recursive." in name
        # Covariances are small differences of large ones.
        times = 100 if name.endswith("position_std") else 10 if fits_contact else 1
        atol = share * times * scale
        np.testing.assert_allclose(found_values, expected_values, rtol=0, atol=atol, err_msg=name)


def well_conditioned(name, values):
    """Values of a signal; of arcs without the centres, which go to infinity as an arc becomes straight."""
    return values.reshape(len(values), -1, len(ARC))[..., :-2] if name.endswith(".arcs") else values

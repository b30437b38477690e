"""Steps a network through a run, sample by sample, and records its logged signals."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.own_blocks import blamed_by_traceback
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import SimulationDivergedError
from soft_gripper.extras.mujoco_engine.network import Network, Plants


class Logs:
    """Recorded samples of E environments."""

    def __init__(self, station: Station, network: Network, samples: int):
        self.samples, self._station, self._network = samples, station, network
        self._vectors: dict[int, Array] = {}  # by number of the input of the logs
        self.states = np.empty((samples, network.count, network.plants.state.shape[1]))
        self.phases = np.full((samples, network.count), -1)  # of tasks; -1 after they are over
        self.patches: list[tuple[Array, NDArray[np.int_]]] = []

    def take(self, sample: int) -> None:
        """Takes a sample."""
        stride = self._station.scenario.record.patches_every
        self.states[sample] = self._network.plants.state
        phases = self._network.phases
        if phases is not None:
            self.phases[sample] = phases
        is_due = stride is not None and sample % stride == 0
        self.patches.append(self._network.plants.patches() if is_due else _NO_PATCHES)
        for i, value in self._network.logged():
            if i not in self._vectors:
                self._vectors[i] = np.empty((self.samples, self._network.count, value.shape[1]))
            self._vectors[i][sample] = value

    def samples_of(self, environment: int, samples: int) -> dict[int, Any]:
        """Samples of one environment, up to a number of samples, by the number of the logged port.

        Logs of diagrams of one structure have the same numbers.
        """
        port_numbers = self._station.logs.port_numbers
        port_samples: dict[int, Any] = {
            port_numbers[i]: np.ascontiguousarray(value[:samples, environment]) for i, value in self._vectors.items()
        }
        for number in (number for i, number in enumerate(port_numbers) if i not in self._vectors):
            port_samples[number] = [rows_of(*patches, environment) for patches in self.patches[:samples]]
        return port_samples


_NO_PATCHES = np.empty((0, 0)), np.zeros(0, int)


def rows_of(table: Array, begins: NDArray[np.int_], environment: int) -> Array:
    """The patches of one environment at a sample, see `Plants.patches`."""
    return table[begins[environment] : begins[environment + 1]] if len(begins) else table


def simulate_network(
    station: Station, network: Network
) -> tuple[Logs, NDArray[np.int_], dict[int, SimulationDivergedError]]:
    """Simulates a network of stations; `station` is the first.

    Returns the logs, the number of samples of each run, and the errors of those that diverged. Values that follow from
    a state are known once MuJoCo has stepped from it, so samples are taken after the first step.

    Raises:
        InputError: if a user's block fails in any run.
    """
    plants = network.plants
    period, plant_step = station.scenario.sensor.period, station.plant.time_step()
    samples = round(station.scenario.duration / period) + 1
    logs, lengths = Logs(station, network, samples), np.zeros(network.count, int)
    failed: dict[int, SimulationDivergedError] = {}
    time = 0.0
    try:
        network.begin()
        for sample in range(samples):
            time = sample * period
            network.drive_plants(time)
            _drop_diverged(station, plants, time, failed)
            plants.begin_step()
            logs.take(sample)
            lengths[plants.active] = sample + 1
            plants.active = plants.active[~network.is_over[plants.active]]
            if not len(plants.active):
                break
            network.sample()
            plants.finish_step()
            network.step([time + i * plant_step for i in range(1, round(period / plant_step))])
    except (Exception, SystemExit) as failure:
        raise blamed_by_traceback(station, time, failure) or failure from failure
    return logs, lengths, failed


def _drop_diverged(station: Station, plants: Plants, time: float, failed: dict[int, SimulationDivergedError]) -> None:
    """Ends runs whose state is not finite, with an error each."""
    has_diverged = ~np.isfinite(plants.state).all(axis=1)
    for i in plants.active[has_diverged[plants.active]]:
        name = station.plant.GetStateNames()[int(np.argmin(np.isfinite(plants.state[i])))]
        words = f"the simulation in MuJoCo diverged before t = {time:.4g} s in state {name}"
        failed[int(i)] = SimulationDivergedError(words)
    plants.active = plants.active[~has_diverged[plants.active]]

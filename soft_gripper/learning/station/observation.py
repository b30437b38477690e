"""Observation: signals of the estimation -> what an agent observes.

Only estimates are observed: `OBSERVABLE` lists what an agent may know, so that a file cannot request the truth.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem, OutputPort

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.learning.schema.config import ObservedConfig

LARGEST = 10.0  # that is observed
# What is measured, estimated or commanded; all else is known in simulation only.
OBSERVABLE = (
    *("strain", "extension_ratio", "sampled_pressure", "theta", "kappa", "arcs", "estimated_joint_angles"),
    *("joint_positions", "tip_pose", "free_bending_angles", "driving_torque", "external_torque", "position_std"),
    *("contact", "contact_force", "contact_arc_length", "contact_force_std", "pressure_command", "desired_state"),
    *("opening", "torque", "force", "object_width", "set_point", "target", "goal"),
)


def scaled(values: Array, scales: Array) -> Array:
    """Values by their scales, (..., n), within what is observed; what is not known is 0."""
    known = np.nan_to_num(values / scales, nan=0.0, posinf=LARGEST, neginf=-LARGEST)
    observed: Array = np.clip(known, -LARGEST, LARGEST)
    return observed


class Observation(LeafSystem):
    """Puts chosen entries of signals into one vector, each by its scale.

    ::

        {signal} ---> +-------------+ ---> observation (n) 1
                      | Observation |
                      +-------------+
    """

    def __init__(self, observed: Sequence[ObservedConfig], sizes: Mapping[str, int]):
        """`sizes` of the signals, by their names."""
        super().__init__()
        names = list(dict.fromkeys(each.signal for each in observed))
        starts = dict(zip(names, np.cumsum([0, *(sizes[name] for name in names)]), strict=False))
        entries = [each.entries or range(sizes[each.signal]) for each in observed]
        self._entries = np.concatenate([starts[each.signal] + k for each, k in zip(observed, entries, strict=True)])
        self._scales = np.repeat([each.scale for each in observed], [len(chosen) for chosen in entries])
        self._ports = [self.DeclareVectorInputPort(name, sizes[name]) for name in names]
        self.DeclareVectorOutputPort("observation", len(self._entries), self._calc)

    def _calc(self, context: Context, output: BasicVector) -> None:
        values = np.concatenate([port.Eval(context) for port in self._ports])[self._entries]
        output.SetFromVector(scaled(values, self._scales))


def add_observation(
    builder: DiagramBuilder, observed: Sequence[ObservedConfig], signals: Mapping[str, OutputPort]
) -> OutputPort:
    """Adds `observation`; returns its output.

    Raises:
        InputError: if a signal is not there, has no such entry, or is not to be known to an agent.
    """
    for i, each in enumerate(observed):
        where, name = f"observation[{i}]", each.signal
        if name.rpartition(".")[2] not in OBSERVABLE:
            raise InputError(where, "signal", name, f"is no estimate; an agent may know: {', '.join(OBSERVABLE)}")
        if name not in signals:
            raise InputError(where, "signal", name, f"is none; known: {', '.join(sorted(signals))}")
        size = signals[name].size()
        if not all(0 <= entry < size for entry in each.entries):
            raise InputError(where, "entries", each.entries, f"give some of 0 to {size - 1}")
    block = Observation(observed, {each.signal: signals[each.signal].size() for each in observed})
    builder.AddNamedSystem("observation", block)
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        builder.Connect(signals[port.get_name()], port)
    return block.get_output_port()

"""ControlPanel: the sliders and buttons of a station, shared by the threads that run it and serve its page."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.framework import Context

from soft_gripper.diagrams.arm import Arm
from soft_gripper.diagrams.station_parts import Station, StationParts
from soft_gripper.diagrams.wiring.grip_control import find_gripper
from soft_gripper.extras.page.panel import ALL_FINGERS, ALL_KEYS, NO_KEYS, Button, Keys, Panel, Slider
from soft_gripper.scenario.schema import PressureConfig, TendonConfig

FINGER_KEYS: tuple[Keys, ...] = (("KeyA", "KeyQ"), ("KeyS", "KeyW"), ("KeyD", "KeyE"), ("KeyF", "KeyR"))
TOOL_KEYS: tuple[Keys, ...] = (("KeyK", "KeyI"), ("KeyL", "KeyJ"), ("KeyU", "KeyO"), ("Comma", "Period"))
_PRESSURE_STEP = 2.0  # kPa
_OPENING_STEP = 1.0  # mm
_TENSION_STEP = 0.1  # N
_MAX_TENSION, _MAX_PULL = 20.0, 0.05  # N and m, where the scenario has no limit
_TOOL_STEP = 5.0  # mm
_YAW_STEP = 3.0  # degrees
_MAX_OPENING_RATIO = 1.6  # of the opening of straight fingers
_JOG_RANGE = 0.6  # of the tool about its start, as a fraction of its distance from the arm's base


@dataclass(frozen=True)
class SliderCommand:
    """An input port of a station, and the sliders that set it."""

    port: str
    sliders: tuple[Slider, ...]
    value: Callable[[Sequence[float]], Any]  # of the port, from the values of the sliders


def slider_commands(station: StationParts) -> list[SliderCommand]:
    """The commands of a station of an `open_scenario`, as the page orders them."""
    if "grip.set_point" in station.inputs:
        straight = find_gripper(station.fingers, "play").opening(
            np.array([[0.0, 0.0, finger.finger.length] for finger in station.fingers])
        )
        grip = [_opening_command(float(straight))]
    else:
        grip = [*_drive_commands(station)]
    return grip if station.arm is None else [*grip, _tool_command(station.arm)]


def _drive_commands(station: StationParts) -> Iterator[SliderCommand]:
    """The pressures of the chambers and the commands of the tendons of each finger; the first sliders have keys."""
    keys = chain(FINGER_KEYS, repeat(NO_KEYS))
    supply, tendons = station.scenario.pressure, station.scenario.tendons
    for finger in station.fingers:
        chambers = finger.finger.chamber_axis.get("chamber", [""])
        if finger.finger.pressures:
            names = [" ".join(filter(None, (finger.name, chamber, "[kPa]"))) for chamber in chambers]
            pressure_sliders = tuple(pressure_slider(name, supply, next(keys)) for name in names)
            yield SliderCommand(f"{finger.name}.pressure_command", pressure_sliders, partial(_scale, 1e3))
        tendon_sliders = tuple(
            _tendon_slider(f"{finger.name} {tendon.name}", tendons, next(keys)) for tendon in finger.finger.tendons
        )
        if tendon_sliders:
            scale = 1.0 if tendons.command == "tension" else 1e-3
            yield SliderCommand(f"{finger.name}.{tendons.command}_command", tendon_sliders, partial(_scale, scale))


def _scale(scale: float, values: Sequence[float]) -> list[float]:
    return [scale * value for value in values]


def _tendon_slider(name: str, config: TendonConfig, keys: Keys) -> Slider:
    """A slider over the tensions, or the lengths, that a winch commands."""
    if config.command == "tension":
        return Slider(f"{name} [N]", 0.0, config.maximum or _MAX_TENSION, _TENSION_STEP, 0.0, keys)
    return Slider(f"{name} [mm]", 0.0, 1e3 * (config.maximum or _MAX_PULL), _OPENING_STEP, 0.0, keys)


def pressure_slider(name: str, supply: PressureConfig, keys: Keys) -> Slider:
    """A slider over the pressures of the supply that begins at 0, or at the nearest pressure that the supply has."""
    min_kpa, max_kpa = supply.minimum / 1e3, supply.maximum / 1e3
    return Slider(name, min_kpa, max_kpa, _PRESSURE_STEP, min(max(0.0, min_kpa), max_kpa), keys)


def _opening_command(straight: float) -> SliderCommand:
    """Command of the opening; `straight` is the opening of straight fingers, m."""
    slider = Slider(
        "opening [mm]", 0.0, round(1e3 * _MAX_OPENING_RATIO * straight), _OPENING_STEP, 1e3 * straight, ALL_KEYS
    )
    return SliderCommand("grip.set_point", (slider,), lambda values: [values[0] / 1e3])


def _tool_command(arm: Arm) -> SliderCommand:
    """Command of x, y, z of the tool in the world, and of its rotation about the vertical from the start."""
    context = arm.plant.CreateDefaultContext()
    arm.plant.SetPositions(context, arm.home)
    X_WTool = arm.tool.CalcPoseInWorld(context)
    foot = arm.plant.get_body(arm.plant.GetBodyIndices(arm.plant.GetModelInstanceByName(arm.name))[0])
    start = X_WTool.translation()
    reach = _JOG_RANGE * float(np.linalg.norm(start - arm.plant.EvalBodyPoseInWorld(context, foot).translation()))
    sliders = []
    for axis, center, keys in zip("xyz", start, TOOL_KEYS, strict=False):
        low, high = (_TOOL_STEP * round(1e3 * end / _TOOL_STEP) for end in (center - reach, center + reach))
        sliders.append(Slider(f"tool {axis} [mm]", low, high, _TOOL_STEP, 1e3 * center, keys))
    yaw = Slider("tool yaw [deg]", -180.0, 180.0, _YAW_STEP, 0.0, TOOL_KEYS[3])
    return SliderCommand(f"{arm.name}.X_WTool", (*sliders, yaw), lambda values: tool_pose(values, X_WTool.rotation()))


def tool_pose(values: Sequence[float], R_WHome: RotationMatrix) -> RigidTransform:
    """The pose X_WTool of a tool at x, y, z (mm), turned about the vertical from R_WHome by yaw (degrees)."""
    *place, yaw = values
    R_WTool = RollPitchYaw(0.0, 0.0, np.radians(yaw)).ToRotationMatrix() @ R_WHome
    return RigidTransform(R_WTool, np.array(place) / 1e3)


_STATION_BUTTONS = (Button.PAUSE, Button.RESET, Button.RECORD, Button.STOP)


class ControlPanel(Panel):
    """Sliders and buttons that command a station.

    If several fingers have a pressure slider each, one more slider moves all of them.
    """

    def __init__(self, station: Station):
        """`station` is one of an `open_scenario`."""
        self._commands = slider_commands(station.parts)
        sliders_ = [slider for command in self._commands for slider in command.sliders]
        pressures = [c.sliders for c in self._commands if c.port.endswith(".pressure_command")]
        are_alike = len(pressures) > 1 and all(len(sliders) == 1 for sliders in pressures)
        common_names = [sliders[0].name for sliders in pressures] if are_alike else []
        common_sliders = [pressure_slider(ALL_FINGERS, station.scenario.pressure, ALL_KEYS)] if common_names else []
        super().__init__(_STATION_BUTTONS, common_sliders + sliders_, common_names)

    def apply(self, station: Station, context: Context) -> None:
        """Sets the inputs of a station, in its context, to the slider commands."""
        values = self.values
        for command in self._commands:
            value = command.value([values[slider.name] for slider in command.sliders])
            station.diagram.GetInputPort(command.port).FixValue(context, value)

"""ControlPanel: the sliders and buttons of a station in Meshcat, with their keys."""

from enum import StrEnum

from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from soft_gripper.diagrams.live.sliders import ALL_KEYS, Slider, commands_of, pressure_slider
from soft_gripper.diagrams.station_parts import Station

ALL_FINGERS = "all fingers [kPa]"


class Button(StrEnum):
    """What a button is called."""

    PAUSE = "pause / go on"
    RESET = "reset"
    RECORD = "record / keep"
    STOP = "stop"


BUTTON_KEYS = {Button.PAUSE: "KeyP", Button.RESET: "KeyX", Button.RECORD: "KeyC", Button.STOP: ""}


class ControlPanel:
    """The controls of a station, in every browser that shows its Meshcat.

    With the pressures of several fingers there is a slider that moves all of them.
    """

    def __init__(self, meshcat: Meshcat, station: Station):
        """`station` is one of an `open_scenario`."""
        self._meshcat, self._diagram, self._commands = meshcat, station.diagram, commands_of(station.parts)
        own = [slider for command in self._commands for slider in command.sliders]
        pressures = [c.sliders[0].name for c in self._commands if c.port.endswith(".pressure_command")]
        self._together = pressures if len(pressures) > 1 else []
        common = [pressure_slider(ALL_FINGERS, station.scenario.pressure, ALL_KEYS)] if self._together else []
        self.sliders: list[Slider] = common + own
        for slider in self.sliders:
            keys = {"decrement_keycode": slider.keys[0], "increment_keycode": slider.keys[1]}
            meshcat.AddSlider(slider.name, slider.low, slider.high, slider.step, slider.value, **keys)
        for button, key in BUTTON_KEYS.items():
            meshcat.AddButton(button, key)
        self._clicks = dict.fromkeys(Button, 0)
        self._common = self._common_pressure()

    def pressed(self) -> list[Button]:
        """The buttons that were clicked since this was last asked for."""
        before, self._clicks = self._clicks, {button: self._meshcat.GetButtonClicks(button) for button in Button}
        return [button for button in Button if self._clicks[button] > before[button]]

    def apply(self, context: Context) -> None:
        """Gives the station, in its context, what the sliders command."""
        if (common := self._common_pressure()) != self._common:
            self._common = common
            for name in self._together:
                self._meshcat.SetSliderValue(name, common)
        for command in self._commands:
            values = [self._meshcat.GetSliderValue(slider.name) for slider in command.sliders]
            self._diagram.GetInputPort(command.port).FixValue(context, command.value(values))

    def reset(self) -> None:
        """Moves all sliders to where they began."""
        for slider in self.sliders:
            self._meshcat.SetSliderValue(slider.name, slider.value)
        self._common = self._common_pressure()

    def _common_pressure(self) -> float:
        """What the slider of all fingers shows, kPa; 0 where there is none."""
        return self._meshcat.GetSliderValue(ALL_FINGERS) if self._together else 0.0

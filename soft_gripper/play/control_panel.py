"""ControlPanel: the sliders and buttons of a station, for the thread that runs it and for one that serves its page."""

from enum import StrEnum
from threading import Lock

from pydrake.systems.framework import Context

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.play.sliders import ALL_KEYS, Slider, commands_of, pressure_slider

ALL_FINGERS = "all fingers [kPa]"


class Button(StrEnum):
    """What a button is called."""

    PAUSE = "pause"
    RESET = "reset"
    RECORD = "record"
    STOP = "stop"


BUTTON_KEYS = {Button.PAUSE: "KeyP", Button.RESET: "KeyX", Button.RECORD: "KeyC", Button.STOP: ""}


class ControlPanel:
    """Where the sliders stand, and which buttons have been clicked.

    With the pressures of several fingers there is a slider that moves all of them.
    """

    def __init__(self, station: Station):
        """`station` is one of an `open_scenario`."""
        self._commands = commands_of(station.parts)
        own = [slider for command in self._commands for slider in command.sliders]
        pressures = [c.sliders[0].name for c in self._commands if c.port.endswith(".pressure_command")]
        self._together = pressures if len(pressures) > 1 else []
        common = [pressure_slider(ALL_FINGERS, station.scenario.pressure, ALL_KEYS)] if self._together else []
        self.sliders: list[Slider] = common + own
        self._by_name = {slider.name: slider for slider in self.sliders}
        self._lock, self._clicked = Lock(), set[Button]()
        self.reset()

    def take(self, message: object) -> bool:
        """Takes `{"slider": NAME, "value": NUMBER}` or `{"button": NAME}`; whether it was one, of what there is here.

        A value that is no finite number within the range of its slider is refused, as is anything else.
        """
        match message:
            case {"slider": str(name), "value": int(value) | float(value), **rest} if not rest:
                return name in self._by_name and self._move(self._by_name[name], value)
            case {"button": str(name), **rest} if not rest and name in set(Button):
                with self._lock:
                    self._clicked.add(Button(name))
                return True
            case _:
                return False

    def _move(self, slider: Slider, value: float) -> bool:
        if isinstance(value, bool) or not slider.low <= value <= slider.high:  # which NaN is not, either
            return False
        with self._lock:
            for name in [slider.name, *(self._together if slider.name == ALL_FINGERS else ())]:
                self._values[name] = float(value)
        return True

    @property
    def values(self) -> dict[str, float]:
        """Where every slider stands, in its unit."""
        with self._lock:
            return dict(self._values)

    def pressed(self) -> list[Button]:
        """The buttons that were clicked since this was last asked for."""
        with self._lock:
            clicked, self._clicked = self._clicked, set()
        return [button for button in Button if button in clicked]

    def apply(self, station: Station, context: Context) -> None:
        """Gives a station, in its context, what the sliders command."""
        values = self.values
        for command in self._commands:
            value = command.value([values[slider.name] for slider in command.sliders])
            station.diagram.GetInputPort(command.port).FixValue(context, value)

    def reset(self) -> None:
        """Moves all sliders to where they began."""
        with self._lock:
            self._values = {slider.name: slider.value for slider in self.sliders}

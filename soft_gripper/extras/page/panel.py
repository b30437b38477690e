"""Panel: the sliders and buttons of a page, shared by the thread that acts on them and the one that serves the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from threading import Lock

Keys = tuple[str, str]  # JavaScript's codes of the keys that decrease and increase it
ALL_KEYS: Keys = ("ArrowDown", "ArrowUp")
NO_KEYS: Keys = ("", "")
ALL_FINGERS = "all fingers [kPa]"


@dataclass(frozen=True)
class Slider:
    """A number set by the user. Names and numbers are in display units: kPa, mm, degrees."""

    name: str
    low: float
    high: float
    step: float
    value: float  # initial value
    keys: Keys = NO_KEYS


class Button(StrEnum):
    """A button of a page, with its name."""

    PAUSE = "pause"
    RESET = "reset"
    ZERO = "zero"
    RECORD = "record"
    STOP = "stop"


_BUTTON_KEYS = {Button.PAUSE: "KeyP", Button.RESET: "KeyX", Button.ZERO: "KeyZ", Button.RECORD: "KeyC", Button.STOP: ""}


class Panel:
    """Slider positions and clicked buttons, shared by the thread that acts on them and the one that serves the page."""

    def __init__(self, buttons: Sequence[Button], sliders: Sequence[Slider] = (), together: Sequence[str] = ()):
        """`together` are the names of the sliders that `ALL_FINGERS` moves."""
        self.buttons = {button: _BUTTON_KEYS[button] for button in buttons}
        self.sliders, self._together = list(sliders), together
        self._by_name = {slider.name: slider for slider in self.sliders}
        self._lock, self._clicked = Lock(), set[Button]()
        self.reset()

    def take(self, message: object) -> bool:
        """Takes `{"slider": NAME, "value": NUMBER}` or `{"button": NAME}`; returns whether it was valid.

        A value that is not a finite number within the range of its slider is rejected, as is anything else.
        """
        match message:
            case {"slider": str(name), "value": int(value) | float(value), **rest} if not rest:
                return name in self._by_name and self._move_slider(self._by_name[name], value)
            case {"button": str(name), **rest} if not rest and name in self.buttons:
                with self._lock:
                    self._clicked.add(Button(name))
                return True
            case _:
                return False

    def _move_slider(self, slider: Slider, value: float) -> bool:
        if isinstance(value, bool) or not slider.low <= value <= slider.high:  # also rejects NaN
            return False
        with self._lock:
            for name in [slider.name, *(self._together if slider.name == ALL_FINGERS else ())]:
                self._values[name] = float(value)
        return True

    @property
    def values(self) -> dict[str, float]:
        """The position of each slider, in its unit."""
        with self._lock:
            return dict(self._values)

    def take_clicks(self) -> list[Button]:
        """Returns and forgets the buttons clicked since the last call."""
        with self._lock:
            clicks, self._clicked = self._clicked, set()
        return [button for button in self.buttons if button in clicks]

    def reset(self) -> None:
        """Resets all sliders."""
        with self._lock:
            self._values = {slider.name: slider.value for slider in self.sliders}

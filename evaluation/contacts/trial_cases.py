"""What the estimators of contact are tried under: what is believed of the finger, and how good its sensors are."""

from collections.abc import Callable
from dataclasses import dataclass

from soft_gripper.diagrams.schema.scenario import BelievedConfig
from soft_gripper.diagrams.wiring.belief import believed_finger, describe_belief
from soft_gripper.evaluation.contact_sensors import LAYOUTS
from soft_gripper.evaluation.contacts.self_calibration import FreeMotion, Scale, trusting_chamber, trusting_stiffness
from soft_gripper.evaluation.contacts.trial_readings import HELD
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.uncertainty import Uncertainty

REALISTIC = "realistic"
# Those that estimate contact from a sample by itself: here no sample follows another, so `recursive` can learn nothing.
ESTIMATORS = ("contact",)
CALIBRATIONS: dict[str, Callable[[SensorLayout, FreeMotion], Scale]] = {
    "none": lambda believed, free: Scale(),
    "trusting stiffness": trusting_stiffness,
    "trusting chamber": trusting_chamber,
}


SHOWN_LAYOUT = LAYOUTS[1]  # in the figure


@dataclass(frozen=True)
class Case:
    """Belief and sensors."""

    youngs_modulus: str | None = None  # believed, as a change; None: as simulated
    calibration: str = "none"  # of CALIBRATIONS
    preset: str | None = None  # errors of the sensors; None: they are ideal
    averaged: int = 1  # samples
    reading: float = Uncertainty.reading  # standard deviation of the extension ratios, as it is believed

    @property
    def belief(self) -> str:
        """What is believed of the finger, in a few words."""
        return describe_belief(self._believed)

    @property
    def sensors(self) -> str:
        """In one word."""
        return self.preset or "ideal"

    def believed_finger(self, finger: Finger) -> Finger:
        """The finger as it is believed to be."""
        return believed_finger(finger, self._believed)

    @property
    def _believed(self) -> BelievedConfig:
        return BelievedConfig(youngs_modulus=self.youngs_modulus)


# What gain errors and hysteresis of a hundredth make of strains up to 0.15, and the noise of 0.002, all in all.
_SINGLE, _MEAN = 0.0025, 0.0015
CASES = (
    Case(),
    *(Case(change, calibration) for calibration in CALIBRATIONS for change in ("+10 %", "-10 %")),
    Case(preset=REALISTIC, averaged=1, reading=_SINGLE),
    Case(preset=REALISTIC, averaged=HELD, reading=_MEAN),
    *(
        Case(change, calibration, REALISTIC, HELD, _MEAN)
        for calibration in CALIBRATIONS
        for change in ("+10 %", "-10 %")
    ),
)
SHOWN_CASES = (CASES[0], Case("+10 %", "trusting chamber"), Case(preset=REALISTIC, averaged=HELD, reading=_MEAN))

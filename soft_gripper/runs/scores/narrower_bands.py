"""Improvements that narrow the band of a contact force wider than half of the force.

The finger is taken to be as it is estimated, so that its readings by other sensors are known, and one thing at a time
is changed: what the estimator assumes, or where the sensors are. The widths are those of `contact`.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.sensors.measurement import MeasurementModel

WIDE = 0.5  # width of a band over the force, above which it is asked what would narrow it
_WORTH = 0.8  # of the width: a change that leaves more is not worth a word
_CALIBRATED = 0.01  # standard deviation of gains and bend per pressure after a calibration, as shares
_AVERAGE = 0.2  # s


def narrower_bands(
    layout: MeasurementModel,
    uncertainty: Uncertainty,
    period: float,
    q: Array,
    driving: Array,
    gravity: Array,
    other_layouts: Mapping[str, MeasurementModel],
) -> dict[str, float]:
    """Widths of the band over the transverse force, as it is (the first, "") and with one thing changed.

    q are the estimated joint positions, (D), with the contact; `driving` the torques, (D) N m; `gravity`, (3) m/s^2, is
    in B; `period` in s; `other_layouts` other sensors on the same finger, by what they are called.
    """
    averaged = math.sqrt(period / max(_AVERAGE, period))
    assumptions = {
        "": uncertainty,
        "a calibration": _calibrated(uncertainty),
        f"a mean over {_AVERAGE:g} s": replace(uncertainty, reading=uncertainty.reading * averaged),
    }
    cases = [(name, layout, assumption) for name, assumption in assumptions.items()]
    cases += [(name, other_layout, uncertainty) for name, other_layout in other_layouts.items()]
    return {name: _width(ContactShape(sensors, assumption), q, driving, gravity) for name, sensors, assumption in cases}


def _calibrated(uncertainty: Uncertainty) -> Uncertainty:
    """The uncertainty after a calibration, which makes none larger."""
    common, variation, _ = uncertainty.bend_stds.tolist()
    return replace(
        uncertainty,
        gain=min(uncertainty.gain, _CALIBRATED),
        bend_per_pressure=min(common, _CALIBRATED),
        bend_variation=min(variation, EXACT),
    )


def _width(shape: ContactShape, q: Array, driving: Array, gravity: Array) -> float:
    arguments = shape.layout.read(q)[None], driving[None], gravity[None]
    contact = shape(*arguments).contact
    assert contact is not None
    assert contact.transverse_force is not None
    low, _, high = shape.posterior(*arguments).transverse_force_interval[0]
    force = float(contact.transverse_force[0])
    return float(high - low) / force if force > 0 else math.inf  # overlooked


def narrower_text(finger: str, widths: Mapping[str, float]) -> str:
    """Line on the improvements that narrow the band of a finger; empty without widths."""
    if not widths:
        return ""
    (_, width_now), *other_widths = widths.items()
    gains = [f"with {name} {width:.2f}" for name, width in other_widths if width < _WORTH * width_now]
    changes = ", ".join(gains) if gains else f"hardly narrower with {', '.join(name for name, _ in other_widths)}"
    return f"{finger}: the band is {width_now:.2f} of the force wide; {changes}\n"

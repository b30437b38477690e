"""Units in which hardware is recorded."""

from pathlib import Path

from soft_gripper.files.document import positive, require

LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}  # m
PRESSURE = {"Pa": 1.0, "hPa": 1e2, "mbar": 1e2, "kPa": 1e3, "bar": 1e5, "psi": 6894.757293168}  # Pa, NIST SP 811
TIME = {"s": 1.0, "ms": 1e-3}  # s


def factor(where: Path | str, field: str, unit: str, known: dict[str, float], scale: float | None = None) -> float:
    """The factor that converts a number in `unit` to SI; V, if a sensor reads volts, with its `scale`.

    Raises:
        InputError: if the unit is unknown, or a scale is missing or superfluous.
    """
    volts = unit == "V" and scale is not None
    require(unit in known or volts, where, f"{field}.unit", unit, f"one of {', '.join(known)}; or V, with a scale")
    if not volts:
        require(scale is None, where, f"{field}.scale", scale, "only a sensor in V has a scale")
        return known[unit]
    assert scale is not None
    require(positive(scale), where, f"{field}.scale", scale, "give a finite number above 0")
    return scale

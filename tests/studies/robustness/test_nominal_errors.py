"""Cases: noise scales every error of the preset, nominals are named and wrong as they say."""

import pytest

from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.robustness.rows import NOMINAL_ERRORS, NominalError, errors_at


def test_noise_is_a_multiple_of_the_preset() -> None:
    one, four = errors_at(1.0), errors_at(4.0)
    assert errors_at(0.0) is None
    assert one is not None
    assert four is not None
    for name in ("noise", "hysteresis", "gain_error", "drift"):
        assert getattr(one, name) > 0
        assert getattr(four, name) == pytest.approx(4 * getattr(one, name))
    assert four.creep_time == one.creep_time


def test_every_error_grows_with_the_noise_whatever_the_preset_has(monkeypatch) -> None:
    """All sizes of errors; neither times nor steps."""
    sizes = ("creep", "hysteresis", "gain_error", "offset", "drift", "low_frequency_noise", "noise")
    preset = StrainErrors(**dict.fromkeys(sizes, 0.01))
    monkeypatch.setattr("studies.robustness.rows.strain_errors", lambda _: preset)
    assert errors_at(2.0) == StrainErrors(**dict.fromkeys(sizes, 0.02))


def test_nominal_models_have_names() -> None:
    assert [nominal.name for nominal in NOMINAL_ERRORS] == ["as simulated", "E -10 %, p +1 %", "E +10 %, p -1 %"]
    assert NominalError(modulus=0.05).name == "E +5 %"


def test_a_nominal_model_is_wrong_by_its_size(shipped_finger) -> None:
    nominal = read_nominal_model(NominalError(-0.1).config).finger(shipped_finger)
    assert nominal.base.youngs_modulus == pytest.approx(0.9 * shipped_finger.base.youngs_modulus)
    assert read_nominal_model(NominalError(pressure=0.01).config).finger(shipped_finger) == shipped_finger
    assert NominalError(0.03, -0.04).size == pytest.approx(0.05)

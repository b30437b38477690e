"""Estimators over real contacts: a few of them, simulated, under every case."""

from functools import cache
from pathlib import Path

import pytest

from studies.contacts import estimates as contact_estimates
from studies.contacts.contacts import Contacts
from studies.contacts.peg import contact_arrays, run_contact
from studies.contacts.trials import ContactErrorRow, score_contacts

pytestmark = pytest.mark.slow


@cache
def smooth() -> Contacts:
    return contact_arrays([run_contact(1, i, 0.0) for i in range(4)])


@pytest.fixture(scope="module")
def scored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[ContactErrorRow], int]:
    folder, reports = tmp_path_factory.mktemp("scores"), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contact_estimates, "SEEDS", 1)
        rows = score_contacts(smooth(), folder, lambda: reports.append(1))
    return folder, rows, len(reports)


Scored = tuple[Path, list[ContactErrorRow], int]


def of(rows: list[ContactErrorRow], **wanted: object) -> ContactErrorRow:
    """The first row with these fields, of both sides."""
    wanted = {"side": "both", "nominal": "as simulated", "calibration": "none", "sensors": "ideal"} | wanted
    return next(row for row in rows if all(getattr(row, name) == value for name, value in wanted.items()))


def test_without_friction_force_and_place_are_found(scored: Scored) -> None:
    row = of(scored[1], sections=4)
    assert row.friction == 0
    assert row.found_percent == 100
    assert row.force_median_percent < 1
    assert row.place_median_percent < 0.5


@pytest.mark.parametrize("change", ["+10 %", "-10 %"])
def test_the_place_needs_the_ratio_and_the_force_the_stiffness(scored: Scored, change: str) -> None:
    nominal = f"youngs_modulus {change}"
    wrong, trusting_stiffness, trusting_chamber = (
        of(scored[1], sections=4, nominal=nominal, calibration=calibration)
        for calibration in ("none", "trusting stiffness", "trusting chamber")
    )
    assert trusting_stiffness.place_median_percent < 0.6 < 2 < wrong.place_median_percent
    assert trusting_chamber.place_median_percent < 0.2
    assert trusting_chamber.force_median_percent < 1
    assert trusting_stiffness.force_median_percent == pytest.approx(10, abs=2)

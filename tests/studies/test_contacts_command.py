"""python -m studies contacts, from the command line to its files."""

from pathlib import Path

import numpy as np
import pytest

from soft_gripper.commands.dispatch import dispatch
from soft_gripper.files.row_table import read_csv
from studies.commands import STUDIES
from studies.contacts import estimates as contact_estimates
from studies.contacts.contacts import load_contacts
from studies.contacts.peg import ContactTruthRow
from studies.contacts.trials import ContactErrorRow


@pytest.fixture(autouse=True)
def one_set_of_sensors(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the place of many, which take their time."""
    monkeypatch.setattr(contact_estimates, "SEEDS", 1)


@pytest.mark.slow
def test_table_and_arrays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dispatch(["contacts", "--trials", "4", "--seed", "2", "--jobs", "1", "--out", str(tmp_path)], STUDIES) == 0
    rows, arrays = read_csv(tmp_path / "contacts.csv", ContactTruthRow), load_contacts(tmp_path / "contacts.nc")
    assert [row.contact for row in rows] == [0, 1, 2, 3]
    np.testing.assert_allclose([abs(row.force_n) for row in rows], arrays.normal_force, atol=1e-6)
    assert [row.force_n > 0 for row in rows] == list(arrays.is_inside)
    np.testing.assert_allclose([row.arc_length_mm for row in rows], 1e3 * arrays.arc_length, atol=1e-6)
    np.testing.assert_allclose([1e3 * row.pressure_kpa for row in rows], arrays.pressure, atol=1e-2)
    np.testing.assert_allclose([(row.gravity_x, row.gravity_z) for row in rows], arrays.gravity[:, ::2], atol=1e-5)
    out = capsys.readouterr().out
    assert "drawn again" in out
    for name in ("contacts.csv", "contacts.nc", "contact_errors.csv", "contact_errors.png"):
        assert str(tmp_path / name) in out
    np.testing.assert_allclose(arrays.friction, 0.45)


@pytest.mark.slow
def test_kept_contacts_are_scored_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made, again = tmp_path / "made", tmp_path / "again"
    assert dispatch(["contacts", "--trials", "2", "--friction", "0", "--jobs", "1", "--out", str(made)], STUDIES) == 0
    assert dispatch(["contacts", "--contacts", str(made / "contacts.nc"), "--out", str(again)], STUDIES) == 0
    assert {path.name for path in again.iterdir()} == {f"contact_errors.{kind}" for kind in ("csv", "png", "svg")}
    assert (again / "contact_errors.csv").read_text() == (made / "contact_errors.csv").read_text()
    rows = read_csv(again / "contact_errors.csv", ContactErrorRow)
    assert {row.friction for row in rows} == {0}
    out = capsys.readouterr().out
    assert "trusting chamber" in out


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--trials", "none"),
        ("--friction", "-0.1"),
        ("--friction", "nan"),
        ("--friction", "1e308"),
        ("--friction", "rough"),
    ],
)
def test_mistakes_are_found_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str, value: str
) -> None:
    assert dispatch(["contacts", option, value, "--out", str(tmp_path)], STUDIES) == 2
    assert option in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_file_without_contacts_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dispatch(["contacts", "--contacts", str(tmp_path / "no.nc"), "--out", str(tmp_path)], STUDIES) == 2
    assert "no.nc" in capsys.readouterr().err

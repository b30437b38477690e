"""soft-gripper contact-trials, from the command line to its files."""

from pathlib import Path

import numpy as np
import pytest

from soft_gripper.commands.dispatch import dispatch
from soft_gripper.evaluation.contacts.contact_trials import ContactRow
from soft_gripper.evaluation.contacts.dataset import load_contacts
from soft_gripper.evaluation.csv_table import read_csv


def test_table_and_arrays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dispatch(["contact-trials", "--trials", "4", "--seed", "2", "--jobs", "1", "--out", str(tmp_path)]) == 0
    rows, arrays = read_csv(tmp_path / "contacts.csv", ContactRow), load_contacts(tmp_path / "contacts.npz")
    assert [row.contact for row in rows] == [0, 1, 2, 3]
    np.testing.assert_allclose([row.force_n for row in rows], arrays.force, atol=1e-6)
    np.testing.assert_allclose([row.arc_length_mm for row in rows], 1e3 * arrays.arc_length, atol=1e-6)
    np.testing.assert_allclose([1e3 * row.pressure_kpa for row in rows], arrays.pressure, atol=1e-2)
    np.testing.assert_allclose([row.gravity_z + 1j * row.gravity_x for row in rows], arrays.gravity, atol=1e-5)
    out = capsys.readouterr().out
    assert "drawn again" in out
    assert "contacts.csv, contacts.npz" in out


def test_mistakes_are_found_before_any_work(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dispatch(["contact-trials", "--trials", "none", "--out", str(tmp_path)]) == 2
    assert "--trials" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())

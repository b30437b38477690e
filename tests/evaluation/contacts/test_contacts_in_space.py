"""Contacts in space: their balance, the rows of the study, and what it finds on few of them."""

from pathlib import Path

import numpy as np
import pytest

from soft_gripper.evaluation.contacts.coverage import conditions
from soft_gripper.evaluation.contacts.space import (
    FIGURE,
    SMOOTH,
    TABLE,
    WAYS,
    SpatialRow,
    contacts_in_space,
    estimated,
    finger_in_space,
    main,
    spatial_row,
)
from soft_gripper.files.csv_table import read_csv
from soft_gripper.fingers.spatial_chain import posture, spatial_chain

IDEAL = conditions()[0]
PAGE = Path(__file__).parents[3] / "docs" / "contacts.md"


def test_contacts_are_in_balance_with_virtual_work():
    """Springs, pressure and weight are the work of the force on its place; the friction is as asked."""
    contacts, finger = contacts_in_space(12, 0.3, 4), finger_in_space()
    chain = spatial_chain(finger)
    order = chain.places(WAYS)
    stiffness = chain.spread(finger.stiffnesses)
    size = np.linalg.norm(contacts.force, axis=-1)
    np.testing.assert_allclose(size, np.hypot(1, 0.3) * contacts.normal_force, rtol=1e-6)

    def energy(q, i):
        at, links = posture(chain, q), chain.beyond(np.arange(finger.segments + 1))
        x, z = finger.links.center
        centres = (
            at.origins[links] + x[:, None] * at.rotations[links][..., 0] + z[:, None] * at.rotations[links][..., 2]
        )
        driving = chain.spread({"bending": finger.pressure_torque(contacts.pressure[i])})
        return stiffness @ q**2 / 2 - driving @ q - (finger.links.mass @ centres) @ contacts.gravity[i]

    for i in range(3):
        q, step = contacts.q[i][order], 1e-6 * np.eye(len(order))
        left = np.array([(energy(q + dq, i) - energy(q - dq, i)) / 2e-6 for dq in step])
        moved = int(chain.beyond(np.searchsorted(finger.joint_arc_lengths, contacts.arc_length[i])))
        np.testing.assert_allclose(left[moved:], 0, atol=1e-6)
        screws, force = posture(chain, q).screws[:moved], contacts.force[i]
        levers = np.cross(force, screws[:, :3])  # w . (p x F) = p . (F x w), of one place p for all joints
        place = np.linalg.lstsq(levers, left[:moved] - screws[:, 3:] @ force, rcond=None)[0]
        np.testing.assert_allclose(levers @ place + screws[:, 3:] @ force, left[:moved], atol=1e-6)


@pytest.mark.slow
def test_a_row_counts_what_is_true():
    contacts = contacts_in_space(40, 0.0, 5)
    found = estimated(4, contacts, IDEAL, 1)
    row = spatial_row(SMOOTH, IDEAL, 4, 0.1, contacts, found)
    assert row.number == len(contacts.q)
    assert row.force_percent < 3
    assert row.tip_mm < row.tip_gaussian_mm
    wrong = contacts._replace(normal_force=50 * contacts.normal_force, force=-contacts.force)
    row = spatial_row(SMOOTH, IDEAL, 4, 0.1, wrong, found)
    assert row.bound_percent < 20
    assert row.direction_degrees > 150


@pytest.mark.slow
def test_the_study_writes_its_table_and_figure(tmp_path, capsys):
    main(20, 3, 1, 0, str(tmp_path))
    rows = read_csv(tmp_path / TABLE, SpatialRow)
    assert {row.contacts for row in rows} == {SMOOTH, "any friction", "friction at the cone"}
    assert (tmp_path / f"{FIGURE}.png").stat().st_size > 10_000
    assert "least coverage" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("sections", [2, 4])
def test_errors_of_smooth_contacts_are_those_that_are_printed(sections):
    contacts = contacts_in_space(1000, 0.0, 1)
    contacts = contacts.at(contacts.arc_length > finger_in_space().length / 3)
    row = spatial_row(SMOOTH, IDEAL, sections, float("nan"), contacts, estimated(sections, contacts, IDEAL, 1))
    page = PAGE.read_text(encoding="utf-8")
    (line,) = (
        line for line in page.splitlines() if line.startswith(f"| {SMOOTH} | ideal sensors, exact model | {sections} |")
    )
    printed = [float(cell.split("(")[0]) for cell in line.split("|")[-5:-1]]
    measured = row.force_percent, row.direction_degrees, row.location_percent, row.tip_mm
    np.testing.assert_allclose(measured, printed, rtol=0.06)

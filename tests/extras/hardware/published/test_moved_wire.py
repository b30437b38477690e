"""Cost of a wire of the recorded arm that moves after the fit, as docs/extras/hardware/hardware_replay.md has it."""

import numpy as np
import pytest
from csv_rows import csv_rows
from hardware_files import published

from soft_gripper.commands.dispatch import dispatch
from soft_gripper.extras.hardware.recording_schema import load_description

WIRE, MOVED = "left_upper", (3, 10)  # mm


@pytest.mark.published
def test_a_wire_that_moves_leaves_the_band_and_is_far_before_it_disagrees(tmp_path, capsys):
    folder, config = published("two_segment_arm"), load_description("two_segment_arm")
    column = config.header.index(config.lengths.wires[WIRE].column)
    files = [folder / "trial_7.txt", *(tmp_path / f"moved_{shift}.txt" for shift in MOVED)]
    for shift, file in zip(MOVED, files[1:], strict=True):
        rows = [line.split(",") for line in files[0].read_text().splitlines()]
        for row in rows:
            row[column] = f"{float(row[column]) + 1e-3 * shift / config.lengths.scale:.8f}"
        file.write_text("\n".join(map(",".join, rows)) + "\n")
    fitted = [str(folder / f"trial_{number}.txt") for number in range(1, 7)]
    options = ["--as", "two_segment_arm", "--estimator", "arcs", "--out", str(tmp_path / "out")]
    assert dispatch(["replay", *map(str, files), "--fit", *fitted, *options]) == 0
    tips = {
        row["recording"]: [float(row[name]) for name in ("mean_mm", "within_band_percent", "far_percent")]
        for row in csv_rows(tmp_path / "out/replay.csv")
        if (row["sections"], row["body"]) == ("2", "tip")
    }
    expected = [[2.6, 98.1, 0], [8.1, 21.9, 53], [31.8, 0, 100]]
    np.testing.assert_allclose([tips[file.stem] for file in files], expected, atol=0.5)
    warned = "".join(capsys.readouterr())
    assert "WARNING: moved_3: 53 % of it is far from what was fitted" in warned
    assert [shift for shift in MOVED if f"moved_{shift}: wires and pressures of section 1 disagree" in warned] == [10]

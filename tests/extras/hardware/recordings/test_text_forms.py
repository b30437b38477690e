"""Text as loggers, spreadsheets and scripts write it: the same recording, or a line that says why not."""

import json
from functools import partial

import numpy as np
import pytest
from hardware_files import swinging, whys
from log_forms import FORMS, REFUSED, drawn, table
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recordings import read_recording

CONTENT = table(swinging())


DRAWN = {f"drawn {seed}": partial(drawn, seed=seed) for seed in range(30)}


@pytest.mark.parametrize("form", [*FORMS, *DRAWN])
def test_the_same_in_every_form(tmp_path, describe, form):
    (tmp_path / "plain.csv").write_bytes(FORMS["plain"](CONTENT).content)
    written = (FORMS | DRAWN)[form](CONTENT)
    (tmp_path / "log.csv").write_bytes(written.content)
    plain, found = (
        read_recording(tmp_path / name, config)
        for name, config in (("plain.csv", describe()), ("log.csv", describe(written.more)))
    )
    np.testing.assert_allclose(found.time, plain.time - plain.time[0], atol=1e-6)
    for marker, places in plain.markers.items():
        np.testing.assert_allclose(found.markers[marker], places, atol=1e-9)
    assert bool(found.notes) == written.noted, whys(found)


@pytest.mark.parametrize("form", REFUSED)
def test_what_is_not_read_is_named(tmp_path, describe, form):
    content, said = REFUSED[form](CONTENT)
    (tmp_path / "log.csv").write_bytes(content)
    with pytest.raises(InputError, match=said):
        read_recording(tmp_path / "log.csv", describe())


def test_lost_rows_are_said(tmp_path, describe):
    lines = FORMS["plain"](CONTENT).content.decode().splitlines()
    (tmp_path / "log.csv").write_text("\n".join(line + ",more" * (i % 4 > 0) for i, line in enumerate(lines)))
    found = read_recording(tmp_path / "log.csv", describe())
    assert whys(found)[0].startswith(
        "150 of 200 rows: the first of them, row 2, has 14 cells, and there are 13 columns"
    )


def test_columns_that_are_not_needed_may_be_anything(tmp_path, describe):
    lines = FORMS["plain"](CONTENT).content.decode().splitlines()
    text = "\n".join([lines[0] + ",state,state", *(line + ",OK,1.2.3" for line in lines[1:])])
    (tmp_path / "log.csv").write_text(text)
    assert len(read_recording(tmp_path / "log.csv", describe()).time) == 200


def test_a_name_of_two_columns_is_refused(tmp_path, describe):
    text = FORMS["plain"](CONTENT).content.decode().replace("tip_2_x_mm", "tip_1_x_mm", 1)
    (tmp_path / "log.csv").write_text(text)
    with refused("markers", "tip_1_x_mm") as error:
        read_recording(tmp_path / "log.csv", describe())
    assert "2 columns" in str(error.value)


def test_json_of_other_loggers(tmp_path, describe):
    rows = [dict(zip(CONTENT.names, map(float, row), strict=True)) | {"device": {"id": "x"}} for row in CONTENT.rows]
    texts = "\n".join(map(json.dumps, rows)), json.dumps(rows, indent=1), "\n".join([*map(json.dumps, rows), '{"cut'])
    for text in texts:
        (tmp_path / "log.json").write_text(text)
        found = read_recording(tmp_path / "log.json", describe())
        assert len(found.time) == 200
        assert len(found.notes) == ('{"cut' in text)


@pytest.mark.parametrize(("more", "value"), [("", "101.3 kPa at rest"), ("ambient: 101.325", 0), ("zeroed: true", 0)])
def test_a_pressure_against_vacuum_is_questioned(tmp_path, describe, more, value):
    absolute = [*(101.325 + 0 * np.arange(100)), *(101.325 + 0.6 * np.arange(100))]
    content = table({**swinging(), "kPa": np.array(absolute)})
    (tmp_path / "log.csv").write_bytes(FORMS["plain"](content).content)
    config = describe(f"pressures: {{ columns: [kPa], unit: kPa, {more} }}")
    if not more:
        with refused("pressure in kPa", value) as error:
            read_recording(tmp_path / "log.csv", config)
        assert "ambient" in str(error.value)
        return
    pressures = read_recording(tmp_path / "log.csv", config).pressures[:, 0]
    np.testing.assert_allclose(pressures, 1e3 * (np.array(absolute) - 101.325), atol=1e-6)

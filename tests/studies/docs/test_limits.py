"""Numbers of the pages on limits, contacts, estimators and sensors, compared with committed tables and each other.

The studies `model-errors`, `contact-coverage` and `contacts --seed 1`, with `--friction 0` too, wrote the tables in
docs/studies, and `sensor-presets` docs/sensor_presets.csv.
"""

import re
from dataclasses import astuple
from itertools import product

import numpy as np
import pytest
from csv_rows import csv_rows
from printed_numbers import differences, printed, sentence_problems, table_problems

from soft_gripper.commands.parser import parse_options
from soft_gripper.files.row_table import read_csv
from soft_gripper.scenario.schema import presets
from studies import ROOT
from studies.commands import STUDIES
from studies.contacts.contact_coverage import SITUATIONS, coverage_rows
from studies.contacts.model_errors import SETUPS, TABLE, ModelErrorRow, model_error_rows
from studies.contacts.situations import DIFFERENCES, PEG
from studies.contacts.trials import ContactErrorRow
from studies.estimator_setup import MODELS, REALISTIC, EstimatorSetup
from studies.robustness.plants import RUBBER
from studies.robustness.robustness import plant_rows
from studies.robustness.sensor_presets import TABLE as PRESETS_TABLE
from studies.robustness.sensor_presets import PresetRow, preset_row

DOCS = ROOT / "docs"
TABLES = DOCS / "studies"
CONTACTS, HARDWARE = "studies/contacts.md", "../studies/hardware/README.md"
BESIDE = "../studies/contacts/README.md"  # of the study
ROWS = read_csv(TABLES / TABLE, ModelErrorRow)
PRESET_ROWS = read_csv(PRESETS_TABLE, PresetRow)
*_, SHIFTED, STRONG, _, _ = DIFFERENCES
SHARES = "interval_percent", "transverse_percent", "place_percent", "touched_percent"


def page(name):
    return (DOCS / name).read_text(encoding="utf-8")


def row_of(difference, sections=4, sensors="ideal"):
    (row,) = [row for row in ROWS if (row.difference, row.sections, row.sensors) == (difference, sections, sensors)]
    return row


def span_of(difference, share):
    shares = [getattr(row, share) for row in ROWS if row.difference == difference]
    return [min(shares), max(shares)]


def preset(name):
    (row,) = [row for row in PRESET_ROWS if row.preset == name]
    return row


def numbers(text):
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)]


def test_the_command_of_the_page_wrote_it():
    (line,) = re.findall(r"python -m studies (model-errors.*)", page(CONTACTS))
    options = parse_options(line.partition("#")[0].split(), STUDIES)
    assert {row.seed for row in ROWS} == {options.seed}
    assert max(row.contacts for row in ROWS) <= options.contacts
    assert [(row.difference, row.sections, row.sensors) for row in ROWS] == [
        (name, setup.sections, setup.sensors) for name in DIFFERENCES for setup in SETUPS
    ]


LIMITS = {
    r"a border 10 mm off, location sets cover # %": [row_of(SHIFTED).place_percent],
    r"`textile` ones the tip errs by # mm instead of #": [preset(name).tip_error_mm for name in ("textile", REALISTIC)],
    r"before a third of the length, intervals cover # to # %": span_of(STRONG, "interval_percent"),
}


@pytest.mark.parametrize("pattern", LIMITS)
def test_limitations_say_what_the_command_wrote(pattern):
    assert not sentence_problems(page("limitations.md"), pattern, LIMITS[pattern])


@pytest.mark.parametrize(
    ("difference", "setup"),
    [
        pytest.param(
            name, setup, marks=pytest.mark.slow if (name, setup) == ("none", SETUPS[0]) else pytest.mark.published
        )
        for name in DIFFERENCES
        for setup in SETUPS
    ],
)
def test_the_command_still_writes_it(difference, setup):
    """Within two contacts, which another processor may round apart."""
    written = row_of(difference, setup.sections, setup.sensors)
    (row,) = model_error_rows(difference, setup, 500, written.seed)
    assert row.contacts == written.contacts
    for name in SHARES:
        assert getattr(row, name) == pytest.approx(getattr(written, name), abs=200 / row.contacts, nan_ok=True)


EQUAL, UNEQUAL, FOUR = "60", "40", "30 60 90"  # mm, borders of sections
FORCE, TRANSVERSE, PLACE = (
    [f"{kind}_{name}_percent" for name in ("mean", "median", "90")] for kind in ("force", "transverse", "place")
)


def trials(file, borders, sensors="ideal", averaged=1, calibration="none", signs=("",)):
    """The worst errors of nominal stiffnesses with a deviation of 10 % and these signs; none: exact."""
    nominals = [f"youngs_modulus {sign}10 %" if sign else "as simulated" for sign in signs]
    case = borders, sensors, averaged, calibration, "both"
    rows = [
        row
        for row in read_csv(TABLES / f"{file}.csv", ContactErrorRow)
        if (row.borders, row.sensors, row.averaged, row.calibration, row.side) == case and row.nominal in nominals
    ]
    assert len(rows) == len(signs)
    return [max(getattr(row, name) for row in rows) for name in ("found_percent", *FORCE, *TRANSVERSE, *PLACE)]


def test_the_table_of_exact_models_is_what_the_command_wrote():
    labels = {EQUAL: [2], UNEQUAL: [2, 40], FOUR: [4]}
    expected = [[*label, *trials("contact_errors", borders)[1:]] for borders, label in labels.items()]
    assert not table_problems(
        page(CONTACTS), "sections per side | normal force [%]: mean / median / 90th percentile", expected
    )


def test_the_table_of_sensors_with_errors_is_what_the_command_wrote():
    single, mean = {"sensors": REALISTIC}, {"sensors": REALISTIC, "averaged": 20}
    wrong = mean | {"calibration": "trusting chamber", "signs": "+-"}
    two, four = (
        [trials("contact_errors", borders, **options) for options in (single, mean, wrong)]
        for borders in (UNEQUAL, FOUR)
    )
    equal = [10, 90, 33, 18, 83, 33, 18, 83, 13, 6.4, 35]  # test_readme.py runs the command
    expected = [two[0], [20, *two[1]], [10, 20, *two[2]], equal, four[0], [20, *four[1]], [10, *four[2]]]
    assert not table_problems(page(CONTACTS), "two sections divided at 40 mm | detected", expected)


def test_the_table_of_calibrations_is_what_the_command_wrote():
    calibrations = "none", "trusting stiffness", "trusting chamber"
    found = [trials("contact_errors", UNEQUAL, calibration=each, signs="+") for each in calibrations]
    expected = [[10, *errors[1:4], *errors[7:]] for errors in found]
    assert not table_problems(page(CONTACTS), "calibration | nominal stiffness", expected)


def test_errors_are_within_two_deviations_as_often_as_the_page_says():
    within = [
        value
        for file in ("contact_errors_smooth", "contact_errors")
        for row in read_csv(TABLES / f"{file}.csv", ContactErrorRow)
        if (row.sensors, row.nominal, row.side) == ("ideal", "as simulated", "both")
        for value in (row.force_within_2_std_percent, row.place_within_2_std_percent)
    ]
    assert not sentence_problems(page(CONTACTS), r"# to # % of the errors lie within two", [min(within), max(within)])


COVERED = {
    (row["situation"], row["sections"], row["sensors"], row["model"]): row
    for row in csv_rows(TABLES / "contact_coverage.csv")
}
EXACT, WRONG, CALLED_EXACT = MODELS
SINGLE = "at rest", "sliding"
SENSORS, SECTIONS = ("ideal", REALISTIC), "24"


def covered(name, *keys):
    """The finite numbers of a column in the rows of situations, sections, sensors and models."""
    values = [float(COVERED[key][name]) for key in product(*keys) if key in COVERED]
    return [value for value in values if np.isfinite(value)]


def test_the_table_of_coverage_is_what_the_command_wrote():
    pairs, expected = (("ideal", EXACT), (REALISTIC, WRONG)), []
    for situation in (*SINGLE, "two contacts", "a spread contact", "in space", PEG[1]):
        columns = product(pairs, ("interval_percent", "interval_least_percent"))
        cells = [covered(name, [situation], "24", [sensors], [model]) for (sensors, model), name in columns]
        expected.append([min(numbers) for numbers in cells if numbers])
    header = "situation | ideal, exact | realistic, wrong"
    assert not table_problems(page(CONTACTS), header, expected)


def test_the_table_of_widths_is_what_the_command_wrote():
    expected = []
    for sections in SECTIONS:
        row = COVERED["at rest", sections, REALISTIC, WRONG]
        widths = [f"{band}_width_{third}" for third in ("near", "middle", "far") for band in ("interval", "transverse")]
        expected.append([float(sections), *(float(row[name]) for name in [*widths, "transverse_rms_z"])])
    assert not table_problems(page(BESIDE), "sections | 10 to 40 % of the length", expected)


@pytest.mark.slow
def test_the_study_still_counts_as_much():
    (row,) = coverage_rows(SINGLE[0], EstimatorSetup(2), 1.0, 1)
    written = COVERED[SINGLE[0], "2", "ideal", EXACT]
    for name in ("contacts", "interval_percent", "bound_several_percent", "place_percent"):
        assert float(getattr(row, name)) == pytest.approx(float(written[name]), abs=0.5)


def test_the_table_of_errors_is_what_the_command_wrote():
    thirds = "near", "middle", "far"
    expected = [
        [float(sections)]
        + [
            float(COVERED["at rest", sections, REALISTIC, WRONG][f"{error}_{name}_{third}"])
            for third in thirds
            for name in ("mean", "90")
        ]
        for error in ("force_n", "place_percent")
        for sections in "24"
    ]
    assert not table_problems(page(BESIDE), "error | sections | 10 to 40 %", expected)


def span(*keys):
    values = covered(*keys)
    return [min(values), max(values)]


STATED = {
    r"hold at rest in # % \(two sections\) and # % \(four\)": covered(
        "interval_percent", SINGLE[:1], SECTIONS, ["ideal"], [CALLED_EXACT]
    ),
    r"it covers their sum in # to # % of cases": span("bound_several_percent", SITUATIONS, "4", SENSORS, MODELS),
    r"\*\*After a step of pressure\*\* # to # of a hundred answers": span(
        "withheld_percent", PEG[1:], SECTIONS, SENSORS, [EXACT, WRONG]
    ),
    r"holds in # to # % of contacts at rest and sliding": span(
        "transverse_percent", SINGLE, "24", [REALISTIC], [EXACT, WRONG]
    ),
    r"In the worst tenth of the length it holds in # % with two sections and # % with four": [
        min(covered("transverse_least_percent", SINGLE, sections, [REALISTIC], [EXACT, WRONG])) for sections in "24"
    ],
    r"covers # to # % of forces at rest and sliding": span(
        "bound_beyond_percent", SINGLE, SECTIONS, SENSORS, [EXACT, WRONG]
    ),
    r"With two equal sections, # to # of a hundred such contacts": span(
        "unbounded_beyond_percent", SINGLE, "2", SENSORS, [EXACT, WRONG]
    ),
    r"always with two sections, in # to # % of cases with four": [
        100 - value
        for value in reversed(
            span("withheld_percent", ["two contacts", "a spread contact"], "4", SENSORS, [EXACT, WRONG])
        )
    ],
    r"falls from # to # N with two sections. With four it falls from # to # N": [
        float(COVERED["in space", sections, REALISTIC, WRONG][f"force_n_mean_{third}"])
        for sections in SECTIONS
        for third in ("near", "far")
    ],
    r"is # degrees with two ideal sections and # with four. Realistic sensors raise it to # and # degrees": [
        float(COVERED["in space", sections, sensors, EXACT]["degrees_median"])
        for sensors in SENSORS
        for sections in SECTIONS
    ],
}


@pytest.mark.parametrize("pattern", STATED)
def test_the_page_says_what_the_command_counted(pattern):
    assert not sentence_problems(page(CONTACTS) + page(BESIDE), pattern, STATED[pattern])


def test_the_table_of_presets_is_what_was_measured():
    text = page("sensors.md")
    cells = dict(re.findall(r"^\| `(\w+)` \|[^|]*\| (.*) \|$", text, re.MULTILINE))
    assert [row.preset for row in PRESET_ROWS] == [*presets()]
    for row in PRESET_ROWS:
        assert differences(cells[row.preset], list(astuple(row)[1:-1])) == []


@pytest.mark.published
@pytest.mark.parametrize("row", PRESET_ROWS, ids=lambda row: row.preset)
def test_presets_still_err_as_much(row):
    for value, expected in zip(astuple(preset_row(row.preset))[1:-1], astuple(row)[1:-1], strict=True):
        assert value == pytest.approx(expected, rel=0.01, abs=0.2)


HELD = r"`recursive`(?: \| [\d./]+){3} \| # \|"  # the first of a table: free bending, covered with two sensors
REPEATED = [  # what a page repeats, and where it is measured
    ("limitations.md", r"bands cover # % in free bending with two sensors", "studies/robustness.md", HELD),
    (
        "limitations.md",
        r"It is right in # % with two realistic sensors per side",
        "../studies/benchmark/README.md",
        r"\| realistic sensors \| # %",
    ),
    (
        "limitations.md",
        r"raises the tip error from # to # mm",
        "extras/hardware/hardware_replay.md",
        r"raises the tip error from # to # mm",
    ),
    ("limitations.md", r"v4 covers # % of pulls", HARDWARE, r"band of v4 covers # %"),
    (
        "missed_targets.csv",
        r"turn within 10 %\",\"\(#, measured # degrees\)",
        HARDWARE,
        r"settled turn, degrees .*? \| # \(#\): \*\*misses",
    ),
    (
        "missed_targets.csv",
        r"\(# at 40 kPa\)",
        HARDWARE,
        r"at all times .* \| # %: \*\*misses",
    ),
    ("missed_targets.csv", r"not shown by #", "extras/grasps/grasp_trials.md", r"all of # cups succeeded"),
    (
        "missed_targets.csv",
        r"over bare plant: 1\.5 times\",\"\(#\)",
        "../studies/speed/README.md",
        r"\| all \| [\d.]+ \| # \|",
    ),
    ("missed_targets.csv", r"20 ms more\",\"\(#\)", "../studies/speed/README.md", r"overhead of 28 and # ms a run"),
]


def said(name, pattern):
    """The numbers of a sentence, by their size."""
    found = printed(" ".join(page(name).split()), pattern.replace("#", r"(\d+(?:\.\d+)?)"))
    return sorted(found, key=float)


@pytest.mark.parametrize(("name", "pattern", "source", "measured"), REPEATED)
def test_pages_repeat_what_was_measured(name, pattern, source, measured):
    assert differences(" ".join(said(name, pattern)), [float(number) for number in said(source, measured)]) == []


@pytest.mark.published
def test_recursive_still_covers_as_much_of_rubber_in_free_bending():
    rows = plant_rows(RUBBER.name, "free_bending", 20, ["recursive"])
    (row,) = [row for row in rows if row.sections == 2]
    assert round(100 * row.coverage) == pytest.approx(float(said(*REPEATED[0][:2])[0]), abs=1)

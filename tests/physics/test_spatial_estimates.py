"""Estimators of the plane, and one of space, with fingers that leave it: the errors that docs/estimators.md prints."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from finger_plants import free_bending
from pydrake.common.schema import Transform
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_

from soft_gripper.diagrams.simulation import make_simulator, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.scenario.scenario_file import load_scenario

PAGE = Path(__file__).parents[2] / "docs" / "estimators.md"
WAYS = "yields=bending sideways twist"
EXACT = "estimator.uncertainty.bend_per_pressure=0.005"
ALL = [f"estimator.alongside=[{', '.join(kind for kind in SHAPE_FUNCTIONS if kind != 'arcs')}]", EXACT]
LAYOUTS = ("four_faces", "outer_pair_and_diagonals", "four_faces_and_diagonal")
FORCE = 0.3  # N


def in_space(layout):
    return ["estimator.type=gaussian", "estimator.alongside=[constant_curvature, contact]",
            f"sensor.layout={layout}", "sensor.sections=2", EXACT]  # fmt: skip


def pushed_sideways(pressure, overrides):
    fingers = [f"models.{side}_finger.fingers.all.{WAYS}" for side in ("left", "right")]
    station = make_station(free_bending([pressure], 3.0, *fingers, *overrides))
    simulator = make_simulator(station)
    loads = []
    for finger in station.fingers:
        load = ExternallyAppliedSpatialForce_[float]()
        load.body_index = finger.links[-1].index()
        load.p_BoBq_B = [0, 0, finger.finger.segment_length / 2]
        load.F_Bq_W = SpatialForce(np.zeros(3), finger.X_WB.rotation() @ [0, FORCE, 0])
        loads.append(load)
    context = station.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    station.plant.get_applied_spatial_force_input_port().FixValue(context, Value(loads))
    return at_last(station, simulator, 3.0)


def turned_box(overrides):
    steps = ("pressure.steps.all=[100e3]", "pressure.settle=2.99", "pressure.hold_samples=1")
    scenario = load_scenario("box_grasp", [*steps, *overrides, f"models.gripper.fingers.all.{WAYS}"])
    scenario.models[-1].X_PC = Transform(RigidTransform(RollPitchYaw(0, 0, np.radians(20)), [0, 0, 0.03001]))
    station = make_station(scenario)
    return at_last(station, make_simulator(station), 3.0)


def at_last(station, simulator, time):
    """Mean tip error of the fingers by estimator, mm; it is more than what the tip lies out of the plane."""
    simulator.AdvanceTo(time)
    context = simulator.get_context()

    def mean(signal, part=slice(None)):
        ports = [station.diagram.GetOutputPort(f"{finger.name}.{signal}") for finger in station.fingers]
        return 1e3 * np.mean([np.abs(port.Eval(context)[part]) for port in ports])

    kinds = [station.parts.estimator, *station.scenario.estimator.alongside]
    names = {kind: "" if kind == station.parts.estimator else f"{kind}." for kind in kinds}
    errors = {kind: mean(f"{name}fingertip_error") for kind, name in names.items()}
    return errors | {"of this, out of the plane": mean("true_tip_position", slice(1, 2))}


def printed():
    """Rows of the table by their first cells."""
    page = PAGE.read_text(encoding="utf-8")
    table = page[page.index("| tip error of fingers in space") :].split("\n\n")[0]
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    return {row[0]: [float(cell) for cell in row[1:]] for row in rows}


@pytest.mark.published
def test_tip_errors_of_fingers_in_space_are_those_that_are_printed():
    runs = [partial(pushed_sideways, 120e3), turned_box]
    columns = [run(ALL) for run in runs]
    found = {row: [column[row] for column in columns] for row in columns[0]}
    planar = np.array([found[kind] for kind in SHAPE_FUNCTIONS])
    assert np.all(planar >= np.array(found["of this, out of the plane"]) - 1e-6)
    for layout in LAYOUTS:
        columns = [run(in_space(layout)) for run in runs]
        found[f"gaussian` with `{layout}"] = [column["gaussian"] for column in columns]
    for kind in ("constant_curvature", "contact"):
        found[f"{kind}` with `{LAYOUTS[-1]}"] = [column[kind] for column in columns]
    for row, values in found.items():
        print(f"| {row} | " + " | ".join(f"{value:.2f}" for value in values) + " |")
    for row, values in printed().items():  # the page shows one of the estimators that see the plane alone
        np.testing.assert_allclose(values, found[row], atol=5.1e-3)


@pytest.mark.slow
def test_the_force_of_a_turned_box_is_found_as_a_vector_with_its_friction():
    """In Drake's contacts, friction and all: medians over the grasp, of which the page says the magnitude and angle."""
    scenario = load_scenario(
        "turned_box_grasp",
        ["sensor.layout=four_faces_and_diagonal", "sensor.sections=2", "estimator.type=contact", EXACT],
    )
    data = simulate(scenario).data
    for name in ("left_finger", "right_finger"):
        found, true = (data[f"{name}.{kind}contact_force_world"].values for kind in ("", "true_"))
        sizes = np.linalg.norm(found, axis=-1), np.linalg.norm(true, axis=-1)
        touched = (sizes[0] > 0) & (sizes[1] > 0.05)
        cosine = (found * true).sum(axis=-1)[touched] / (sizes[0] * sizes[1])[touched]
        magnitude = np.median(np.abs(sizes[0][touched] / sizes[1][touched] - 1))
        angle = np.median(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
        bound = data[f"{name}.contact_force_bounds"].values[:, 0]
        held = np.mean(~(bound < np.abs(data[f"{name}.true_contact_force"].values.ravel())))
        print(f"{name}: {100 * magnitude:.2f} %, {angle:.2f} degrees, bound {held:.4f}")
        text = " ".join(PAGE.read_text(encoding="utf-8").split())
        assert f"{100 * magnitude:.0f} % of its magnitude and {angle:.0f} degrees" in text
        assert held > 0.98

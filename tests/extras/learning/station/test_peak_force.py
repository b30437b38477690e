"""PeakForce: what fingers press with, now and at worst."""

import numpy as np
import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from soft_gripper.diagrams.private_run import Kept
from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.extras.learning import station as module
from soft_gripper.truth.contact import Patch


def test_forces_are_along_normals_of_any_length_and_not_those_of_a_finger_on_itself(monkeypatch):
    def patch(*shapes, normal=(0.0, 0.0, 1e-4)):  # of a surface it is as long as that is large
        return Patch(shapes, np.zeros(3), np.array(normal), np.array([0.3, 0.0, -2.0]), np.zeros(3))

    found = [patch("left", "block"), patch("table", "right", normal=(5.0, 0.0, 0.0)), patch("left", "left too")]
    monkeypatch.setattr(module, "patches", lambda *_: found)
    forces = module.normal_forces(None, {"left": 0, "left too": 0, "right": 1}, 2)
    np.testing.assert_allclose(forces, [2.0, 0.3])


@pytest.fixture(scope="module")
def whole_station(grasp_environment):
    """A station of SoftGrasp-v0 with the true signals, which nothing in it reads."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "keep_what_is_read", lambda builder, signals: Kept(dict(signals), {}))
        return module.make_learning_station(grasp_environment.config, grasp_environment.scenario)


@pytest.fixture(scope="module")
def gripped(whole_station):
    """Peak and present forces, (T, F) each, and true ones, every 50 ms of a grip that is made and loosened."""
    diagram, parts, forces = whole_station.diagram, whole_station.parts, whole_station.forces
    simulator = Simulator(diagram)
    ApplySimulatorConfig(solver_config(parts.scenario), simulator)
    context = simulator.get_mutable_context()
    own = forces.GetMyContextFromRoot(context)
    truth = [parts.signals[f"{finger.name}.normal_force"] for finger in parts.fingers]
    rows = []
    for grip in [0.3] * 16 + [-1.0] * 16:
        diagram.GetInputPort("action").FixValue(context, [grip, -1.0])
        simulator.AdvanceTo(context.get_time() + 0.05)
        known = [port.Eval(port.get_system().GetMyContextFromRoot(context))[0] for port in truth]
        rows.append((forces.GetOutputPort("peak").Eval(own), forces.GetOutputPort("force").Eval(own), known))
    return (np.array(column) for column in zip(*rows, strict=True))


def test_forces_are_the_true_ones_and_the_peak_stays(gripped):
    peak, force, truth = gripped
    np.testing.assert_allclose(force, truth, atol=1e-12)
    assert force.max() > 0.3
    assert not force[-1].any()
    assert (np.diff(peak, axis=0) >= 0).all()
    assert (peak[1:] >= force[:-1] - 1e-12).all()
    assert (peak[-1] < 1.5 * force.max(axis=0)).all()

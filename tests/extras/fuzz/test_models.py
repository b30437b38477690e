"""Models as other people write them are read rightly, with a note on all that was changed, or refused by name.

Mass, joints, places of links at random positions and volumes of shapes are known for each, and which notes are due.
`make fuzz` tries many more, from a new seed every time.
"""

import os
import zlib
from pathlib import Path

import numpy as np
import pytest
from model_chain import Rng, places, positions
from model_kinds import KINDS, Model
from pydrake.common.schema import Transform
from pydrake.geometry import CalcVolume, Role
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.control.couplings import couplings
from soft_gripper.diagrams.scene import add_model, arm_joints
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
from soft_gripper.scenario.schema import ArmConfig, ModelConfig

FUZZ = int(os.environ.get("FUZZ", "0"))  # models of every kind; 0: few, and always the same
NUMBER = FUZZ or 4
FIRST = int.from_bytes(os.urandom(4)) if FUZZ else 0  # seed


@pytest.fixture(autouse=True)
def _cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def faults(model: Model, rng: Rng, folder: Path) -> list[str]:
    """What is wrong with how a model is read."""
    path = folder / f"model.{model.suffix}"
    for name, content in model.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    if model.content:
        path.write_text(model.content)
    X_WP = (
        RigidTransform() if model.stays else RigidTransform(RollPitchYaw(rng.uniform(-1, 1, 3)), rng.uniform(-1, 1, 3))
    )
    config = ModelConfig("thing", str(path), free=model.free, X_PC=Transform(X_WP))
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    try:
        with collect_notes() as notes:
            loaded = add_model(plant, config, "models[0]", ArmConfig() if model.is_arm else None)
    except InputError as error:
        line = str(error)
        if not model.refused:
            return [f"refused: {line}"]
        return [f"the refusal does not say {word}: {line}" for word in model.refused if word not in line]
    if model.refused:
        return ["it is not refused"]
    plant.Finalize()
    context, wrong = plant.CreateDefaultContext(), []
    said = {f"{note.outcome} {note.element}" for note in notes}
    if said != model.notes:
        wrong.append(f"notes: {sorted(said)}, not {sorted(model.notes)}")
    at = positions(rng, model.links)
    names = {joint: model.prefix.get(joint, joint) for joint in at}
    joints = {joint.name(): joint for joint in arm_joints_of(plant, loaded.model)}
    if set(joints) != set(names.values()):
        return [*wrong, f"joints: {sorted(joints)}, not {sorted(names.values())}"]
    coupled = couplings(list(joints), loaded.mimics)
    known = np.array([{names[joint]: value for joint, value in at.items()}[name] for name in joints])
    if len(known) and np.abs(coupled.follow_leaders(known) - known).max() > 1e-9:
        wrong.append("joints do not follow as they should")
    q = plant.GetPositions(context)
    q[[joint.position_start() for joint in joints.values()]] = known
    plant.SetPositions(context, q)
    mass = sum(link.mass for link in model.links) + model.more_mass
    if abs(plant.CalcTotalMass(context) - mass) > 1e-6 * mass:
        wrong.append(f"mass: {plant.CalcTotalMass(context)} kg, not {mass}")
    if plant.num_velocities() and np.linalg.eigvalsh(plant.CalcMassMatrix(context)).min() <= 0:
        wrong.append("the mass matrix is singular")
    for name, X_WL in places(model.links, at, X_WP @ model.base).items():
        found = plant.GetBodyByName(name, loaded.model).EvalPoseInWorld(context)
        if not found.IsNearlyEqualTo(X_WL, 1e-6):
            off = X_WL.inverse() @ found
            wrong.append(f"{name} is off by {off.translation()} m, {off.rotation().ToAngleAxis().angle():.2g} rad")
    return wrong + wrong_shapes(model, scene_graph) + wrong_efforts(model, plant, names)


def arm_joints_of(plant, model):
    """The joints of a model with one position."""
    free = [plant.get_joint(i) for i in plant.GetJointIndices(model)]
    return (
        arm_joints(plant, model)
        if all(j.num_positions() <= 1 for j in free)
        else [j for j in free if j.num_positions() == 1]
    )


def wrong_shapes(model: Model, scene_graph) -> list[str]:
    """Shapes that touch and have another volume."""
    inspector = scene_graph.model_inspector()
    shapes = [inspector.GetShape(shape) for shape in inspector.GetAllGeometryIds(Role.kProximity)]
    if not model.volumes:
        return []
    if len(shapes) != len(model.volumes):
        return [f"{len(shapes)} shapes, not {len(model.volumes)}"]
    found = [CalcVolume(shape) for shape in shapes]
    known = model.volumes
    return [] if np.allclose(found, known, rtol=1e-5) else [f"volumes: {found}, not {known}"]


def wrong_efforts(model: Model, plant, names) -> list[str]:
    """Efforts of an arm that are not those of its file."""
    if not model.is_arm:
        return []
    efforts = {
        plant.get_joint_actuator(i).joint().name(): plant.get_joint_actuator(i).effort_limit()
        for i in plant.GetJointActuatorIndices()
    }
    known = {
        names[link.joint]: link.effort
        for link in model.links
        if link.moves and not link.law and "<limit/>" not in link.in_joint
    }
    wrong = {name: effort for name, effort in known.items() if abs(efforts.get(name, 0.0) - effort) > 1e-6}
    return [f"efforts: {efforts}, not {wrong}"] if wrong else []


@pytest.mark.parametrize("kind", KINDS)
def test_models_of_others(kind: str, tmp_path: Path) -> None:
    wrong = []
    for i in range(NUMBER):
        seed = [FIRST + i, zlib.crc32(kind.encode())]
        model, folder = KINDS[kind](np.random.default_rng(seed)), tmp_path / str(i)
        folder.mkdir()
        if found := faults(model, np.random.default_rng(seed), folder):
            wrong.append(f"seed {seed}: {found}\n{model.content}")
    assert not wrong, f"{len(wrong)} of {NUMBER} models; the first, {wrong[0]}"

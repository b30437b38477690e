"""Recordings as MCAP: signals are read back, what is drawn is where it was, and the layout finds its topics."""

import json

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

pytest.importorskip("mcap", reason="MCAP takes mcap: pip install 'soft-gripper[ros]'")
from mcap.reader import make_reader

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.hardware.table_files import Columns, read_table

TIME = np.array([0.0, 0.01, 0.02])
TURN = Rotation.from_euler("xyz", [0.3, 0.2, -0.4])  # of the base
BASE = np.array([0.1, 0.2, 0.3])
JOINTS = np.array([[0, 0, 0.02], [0, 0, 0.06]])  # of a straight finger 0.08 m long, in B


def recording():
    """A straight finger with readings, an estimated force of 2 N at 0.04 m on its inner side, and a box."""
    X_WB = np.column_stack([TURN.as_matrix(), BASE])
    every = {
        "f.X_WB": (["time", "row", "column"], X_WB),
        "f.joint_positions": (["time", "joint", "xz"], JOINTS[:, ::2]),
        "f.tip_pose": (["time", "pose"], np.array([0.0, 0.08, 0.0])),
        "f.true_joint_positions": (["time", "joint", "xyz"], JOINTS),
        "f.true_tip_position": (["time", "xyz"], np.array([0, 0, 0.08])),
        "f.contact_force": (["time"], np.array(2.0)),
        "f.transverse_force": (["time"], np.array(2.0)),
        "f.contact_arc_length": (["time"], np.array(0.04)),
        "box.pose": (["time", "entry"], np.array([1.0, 0, 0, 0, 0.4, 0.5, 0.6])),
        "f.matrix": (["time", "i", "k"], np.zeros((11, 11))),
    }
    data = {name: (dims, np.repeat(values[None], len(TIME), axis=0)) for name, (dims, values) in every.items()}
    strain = np.arange(12.0).reshape(3, 2, 2)
    strain[1, 0, 1] = np.nan
    data["f.strain"] = (["time", "path", "section"], strain)
    coords = {"time": TIME, "path": ["inner", "outer"], "section": [0, 1], "pose": ["x", "z", "heading"]}
    return Recording(xr.Dataset(data, {**coords, "xyz": ["x", "y", "z"], "joint": [0, 1]}, {"description": "made up"}))


@pytest.fixture
def saved(tmp_path):
    recording().save(tmp_path / "a.mcap")
    return tmp_path / "a.mcap"


def messages(path):
    """Messages by topic; each fits its schema."""
    found, schemas = {}, {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            value = json.loads(message.data)
            assert set(value) == set(json.loads(schema.data)["properties"])
            found.setdefault(channel.topic, []).append(value)
            schemas[channel.topic] = schema.name
    return found, schemas


def test_signals_are_read_back(saved):
    names = [f"/f/strain.value.{path}[{i}]" for path in ("inner", "outer") for i in (0, 1)]
    table = read_table(saved, Columns(dict.fromkeys([*names, "/f/tip_pose.value.z"], "signals"), "/f/strain.timestamp"))
    np.testing.assert_array_equal(table.values[:, 1:5], recording()["f.strain"].values.reshape(3, 4))
    np.testing.assert_array_equal(table.values[:, 5], 0.08)
    np.testing.assert_allclose(table.values[:, 0], TIME, atol=1e-9)


def test_what_is_drawn_is_where_it_was(saved):
    found, schemas = messages(saved)
    assert schemas["/f/tip_in_world"] == schemas["/box/in_world"] == "foxglove.PoseInFrame"
    assert schemas["/f/shape"] == schemas["/f/true_shape"] == "foxglove.SceneUpdate"
    tip, box = (found[f"/{name}"][1] for name in ("f/tip_in_world", "box/in_world"))
    assert tip["frame_id"] == "world"
    np.testing.assert_allclose(list(tip["pose"]["position"].values()), TURN.apply([0, 0, 0.08]) + BASE, atol=1e-12)
    turned = Rotation.from_quat(list(tip["pose"]["orientation"].values()))
    np.testing.assert_allclose((turned * TURN.inv()).magnitude(), 0, atol=1e-9)
    assert list(box["pose"]["position"].values()) == [0.4, 0.5, 0.6]
    expected = TURN.apply([[0, 0, 0], *JOINTS, [0, 0, 0.08]]) + BASE
    for topic in ("/f/shape", "/f/true_shape"):
        ((line,),) = (entity["lines"] for entity in found[topic][2]["entities"])
        np.testing.assert_allclose([list(p.values()) for p in line["points"]], expected, atol=1e-12)


def test_what_is_not_known_is_not_drawn(tmp_path):
    made = recording()
    made.data["f.tip_pose"][0] = np.nan
    made.save(tmp_path / "a.mcap")
    found, _ = messages(tmp_path / "a.mcap")
    assert [len(found[f"/f/{topic}"]) for topic in ("tip_in_world", "shape", "true_shape", "tip_pose")] == [2, 2, 3, 3]
    assert found["/f/tip_pose"][0]["value"] == {"x": None, "z": None, "heading": None}


def test_an_estimate_in_space_is_drawn_there(tmp_path):
    made = recording()
    bent, force = np.array([[0, 0, 0.02], [0, 0.01, 0.06]]), np.array([0.0, 0.3, 0.4])
    data = made.data.drop_vars(["f.contact_force"])
    data["f.estimated_joint_positions"] = (["time", "joint", "xyz"], np.repeat(bent[None], 3, axis=0))
    data["f.estimated_tip_position"] = (["time", "xyz"], np.repeat([[0, 0.02, 0.08]], 3, axis=0))
    data["f.contact_force_vector"] = (["time", "xyz"], np.repeat(force[None], 3, axis=0))
    data["f.contact_side"] = (["time"], np.zeros(3))
    Recording(data).save(tmp_path / "a.mcap")
    (entity,) = messages(tmp_path / "a.mcap")[0]["/f/shape"][1]["entities"]
    expected = TURN.apply([[0, 0, 0], *bent, [0, 0.02, 0.08]]) + BASE
    np.testing.assert_allclose([list(p.values()) for p in entity["lines"][0]["points"]], expected, atol=1e-12)
    (arrow,) = entity["arrows"]
    points = Rotation.from_quat(list(arrow["pose"]["orientation"].values())).apply([1, 0, 0])
    np.testing.assert_allclose(points, TURN.apply(force / 0.5), atol=1e-9)

"""Files that are not text as a source of `live`: their rows are messages."""

import numpy as np
import pytest

from soft_gripper.extras.bench.endpoints import Endpoints
from soft_gripper.extras.hardware.table import Columns

pytest.importorskip("rosbags", reason="bags take rosbags and mcap: pip install 'soft-gripper[ros]'")
from bag_files import NUMBERS, write_ros

TIME = np.arange(5) / 100
COLUMNS = Columns({"/a.data[0]": "readings", "/a.data[1]": "readings"}, "/a.log_time")


@pytest.fixture
def bag(tmp_path):
    return write_ros(tmp_path / "a.bag", {"/a": (TIME, np.column_stack([TIME, 2 * TIME]))}, {"/a": NUMBERS})


def test_rows_of_a_bag_are_messages_by_name(bag):
    with Endpoints("bench.yaml") as endpoints:
        source = endpoints.source(f"file:{bag}", 0.0, COLUMNS)
        found = [source.receive(0.0)[0] for _ in TIME]
        assert source.receive(0.0) == []
    assert source.is_over
    assert [message["/a.data[1]"] for message in found] == [2 * t for t in TIME]
    np.testing.assert_allclose([message["/a.log_time"] for message in found], TIME, atol=1e-9)

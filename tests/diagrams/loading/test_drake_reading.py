"""What Drake complains of becomes one line that names the file and the field."""

import pytest

from soft_gripper.diagrams.loading.drake_reading import drake_reads, of_drake
from soft_gripper.errors import InputError


@pytest.mark.parametrize("error", [RuntimeError("a\nb"), ValueError("a"), IndexError("a"), SystemExit("a")])
def test_what_drake_raises(error: BaseException) -> None:
    with (
        pytest.raises(InputError, match=r"^models\[0\]: file = 'a.urdf': Drake cannot read it: a$"),
        drake_reads("models[0]", "file", "a.urdf"),
    ):
        raise error


def test_what_is_not_drakes() -> None:
    for error in (SystemExit(3), InputError("a.urdf", "box.size", "0", "give a size"), KeyboardInterrupt()):
        with pytest.raises(type(error)) as caught, drake_reads("models[0]", "file", "a.urdf"):
            raise error
        assert caught.value is error


def test_temporary_files_are_named_as_those_they_come_from() -> None:
    assert of_drake("/tmp/soft-gripper-x1_y/o.expanded.urdf:10: error: bad") == "o.urdf:10: error: bad"

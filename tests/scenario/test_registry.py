"""Functions of the users by name, wherever one of the project can stand."""

import sys

import pytest
from pydrake.systems.primitives import ZeroOrderHold
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import estimator_function, find_estimator
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.registry import OWN, blamed_on, label, make_block
from soft_gripper.scenario.sensor_presets import SENSORS
from soft_gripper.sensors.sensor_layout import SensorLayout


def test_functions_of_the_users(monkeypatch, tmp_path):
    """From the current folder too, which is not left on Python's path."""
    (tmp_path / "lab_sensors.py").write_text("def make(layout, period):\n    return period\n")
    monkeypatch.chdir(tmp_path)
    path = list(sys.path)
    assert SENSORS.find("lab_sensors:make")(None, 0.5) == 0.5
    assert sys.path == path
    assert find_estimator("own_blocks:mean_bend").__name__ == "mean_bend"


def test_functions_in_a_file_wherever_it_is(monkeypatch, tmp_path):
    """The file is run once, and two of one name are two modules."""
    for folder, answer in (("one", 1), ("two", 2)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "lab_file.py").write_text(f"def make(layout, period):\n    return {answer}\n")
    monkeypatch.chdir(tmp_path)
    assert [SENSORS.find(f"{folder}/lab_file.py:make")(None, 0.5) for folder in ("one", "two")] == [1, 2]
    assert SENSORS.find("one/lab_file.py:make") is SENSORS.find(f"{tmp_path}/one/lab_file.py:make")
    assert label(f"{tmp_path}/one/lab_file.py:make") == "lab_file:make"
    with refused("sensor.type", "one/nothing.py:make") as caught:
        SENSORS.find("one/nothing.py:make")
    assert "FileNotFoundError" in caught.value.expected


def test_what_is_installed_comes_before_the_current_folder(monkeypatch, tmp_path):
    (tmp_path / "math.py").write_text("def sqrt(x):\n    return 'mine'\n")
    monkeypatch.chdir(tmp_path)
    assert SENSORS.find("math:sqrt")(4.0) == 2.0


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("strane", "did you mean 'strain'? (or give \"module:function\" of your own)"),
        ("camera", 'known: strain, curvature, orientation (or give "module:function" of your own)'),
        ("own_blocks:", "known: strain"),
        ("own_blocks:warm_senser", "module 'own_blocks' has no attribute 'warm_senser'; did you mean 'warm_sensor'?"),
        ("borken_module:make", "did you mean 'broken_module'?"),
        ("nosuch_module:make", "cannot be imported: ModuleNotFoundError: No module named 'nosuch_module'"),
        ("broken_module:make", "cannot be imported: "),
        ("own_blocks:NOT_CALLABLE", "is not callable"),
    ],
)
def test_what_is_not_there(monkeypatch, tmp_path, name, complaint):
    (tmp_path / "broken_module.py").write_text("def make(:\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as caught:
        SENSORS.find(name)
    assert str(caught.value).startswith(f"scenario: sensor.type = {name!r}: ")
    assert complaint in caught.value.expected


def broken(layout, period):
    raise KeyError("nothing")


def leaving(layout, period):
    sys.exit(0)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (broken, "failed: KeyError: 'nothing'"),
        (leaving, r"failed: sys.exit\(0\) was called"),
        (lambda *_: 3, "returned int; return a Drake System"),
        (lambda *_: None, "returned NoneType; return a Drake System"),
    ],
)
def test_a_function_that_fails_is_named(shipped_finger, make, complaint):
    with pytest.raises(InputError, match=complaint) as caught:
        make_block("sensor.type", "own:make", make, SensorLayout(shipped_finger, 3), 0.01)
    assert (caught.value.field, caught.value.value) == ("sensor.type", "own:make")


def test_a_block_is_part_of_one_finger():
    block = ZeroOrderHold(0.1, 1)
    make_block("sensor.type", "own:make", lambda: block)
    with refused("sensor.type", "own:make") as caught:
        make_block("sensor.type", "own:make", lambda: block)
    assert caught.value.value == "own:make"


@pytest.mark.parametrize(("name", "where"), [("own:make", "sensor.type = own:make: own"), ("strain", "own")])
def test_what_a_function_refuses_names_the_function_if_it_is_the_users(name, where):
    def refuse():
        raise InputError("own", "field", 1, "own words")

    with pytest.raises(InputError) as caught:
        make_block("sensor.type", name, refuse)
    assert (caught.value.where, caught.value.field, caught.value.value) == (where, "field", 1)


def test_the_field_is_that_of_the_estimator():
    with refused("estimator.type", "arc"):
        find_estimator("arc")


def test_where_nothing_is_registered_a_function_of_ones_own_is_to_be_given():
    assert OWN.find("math:sqrt", "--measure")(4.0) == 2.0
    with refused("--measure", "sqrt") as caught:
        OWN.find("sqrt", "--measure")
    assert caught.value.expected == 'give "module:function" of your own'


def test_a_failure_of_this_project_is_blamed_on_nobody():
    """It is a bug, whose traceback is wanted."""
    with pytest.raises(KeyError), blamed_on("sensor.type", "strain"):
        raise KeyError("nothing")


@pytest.mark.parametrize("name", ["gausian", "own_blocks:nothing", "own_blocks:mean_bend"])
def test_what_is_no_estimator_of_many_samples_is_refused(name, shipped_finger):
    with pytest.raises(InputError) as error:
        estimator_function(name, SensorLayout(shipped_finger, 2), Uncertainty())
    assert (error.value.field, error.value.value) == ("--estimator", name)

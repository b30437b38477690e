"""What is read of fields from their source."""

from source_comments import field_texts, has_fields

from soft_gripper.estimators.arcs import Arcs
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.schema import FingerChanges, FingerConfig, Scenario, SensorConfig


def text_of(cls, name):
    return next(text for text in field_texts(cls) if text.name == name)


def test_a_comment_behind_the_field():
    period = text_of(SensorConfig, "period")
    assert (period.type, period.default) == ("float", "0.01")
    assert period.values == "s, above 0"
    assert period.comment == "between samples, of the sensors and of every log"


def test_a_comment_above_the_field():
    comment = text_of(Scenario, "external").comment
    assert comment.startswith("Commands that are input ports")
    assert comment.endswith('the pose of the "tool".')
    assert text_of(Scenario, "sensor").comment == ""


def test_defaults_are_what_a_factory_makes():
    assert text_of(Scenario, "gravity").default == "[0.0, 0.0, -9.81]"
    assert text_of(Scenario, "models").default == "[]"
    assert text_of(Scenario, "plant_config").default == "default_plant_config()"
    assert text_of(Finger, "length").default == ""


def test_fields_of_base_classes_come_first():
    names = [text.name for text in field_texts(FingerConfig)]
    assert names[: len(field_texts(FingerChanges))] == [text.name for text in field_texts(FingerChanges)]
    assert names[-1] == "friction"


def test_named_tuples_have_fields_and_other_classes_none():
    assert text_of(Arcs, "theta").comment == "rad, bend of each arc, positive when closing"
    assert has_fields(Arcs)
    assert not has_fields(dict)
    assert not has_fields(Finger.section)

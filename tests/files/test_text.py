"""Text of files: JSON, XML, numbers and names, or a line that says where it is wrong; notes on files."""

import json
import math
import os

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.files.json_text import parse_json, read_json
from soft_gripper.files.notes import LEFT_OUT, MENDED, Note, as_text, collect_notes, note, summarize
from soft_gripper.files.number import changed, number
from soft_gripper.files.text import read_bytes, read_text
from soft_gripper.files.xml_text import check_counts, parse_xml, read_xml
from soft_gripper.files.yaml_text import parse_yaml
from soft_gripper.models import DIRECTORY
from soft_gripper.quantity import is_name
from soft_gripper.scenario.scenario_file import load_scenario


def test_what_cannot_be_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "pointer").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 5\n")
    with (tmp_path / "sparse").open("wb") as file:
        file.truncate(10**12)
    reasons = {
        "pipe": "not a regular file",
        "folder": "not a regular file",
        "loop": "symbolic links",
        "binary": "not a text file",
        "pointer": "is a pointer of Git LFS: git lfs pull",
        "sparse": "size = 1000000000000: give a file of at most 33554432 bytes",
        "/dev/zero": "not a regular file",
        "none": "No such file",
        "x" * 300: "too long",
        "a\0b": "null",
    }
    for name, reason in reasons.items():
        with pytest.raises(InputError, match=reason):
            read_text(tmp_path / name)


def test_file_that_grows_while_it_is_read(tmp_path, monkeypatch):
    """As files of /proc, whose size is 0 whatever they hold."""
    (tmp_path / "a").write_bytes(b"x" * 100)
    monkeypatch.setattr(os, "stat", lambda path: os.stat_result([0o100644, *[0] * 9]))
    with pytest.raises(InputError, match="size = 11: give a file of at most 10 bytes"):
        read_bytes(tmp_path / "a", max_bytes=10)


def test_a_file_that_waits_for_data(tmp_path, monkeypatch):
    """Some of /proc are regular, and a read of them waits; here a pipe is said to be regular."""
    os.mkfifo(tmp_path / "log")
    writer = os.open(tmp_path / "log", os.O_RDWR)
    monkeypatch.setattr(os.path, "isfile", lambda path: True)
    with pytest.raises(InputError, match="it waits for what others write"):
        read_bytes(tmp_path / "log")
    os.close(writer)


WRONG = {
    "{": "cannot be read as JSON",
    "": "cannot be read as JSON",
    "\ufeff1": "cannot be read as JSON",
    '{"a": 1, "a": 2}': "the key 'a' appears more than once",
    '[{"b": {"c": 1, "c": 2}}]': "the key 'c' appears more than once",
    "NaN": "NaN is not a number of JSON",
    "[-Infinity]": "-Infinity is not a number of JSON",
    "9" * 20: "a whole number of 20 digits",
    "9" * 5000: "a whole number of 5000 digits",
    '"\\ud800"': "surrogates not allowed",
    '{"\\udc00": 1}': "surrogates not allowed",
    "[" * 41 + "]" * 41: "depth = 'more than 40'",
    '{"a":' * 41 + "1" + "}" * 41: "depth = 'more than 40'",
    "[" * 100_000: "depth = 'more than 40'",
    '{"a":' * 100_000: "depth = 'more than 40'",
    "," * 1_500_001: "size = 1500001: give no more than 1500000 values",
    "{" + ",".join(f'"{i}":1' for i in range(100_001)) + "}": "an object has more than 100000 keys",
}


@pytest.mark.parametrize("text", WRONG, ids=lambda text: text[:30])
def test_what_is_refused(text):
    with pytest.raises(InputError, match=WRONG[text]) as caught:
        parse_json("a.json", text)
    assert str(caught.value).startswith("a.json: ")
    assert len(str(caught.value)) < 600


def test_what_is_read(tmp_path):
    data = {"a": [1, -2.5, 1e300, "ü", True, None, {}], "n": -(2**63)}
    (tmp_path / "a.json").write_text(json.dumps(data))
    assert read_json(tmp_path / "a.json") == data
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "utf-32"):
        assert parse_json("a.json", json.dumps(data, ensure_ascii=False).encode(encoding)) == data
    brackets = "[" * 40 + '"[[["' + "]" * 40
    assert parse_json("a.json", brackets) == json.loads(brackets)
    assert math.isnan(parse_json("a.json", '{"a": NaN}', finite=False)["a"])


def test_file_that_is_not_read(tmp_path):
    for file in ("/dev/zero", tmp_path / "none.json"):
        with pytest.raises(InputError, match="cannot be read"):
            read_json(tmp_path / file)


ODD = ("1_0", "1\u0663", "infinity", "nan", "0x10", "1e", "", ".", "1 0", "--1", "1,5")


@pytest.mark.parametrize("text", ODD)
def test_what_is_not_decimal_is_refused(text):
    with pytest.raises(ValueError, match="not a number"):
        number(text)


@pytest.mark.parametrize("text", ["1_0", "0x10", "010", "1:30", "1.5_0", "-0b1"])
def test_yaml_has_decimal_numbers_alone(text):
    with refused("number", text):
        parse_yaml("a.yaml", f"a: {text}")
    assert parse_yaml("a.yaml", f"a: '{text}'") == {"a": text}


@pytest.mark.parametrize(
    ("text", "expected"),
    [("3", 3.0), ("-3e-2", -0.03), (" .5 ", 0.5), ("+10 %", 2.2), ("-2.5%", 1.95), (" +0 % ", 2.0)],
)
def test_a_percentage_is_added_to_the_number_before_which_a_number_replaces(text, expected):
    assert changed(text, 2.0) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["", "%", "10 %", ".1 %", "+3", "+1 % %", "+1 % 2", "3 mm", "nan", "1e999", "+1e999 %"]
)
def test_text_without_a_number_or_the_sign_of_a_change_is_refused(text):
    with pytest.raises(ValueError, match="number"):
        changed(text, 2.0)


BOMB = """<!DOCTYPE a [<!ENTITY x "xxxxxxxxxx"><!ENTITY y "&x;&x;&x;&x;&x;&x;&x;&x;&x;&x;">
<!ENTITY z "&y;&y;&y;&y;&y;&y;&y;&y;&y;&y;">]><a b="&z;"/>"""
OUTSIDE = '<!DOCTYPE a [<!ENTITY x SYSTEM "secret.txt">]><a>&x;</a>'


@pytest.mark.parametrize("text", [BOMB, OUTSIDE, "<!DOCTYPE a><a/>", '<!DOCTYPE a SYSTEM "a.dtd"><a/>'])
def test_a_doctype_is_refused(text):
    with refused("DOCTYPE", "a"):
        parse_xml("a.urdf", text)


@pytest.mark.parametrize("text", ["<a>", "", "<a>&x;</a>", "<a b='1' b='2'/>", "a\udc80b"])
def test_what_is_not_well_formed(text):
    with refused("file", "a.urdf"):
        parse_xml("a.urdf", text)


def test_nesting_ends_somewhere():
    parse_xml("a.urdf", "<a>" * 100 + "</a>" * 100)
    with refused("element", "b"):
        parse_xml("a.urdf", "<b>" * 100_000 + "</b>" * 100_000)


def test_elements_and_comments_are_kept(tmp_path):
    (tmp_path / "a.urdf").write_text('<?xml version="1.0"?>\n<a><!-- why --><b c="1"/></a>')
    root = read_xml(tmp_path / "a.urdf")
    assert [child.tag if isinstance(child.tag, str) else child.text for child in root] == [" why ", "b"]


def test_a_file_of_very_many_elements_is_refused():
    with refused("element", "l"):
        parse_xml("big.urdf", f"<robot>{60_000 * '<l/>'}</robot>")


def test_many_prefixes_are_declared():
    with refused("prefix", "p0"):
        parse_xml("a.urdf", f"<a>{''.join(f'<p{i}:x/>' for i in range(20_000))}</a>")


NAME = 5_000 * "n"


@pytest.mark.parametrize(
    ("text", "field", "value"),
    [
        (f"<a name='{NAME}'/>", "a.name", NAME),
        (f"<a model='{5_000 * '1 '}'/>", "a.model", 5_000 * "1 "),
        (f"<a {NAME}='1'/>", f"a.{NAME}", NAME),
        (f"<{NAME}/>", NAME, NAME),
    ],
)
def test_names_have_a_length(text, field, value):
    with refused(field, value):
        parse_xml("a.urdf", text)


def test_texts_have_a_length():
    with refused("file", "a.urdf"):
        parse_xml("a.urdf", f"<a>{9_000_000 * ' '}</a>")


def test_elements_have_few_attributes():
    with refused("attributes of <a>", 300):
        parse_xml("a.urdf", "<a " + " ".join(f"a{i}='1'" for i in range(300)) + "/>")


@pytest.mark.parametrize(("tag", "most"), [("link", 500), ("body", 500), ("joint", 1500), ("geom", 2500)])
def test_models_have_a_size(tag, most):
    check_counts("a.xml", parse_xml("a.xml", f"<m>{most * f'<{tag}/>'}</m>"))
    with refused(f"<{tag}>", most + 1):
        check_counts("a.xml", parse_xml("a.xml", f"<m>{(most + 1) * f'<{tag}/>'}</m>"))


def test_links_have_some_shapes():
    link = f"<link name='l'><visual/>{501 * '<collision/>'}</link>"
    with refused("shapes", 501):
        check_counts("a.urdf", parse_xml("a.urdf", f"<robot>{link}</robot>"))


@pytest.mark.parametrize("name", ["a.b", "δ", "plant", "logs", "scene_graph", "true_contact", "grip", "all"])
def test_fingers(tmp_path, name):
    """Refused when the station is built, not after the run."""
    file = tmp_path / "hand.urdf"
    file.write_text((DIRECTORY / "grippers" / "two_finger.urdf").read_text().replace("left_finger", name))
    with refused("finger.name" if is_name(name) else "name", name):
        make_station(load_scenario("box_grasp", [f"models.0.file={file}"]))


def test_notes_are_collected_once_and_logged_at_the_end(caplog) -> None:
    with collect_notes() as outer:
        with collect_notes() as inner:
            for joint in ("a", "b", "a"):
                note(LEFT_OUT, "arms/arm.urdf", f"joint '{joint}': dynamics.friction", 0.5, "Drake has none")
        note(MENDED, "arms/arm.urdf", "link 'x': inertia", "", "it was impossible")
        assert not caplog.messages
    assert [each.element for each in inner] == ["joint 'a': dynamics.friction", "joint 'b': dynamics.friction"]
    assert [each.outcome for each in outer] == [LEFT_OUT, LEFT_OUT, MENDED]
    assert caplog.messages == [
        "arm.urdf: left out joint 'a': dynamics.friction = 0.5, joint 'b': dynamics.friction = 0.5: Drake has none",
        "arm.urdf: mended link 'x': inertia: it was impossible",
    ]


def test_notes_are_short_and_stay_in_a_line() -> None:
    many = [Note(LEFT_OUT, "a.urdf", f"joint '{i}'", "", "why") for i in range(9)]
    assert summarize(many) == ["a.urdf: left out joint '0', joint '1', joint '2' and 6 more: why"]
    with collect_notes() as notes:
        note(MENDED, "a.urdf", "x\ny", "1\n" * 1000, "why")
    assert as_text(notes).count("\n") == 0
    assert len(as_text(notes)) < 200

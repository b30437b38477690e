"""YAML text gives plain data, or one line that says why not."""

import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.files.yaml_text import parse_yaml, read_yaml

WRONG = {
    "arm: {1: 2}": "arm = 1: give text as the key",
    "2001-01-01: 3": "give text as the key",
    "? \n: 3": "None: give text as the key",
    "a: {yes: 3}": "a = True: give text as the key",
    "[1, 2]: 3": "is not YAML",
    "a: [1": "is not YAML",
    "a: 1\n---\nb: 2": "is not YAML",
    "%TAG ! tag:x.org,2000:\n---\na: !foo {b: 2}": "a = 'tag:x.org,2000:foo': no such tag here",
    "a: !Foo {b: 2}": "a = '!Foo': no such tag here",
    "a: !!python/object:os.system {b: 2}": "no such tag here",
    "a: !foo 2": "is not YAML",
    "a: !!set {b}": "a = {'b'}: give text",
    "a: 2001-01-01": "a = .*: give text, in quotes",
    "a: 2001-99-99": "holds what is no value",
    f"a: {'9' * 5000}": "holds what is no value",
    f"a: 1{':1' * 2000}.0": "give a decimal number",
    f"a: {2**63}": "give a whole number below 9223372036854775808",
    f"a: {'x' * 50_001}": "length = 50001: give no more than 50000 characters of a value",
    f"{'x ' * 25_001}: 1": "length = 50001",
    f"a: {'#' * 300_000}": "length = 300003: give no more than 300000 characters",
    'b: ["x\\0y"]': r"b\[0\] = .*: leave out control characters",
    "a: 1\nb: 2\na: 3": "key = 'a': appears more than once",
    "a: {b: {c: 1, c: 2}}": "key = 'c': appears more than once",
    "a: &x [*x]": "alias = 'x': stands inside",
    f"a: {'[' * 3000}{']' * 3000}": "depth = 41",
    f"a: {'{b: ' * 3000}1{'}' * 3000}": "depth = 41",
}


@pytest.mark.parametrize("text", WRONG, ids=lambda text: text[:30])
def test_what_is_no_plain_data(text: str) -> None:
    with pytest.raises(InputError, match=WRONG[text]) as caught:
        parse_yaml("a.yaml", text)
    assert str(caught.value).startswith("a.yaml: ")
    assert len(str(caught.value)) < 600


def test_merges_that_multiply_are_counted() -> None:
    lines = ["_a: &a {k: 1}"]
    lines += [f"_{new}: &{new} {{<<: [{', '.join([f'*{old}'] * 99)}]}}" for old, new in zip("abc", "bcd", strict=True)]
    with refused("size"):
        parse_yaml("a.yaml", "\n".join(lines))


def test_plain_data_templates_and_poses() -> None:
    text = "_base: &base {b: 1}\na: {<<: *base, c: [x, 2.5, true, null]}\nd: !Rpy {deg: [0, 0, 1]}\ne: *base"
    found = {"a": {"b": 1, "c": ["x", 2.5, True, None]}, "d": {"_tag": "!Rpy", "deg": [0, 0, 1]}, "e": {"b": 1}}
    assert parse_yaml("a.yaml", text) == found
    assert parse_yaml("a.yaml", "- 1") == [1]
    assert parse_yaml("a.yaml", "") is None


def test_file_is_named(tmp_path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("a: [1")
    with refused("file", "a.yaml"):
        read_yaml(file)

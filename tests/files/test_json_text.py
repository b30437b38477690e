"""JSON text gives plain data, or one line that says why not."""

import json
import math

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.json_text import parse_json, read_json

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

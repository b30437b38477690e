"""What arrives at a live session from strangers: messages of a device, frames of a page, commands and descriptions."""

import json
from typing import Any

import numpy as np
import yaml
from hostile import NUMBERS, WORDS, documents, texts
from hypothesis import strategies as st
from live_process import BENCH, LIVE, NAMES, line

FIELDS = ["n", *NAMES]
SCENARIO = LIVE[1]
CHANGES = LIVE[3::2]
_MOST = 20  # messages of a stream
_RAW = (b"", b"\0", b"\n", b"{}", b"[]", b"null", b'"x"', b"[" * 50_000, b"x" * 70_000, b"\xff\xfe", b'{"n": 1', b",,,")
_COUNTS = (0, 1, 2, 3, 7, -1, 1.5, 400, 2**53 - 1, 2**53, 2**64, None)


def _values(count: Any) -> dict[str, Any]:
    return {"n": count} | dict.fromkeys(NAMES, 0.001) | {"pa": 10.0, "pb": 10.0}


def _as_json(found: Any) -> bytes:
    return json.dumps(found, default=str, skipkeys=True).encode("utf-8", "surrogateescape")


def _as_text(found: str) -> bytes:
    return found.encode("utf-8", "surrogateescape")


def _packed(numbers: list[float]) -> bytes:
    return np.array(numbers, dtype="<f8").tobytes()


_BITS = st.lists(st.floats(width=64), min_size=len(FIELDS), max_size=len(FIELDS)).map(_packed)
HOSTILE: dict[str, st.SearchStrategy[bytes]] = {  # messages, by format
    "json": st.one_of(
        documents(_values(3)).map(_as_json),
        texts(json.dumps(_values(3))).map(_as_text),
        st.sampled_from(_COUNTS).map(lambda count: _as_json(_values(count))),
    ),
    "text": st.one_of(
        texts(line(3).strip()).map(_as_text),
        st.sampled_from(_COUNTS).map(lambda count: _as_text(line(count).strip())),
        st.lists(st.sampled_from(NUMBERS), min_size=1, max_size=12).map(lambda each: _as_text(",".join(each))),
    ),
    "float64": st.one_of(_BITS, st.binary(max_size=8 * len(FIELDS))),
}
_FINE = {
    "json": lambda i: _as_json(_values(i)),
    "text": lambda i: _as_text(line(i).strip()),
    "float64": lambda i: _packed([*map(float, _values(i).values())]),
}


def streams(form: str) -> st.SearchStrategy[list[bytes]]:
    """Messages of a format, some of which are as described; these are numbered one after the other."""
    hostile = st.one_of(HOSTILE[form], HOSTILE[form], st.sampled_from(_RAW), st.binary(max_size=300))
    each = st.lists(st.one_of(st.none(), hostile), max_size=_MOST)
    return each.map(lambda found: [_FINE[form](i) if own is None else own for i, own in enumerate(found)])


def objects() -> st.SearchStrategy[list[Any]]:
    """What a user's generator may yield."""
    return st.lists(st.one_of(documents(_values(3)), documents(_values(5)["pa"]), st.text()), max_size=_MOST)


def frames() -> st.SearchStrategy[list[str | bytes]]:
    """What a browser, or who passes for one, sends to the page."""
    button = st.sampled_from(("zero", "record", "stop", "open", "x")).map(lambda name: {"press": name})
    known = st.sampled_from(({"press": "record"}, {"signals": ["left_finger.tip_pose"]}, {"signals": []}, {"set": {}}))
    changed = documents({"press": "record", "signals": ["left_finger.tip_pose"], "set": [0, 1.0]})
    as_text = st.one_of(button, known, changed).map(lambda found: _as_json(found).decode("utf-8", "replace"))
    broken = st.one_of(texts('{"signals": ["left_finger.tip_pose"]}'), st.sampled_from(("[" * 4000, "\0", "{}", "NaN")))
    return st.lists(st.one_of(as_text, as_text, broken, st.binary(max_size=100)), max_size=12)


_UDP = "udp://:0", "udp://", "udp://127.0.0.1:99999", "udp://nowhere.invalid:5005", "udp://[::1", "udp://:x", "udp:"
_SERIAL = "serial:///dev/null", "serial:///nowhere", "serial:///dev/null?baud=x", "serial://"
_FILES = "readings.csv", "", "nowhere.csv", "folder", "bench.yaml", "a.nc", "/dev/zero", "/dev/null"
_OTHERS = "os:getcwd", "os:system", "nowhere:x", "stdio:", "stdio", "://", "http://localhost", ""
_ADDRESSES = *_UDP, *_SERIAL, *(f"file:{name}" for name in _FILES), *_OTHERS
_SECONDS = "0.2"
_BASE = [*LIVE, "--bench", "bench.yaml", "--seconds", _SECONDS]


def commands() -> st.SearchStrategy[tuple[dict[str, bytes], list[str]]]:
    """Files, and `live` commands that read them."""
    bench = BENCH.format(source="file:readings.csv", sink="udp://127.0.0.1:9")
    readings = "".join(line(i) for i in range(30))
    addresses = st.sampled_from((*_ADDRESSES, *(word for word in WORDS if len(word) < 1000)))
    ends = st.sampled_from(("--source", "--sink"))
    by_address = st.tuples(ends, addresses).map(lambda each: (bench, readings, [*_BASE, f"{each[0]}={each[1]}"]))
    by_option = st.tuples(
        st.sampled_from(("--zero", "--out", "--mcap", "--seconds", "--host", "--bench", "--set")),
        st.sampled_from((*NUMBERS, *WORDS, "file", "folder", "bench.yaml", "x.mcap")),
    ).map(lambda each: (bench, readings, [*_BASE, "--fast", f"{each[0]}={each[1]}"]))
    by_bench = st.one_of(texts(bench), documents(_plain(bench)).map(_dumped)).map(
        lambda text: (text, readings, [*_BASE, "--fast"])
    )
    by_readings = texts(readings).map(lambda text: (bench, text, [*_BASE, "--fast", "--out", "folder/out"]))
    found = st.one_of(by_address, by_option, by_bench, by_readings)
    return found.map(lambda each: ({"bench.yaml": _as_text(each[0]), "readings.csv": _as_text(each[1])}, each[2]))


def _plain(text: str) -> Any:
    return yaml.safe_load(text)


def _dumped(found: Any) -> str:
    return yaml.dump(found, allow_unicode=True)

"""netCDF files with every kind of damage, the same from the same seed."""

import gzip
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

# What may stand where a number is expected.
NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-308, 5e-324, -0.0, -1.0)


def damaged_bytes(content: bytes, seed: int) -> bytes:
    """The content with bits flipped, or a part cut, overwritten, doubled or inserted, once or a few times."""
    rng = np.random.default_rng(seed)
    for _ in range(rng.integers(1, 4)):
        begin = int(rng.integers(0, len(content) + 1))
        begin = begin if rng.integers(2) else min(begin, 400)  # headers are in front
        length = int(rng.choice([1, 1, 2, 4, 8, 100]))
        part = content[begin : begin + length]
        between = [
            lambda part=part: bytes(byte ^ (1 << int(rng.integers(8))) for byte in part),
            lambda: b"",
            lambda part=part: 2 * part,
            lambda length=length: rng.bytes(length),
            lambda part=part: bytes(len(part)),
            lambda part=part: len(part) * b"\xff",
        ][rng.integers(6)]()
        content = content[:begin] + between + content[begin + length :]
        if rng.integers(4) == 0:
            content = content[: int(rng.integers(0, len(content) + 1))]
    return content


_OF_A_SIGNAL: dict[str, Callable[[Any], Any]] = {
    "one axis more": lambda signal: signal.expand_dims("more", axis=-1),
    "one axis less": lambda signal: signal[..., 0],
    "one number": lambda signal: signal.mean(),
    "transposed": lambda signal: signal.transpose(*reversed(signal.dims)),
    "whole numbers": lambda signal: signal.fillna(0).astype("i4"),
    "text": lambda signal: signal.astype("S3"),
}


def damaged_recordings(data: Any, signals: list[str], seed: int) -> Iterator[tuple[str, bytes]]:
    """Damaged files of a recording, an xarray Dataset of which `signals` are read: what was done, and the content."""
    for changed in (_with_other_time(data), _with_other_scenario(data)):
        for how, found in changed:
            yield how, _netcdf(found)
    yield from damaged_arrays(data, signals, seed)


def damaged_arrays(data: Any, names: list[str], seed: int) -> Iterator[tuple[str, bytes]]:
    """Damaged files of an xarray Dataset of which these arrays are read: what was done, and the content."""
    for name in names:
        for how, found in _with_other_signal(data, name):
            yield how, _netcdf(found)
    yield from _damaged_netcdf(_netcdf(data), seed)


def _netcdf(data: Any) -> bytes:
    return bytes(data.to_netcdf(engine="scipy"))


def _with_other_signal(data: Any, name: str) -> Iterator[tuple[str, Any]]:
    yield f"without {name}", data.drop_vars(name)
    for how, change in _OF_A_SIGNAL.items():
        if data[name].ndim > 1 or how != "one axis less":
            yield f"{name}: {how}", data.drop_vars(name).assign({name: change(data[name])})
    for number in NUMBERS:
        spoilt = data[name].copy(deep=True)
        spoilt.values[len(spoilt) // 2] = number
        yield f"{name}: {number}", data.drop_vars(name).assign({name: spoilt})


def _with_other_time(data: Any) -> Iterator[tuple[str, Any]]:
    time, late = data["time"].values, np.arange(data.sizes["time"]) > data.sizes["time"] // 2
    for how, times in {
        "backwards": time[::-1],
        "at a stand": 0 * time,
        "a gap": time + 1e9 * late,
        "not from 0 on": time + 5.0,
        "NaN": np.where(late, np.nan, time),
        "slow": 1e3 * time,
        "huge": 1e308 * np.sign(time),
        "dates": time.astype(int).astype("M8[D]"),
    }.items():
        yield f"time: {how}", data.assign_coords(time=("time", times))
    yield "without time", data.drop_vars("time")
    for how, samples in {"no samples": 0, "one sample": 1, "half of the samples": len(time) // 2}.items():
        yield how, data.isel(time=slice(0, samples))


_SCENARIOS = {
    "empty": "",
    "a number": 1.5,
    "no mapping": "[1, 2]",
    "not YAML": "a: [",
    "of nothing": "models: []",
    "in Latin": b"models: \xe9",
    "another": "models: [{name: a, file: none.urdf}]",
}


def _with_other_scenario(data: Any) -> Iterator[tuple[str, Any]]:
    for how, text in _SCENARIOS.items():
        yield f"scenario: {how}", data.assign_attrs(scenario=text)
    yield "without a scenario", data.drop_attrs()


def _damaged_netcdf(content: bytes, seed: int) -> Iterator[tuple[str, bytes]]:
    yield "nothing", b""
    yield "text", b"time,strain\n0,1\n"
    yield "HDF5", b"\x89HDF\r\n\x1a\n" + bytes(1000)
    yield "gzip", gzip.compress(content)
    yield "netCDF 5", b"CDF\x05" + content[4:]
    for length in (3, 4, 8, 12, 100, 1000, len(content) // 2, len(content) - 1):
        yield f"{length} bytes of it", content[:length]
    for place in range(4, 120, 4):  # numbers of the header: of samples, lengths of axes, kinds, counts
        for number in (b"\x7f\xff\xff\xff", b"\0\0\0\0"):
            yield f"{number.hex()} at {place}", content[:place] + number + content[place + 4 :]
    for i in range(60):
        yield f"bytes {i}", damaged_bytes(content, seed + i)

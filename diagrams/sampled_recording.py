"""SampledRecording: the recording of a run, whose signals are computed and labelled when they are read."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Labels, Recording, Samples

_TIME, _SECONDS = "time", {"units": "s"}


class _LazyValues(BackendArray):
    """The values of a signal, computed when they are read; xarray asks for them, and keeps them."""

    dtype = np.dtype(float)

    def __init__(self, samples: Samples, name: str, shape: tuple[int, ...]):
        self.shape, self._samples, self._name = shape, samples, name

    @property
    def cached(self) -> Any:
        """An array of xarray that computes them once, and can be written to."""
        lazy: Any = indexing.LazilyIndexedArray(self)
        written_to = indexing.CopyOnWriteArray(lazy)
        return indexing.MemoryCachedArray(written_to)  # type: ignore[no-untyped-call]

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Array:
        values = self._samples[self._name].reshape(self.shape)
        found: Array = indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, values.__getitem__
        )
        return found

    def __reduce__(self) -> Any:
        """A copy, in another process too, has the values."""
        return indexing.NumpyIndexingAdapter, (self._samples[self._name].reshape(self.shape),)


class SampledRecording(Recording):
    """The recording of a run: a signal is labelled when it is read, and all are when the dataset is."""

    def __init__(self, labels: Mapping[str, Labels], samples: Samples, about: Mapping[str, str]):
        own = {"_labels": labels, "_samples": samples, "_about": about, "_read": dict[str, xr.DataArray]()}
        self.__dict__.update(own)  # its class is frozen
        self._read[_TIME] = xr.DataArray(samples.time, {_TIME: self._time}, [_TIME], name=_TIME, attrs=_SECONDS)

    _labels: Mapping[str, Labels]
    _samples: Samples
    _about: Mapping[str, str]
    _read: dict[str, xr.DataArray]

    @cached_property
    def data(self) -> xr.Dataset:
        """All signals."""
        variables, coords = {}, {_TIME: self._time}
        for name, labels in self._labels.items():
            variables[name] = self._read[name].variable if name in self._read else self._variable(name)
            coords |= labels.coords
        found = xr.Dataset(variables, coords, dict(self._about))
        for name in ("_labels", "_samples", "_about", "_read"):  # once the dataset is loaded, nothing keeps the blocks
            del self.__dict__[name]
        return found

    @property
    def signals(self) -> list[str]:
        """See Recording."""
        return super().signals if "data" in self.__dict__ else list(self._labels)

    def __contains__(self, signal: str) -> bool:
        if "data" in self.__dict__:
            return signal in self.data
        return (
            signal in self._labels
            or signal in self._read
            or any(signal in each.coords for each in self._labels.values())
        )

    def __getitem__(self, signal: str) -> xr.DataArray:
        if "data" in self.__dict__ or not (signal in self._labels or signal in self._read):
            return super().__getitem__(signal)
        if signal not in self._read:
            own, time = self._labels[signal].indexed, self._read[_TIME]
            coords, indexes = {**time.coords.variables, **own.variables}, {**time.xindexes, **own.xindexes}
            # What is known to fit is not checked again, which takes a third of the time to judge a short run.
            self._read[signal] = xr.DataArray(
                self._variable(signal), coords, None, signal, None, indexes, fastpath=True
            )
        return self._read[signal]

    def values(self, signal: str) -> Array:
        """See Recording; a sweep that judges short runs spends a tenth of that time on labels."""
        if "data" in self.__dict__ or signal in self._read or signal not in self._labels:
            return super().values(signal)
        return self._samples[signal].reshape(self._shape(signal))

    def __reduce__(self) -> Any:
        return Recording, (self.data,)

    @property
    def _time(self) -> tuple[str, Array, Mapping[str, str]]:
        return _TIME, self._samples.time, _SECONDS

    def _shape(self, name: str) -> tuple[int, ...]:
        return len(self._samples.time), *map(len, self._labels[name].axes.values())

    def _variable(self, name: str) -> xr.Variable:
        labels, samples, shape = self._labels[name], self._samples, self._shape(name)
        values = samples[name].reshape(shape) if samples.is_logged(name) else _LazyValues(samples, name, shape).cached
        return xr.Variable([_TIME, *labels.axes], values, labels.attributes)

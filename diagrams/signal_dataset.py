"""The signals of a run as a dataset of xarray, whose values are computed when they are read."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from soft_gripper.arrays import Array
from soft_gripper.diagrams.signal_labels import Labels
from soft_gripper.diagrams.signal_sources import Samples

_TIME_AXIS = "time"
_TIME_ATTRIBUTES = {"units": "s"}


def signal_dataset(labels: Labels, samples: Samples, about: Mapping[str, str] | None = None) -> xr.Dataset:
    """The labelled samples of signals; `about` are the attributes."""
    variables = {
        name: xr.Variable([_TIME_AXIS, *axes], _values(samples, name, labels.shape(name)), labels.attributes[name])
        for name, axes in labels.axes.items()
    }
    time = xr.Variable(_TIME_AXIS, samples.time, _TIME_ATTRIBUTES)
    indexes = {_TIME_AXIS: xr.indexes.PandasIndex(time, _TIME_AXIS), **labels.coords.xindexes}
    coords = xr.Coordinates({_TIME_AXIS: time, **labels.coords.variables}, indexes)
    return xr.Dataset(variables, coords, about)


def _values(samples: Samples, name: str, shape: tuple[int, ...]) -> Any:
    """Logged values of a signal with this shape at a sample, or an array that computes them."""
    shape = len(samples.time), *shape
    return samples[name].reshape(shape) if samples.is_logged(name) else _LazySignal(samples, name, shape).cached_array


class _LazySignal(BackendArray):
    """The values of a signal, computed when they are read; xarray asks for them, and keeps them."""

    dtype = np.dtype(float)

    def __init__(self, samples: Samples, name: str, shape: tuple[int, ...]):
        self.shape, self._samples, self._name = shape, samples, name

    @property
    def cached_array(self) -> Any:
        """An array of xarray that computes them once, and can be written to."""
        lazy: Any = indexing.LazilyIndexedArray(self)
        written_to = indexing.CopyOnWriteArray(lazy)
        return indexing.MemoryCachedArray(written_to)  # type: ignore[no-untyped-call]

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Array:
        values = self._samples[self._name].reshape(self.shape)
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, values.__getitem__)

    def __reduce__(self) -> Any:
        """A copy, in another process too, has the values."""
        return indexing.NumpyIndexingAdapter, (self._samples[self._name].reshape(self.shape),)

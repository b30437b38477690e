"""User measures of a run.

A measure of your own is a function of a station and its recording. It returns one value, a number, a boolean or a
string, for the column named after the function:

    def peak_bend_deg(station: Station, recording: Recording) -> float
"""

from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.registry import OWN, blamed_on

OPTION = "--measure"


def column_of(name: str) -> str:
    """The column of a user measure, "module:function"."""
    return name.rpartition(":")[2]


def columns_of(names: Sequence[str]) -> list[str]:
    """The columns of user measures.

    Raises:
        InputError: if one cannot be imported.
    """
    for name in names:
        OWN.find(name, OPTION, "sweep")
    return [column_of(name) for name in names]


def own_measures(names: Sequence[str], station: Station, recording: Recording) -> dict[str, Any]:
    """The values of user measures of a run, by column.

    Raises:
        InputError: if a measure fails, or does not return a single value.
    """
    return {column_of(name): _own_measure(name, station, recording) for name in names}


def _own_measure(name: str, station: Station, recording: Recording) -> Any:
    function = OWN.find(name, OPTION, "sweep")
    with blamed_on(OPTION, name, "sweep"):
        result = function(station, recording)
    value = result.item() if isinstance(result, np.generic | np.ndarray) and result.size == 1 else result
    if not isinstance(value, Real | str):
        raise InputError("sweep", OPTION, name, f"returned {type(result).__name__}; return a number or a string")
    return value

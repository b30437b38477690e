"""Converts times of day and dates of loggers, as texts, to seconds; `elapsed_seconds` has a case for each form."""

import re
import warnings
from collections.abc import Sequence

import numpy as np
import pandas as pd

from soft_gripper.arrays import Array

_DAY_SECONDS = 86400.0  # s
_MAX_SAMPLED_CELLS = 20  # cells
_MAX_TIME_LENGTH = 64  # characters of a time
_TIME_OF_DAY = re.compile(r"\d{1,9}:\d\d:\d\d(?:[.,]\d+)?", re.ASCII)
_MINUTES_PATTERN = re.compile(r"\d{1,9}:\d\d[.,]\d+", re.ASCII)


def is_clock(cells: Sequence[str]) -> bool:
    """Whether texts are times of day, with or without a date."""
    sampled_cells = [cell for cell in cells if cell.strip()][:_MAX_SAMPLED_CELLS]
    return 2 * sum(":" in cell for cell in sampled_cells) > len(sampled_cells)


def elapsed_seconds(cells: Sequence[str]) -> tuple[Array, int]:
    """Seconds since the first time, (T,), NaN where a text is not a time; number of midnights passed without a date.

    Dates with slashes have the month first, and those with points the day, unless that cannot be.
    """
    plain_cells = (cell.strip().replace(",", ".") for cell in cells)
    texts = pd.Series([text if len(text) <= _MAX_TIME_LENGTH else "" for text in plain_cells])
    first_time = next((text for text in texts if ":" in text), "")
    if _MINUTES_PATTERN.fullmatch(first_time) or _TIME_OF_DAY.fullmatch(first_time):
        full_times = texts if _TIME_OF_DAY.fullmatch(first_time) else "00:" + texts
        seconds = pd.to_timedelta(full_times, errors="coerce").dt.total_seconds().to_numpy(dtype=float)
        return _unwrap_midnights(seconds)
    dates = pd.to_datetime(texts, format="ISO8601", utc=True, errors="coerce")
    if dates.isna().mean() > 0.5:
        day_first = "." in first_time.split(" ")[0]
        sampled_texts = texts[texts.str.contains(":")][:_MAX_SAMPLED_CELLS]  # other forms take long to read
        if _parse_dates(sampled_texts, day_first).notna().any():
            dates = _parse_dates(texts, day_first)
    seconds = (dates - dates.dropna().iloc[0]).dt.total_seconds().to_numpy(dtype=float) if dates.notna().any() else None
    return (np.full(len(texts), np.nan), 0) if seconds is None else (seconds, 0)


def _parse_dates(texts: "pd.Series[str]", day_first: bool) -> "pd.Series[pd.Timestamp]":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # on which of day and month comes first
        return pd.to_datetime(texts, dayfirst=day_first, utc=True, errors="coerce")


def _unwrap_midnights(seconds: Array) -> tuple[Array, int]:
    is_finite = np.isfinite(seconds)
    passes_midnight = np.diff(seconds[is_finite], prepend=seconds[is_finite][:1]) < -_DAY_SECONDS / 2
    elapsed = np.full(seconds.shape, np.nan)
    elapsed[is_finite] = seconds[is_finite] - seconds[is_finite][:1] + _DAY_SECONDS * np.cumsum(passes_midnight)
    return elapsed, int(passes_midnight.sum())

"""Times of day and dates, as loggers write them -> seconds."""

import re
import warnings
from collections.abc import Sequence

import numpy as np
import pandas as pd

from soft_gripper.arrays import Array

_DAY = 86400.0  # s
_LOOKED_AT = 20  # cells
_LONGEST = 64  # characters of a time
_OF_DAY = re.compile(r"\d{1,9}:\d\d:\d\d(?:[.,]\d+)?", re.ASCII)
_MINUTES = re.compile(r"\d{1,9}:\d\d[.,]\d+", re.ASCII)


def is_clock(cells: Sequence[str]) -> bool:
    """Whether texts are times of day, or dates with them."""
    seen = [cell for cell in cells if cell.strip()][:_LOOKED_AT]
    return 2 * sum(":" in cell for cell in seen) > len(seen)


def seconds_of(cells: Sequence[str]) -> tuple[Array, int]:
    """Seconds since the first, (T,), NaN where a text is not a time; and the number of midnights passed without a date.

    Dates with slashes have the month first, and those with points the day, unless that cannot be.
    """
    stripped = (cell.strip().replace(",", ".") for cell in cells)
    texts = pd.Series([text if len(text) <= _LONGEST else "" for text in stripped])
    first = next((text for text in texts if ":" in text), "")
    if _MINUTES.fullmatch(first) or _OF_DAY.fullmatch(first):
        whole = texts if _OF_DAY.fullmatch(first) else "00:" + texts
        seconds = pd.to_timedelta(whole, errors="coerce").dt.total_seconds().to_numpy(dtype=float)
        return _past_midnight(seconds)
    dates = pd.to_datetime(texts, format="ISO8601", utc=True, errors="coerce")
    if dates.isna().mean() > 0.5:
        day_first = "." in first.split(" ")[0]
        looked_at = texts[texts.str.contains(":")][:_LOOKED_AT]  # other forms take long to read
        if _in_other_forms(looked_at, day_first).notna().any():
            dates = _in_other_forms(texts, day_first)
    seconds = (dates - dates.dropna().iloc[0]).dt.total_seconds().to_numpy(dtype=float) if dates.notna().any() else None
    return (np.full(len(texts), np.nan), 0) if seconds is None else (seconds, 0)


def _in_other_forms(texts: "pd.Series[str]", day_first: bool) -> "pd.Series[pd.Timestamp]":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # on which of day and month comes first
        return pd.to_datetime(texts, dayfirst=day_first, utc=True, errors="coerce")


def _past_midnight(seconds: Array) -> tuple[Array, int]:
    seen = np.isfinite(seconds)
    fell = np.diff(seconds[seen], prepend=seconds[seen][:1]) < -_DAY / 2
    since = np.full(seconds.shape, np.nan)
    since[seen] = seconds[seen] - seconds[seen][:1] + _DAY * np.cumsum(fell)
    return since, int(fell.sum())

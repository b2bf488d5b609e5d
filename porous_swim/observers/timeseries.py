"""What all swimmers do together, over time, as a table. Lengths in a, times in a/U."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.observers.base import CONTACT, FREE, Every, Frame
from porous_swim.results import TIMESERIES_SCHEMA, TableInfo


class TimeSeries:
    """A row per frame; columns of `TIMESERIES_SCHEMA`."""

    def __init__(self, schedule: Every) -> None:
        self.schedule = schedule
        self._start: np.ndarray | None = None  # (n_swimmers, 3)
        self._rows: list[dict[str, float | int]] = []

    def observe(self, frame: Frame) -> None:
        """Take in one frame; displacements count from the first."""
        if self._start is None:
            self._start = frame.position.copy()
        value, standard_error = mean_squared_displacement(frame.position - self._start)
        self._rows.append(
            {
                "time": frame.time,
                "fraction_bound": float(np.mean(frame.state != FREE)),
                "fraction_contact": float(np.mean(frame.state == CONTACT)),
                "n_captures": frame.counts.n_captures,
                "n_escapes": frame.counts.n_escapes,
                "n_hops": frame.counts.n_hops,
                "n_returns": frame.counts.n_returns,
                "msd": value,
                "msd_standard_error": standard_error,
            }
        )

    def finish(self, *, interrupted: bool) -> None:
        """Nothing is open: rows are kept in memory, 80 bytes a frame."""

    def table(self, info: TableInfo) -> pa.Table:
        """All rows so far, with `info` attached."""
        return info.attach(pa.Table.from_pylist(self._rows, schema=TIMESERIES_SCHEMA))


def mean_squared_displacement(displacement: np.ndarray) -> tuple[float, float]:
    """Mean square of `displacement`, (n_swimmers, 3), and its standard error: NaN for a single swimmer."""
    # swimmers never interact: their displacements are independent samples
    squared = np.sum(displacement**2, axis=1)
    standard_error = np.std(squared, ddof=1) / np.sqrt(len(squared)) if len(squared) > 1 else np.nan
    return float(np.mean(squared)), float(standard_error)

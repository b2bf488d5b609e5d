"""What all swimmers do together, over time, as a table. Lengths in a, times in a/U."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa

from porous_swim.core.state import State
from porous_swim.observers.base import Frame, Observer, Schedule
from porous_swim.results.tables import TIMESERIES_SCHEMA, TableInfo


class TimeSeries(Observer):
    """A row per frame; columns of `TIMESERIES_SCHEMA`."""

    def __init__(self, schedule: Schedule) -> None:
        self.schedule = schedule
        self._rows: list[dict[str, float | int | None]] = []

    def observe(self, frame: Frame) -> None:
        """Take in one frame."""
        everyone = frame.ensemble
        self._rows.append(
            {
                "time": frame.time,
                "fraction_bound": everyone.fraction_bound,
                "fraction_contact": everyone.fraction_contact,
                "n_captures": frame.counts.n_captures,
                "n_escapes": frame.counts.n_escapes,
                "n_hops": frame.counts.n_hops,
                "n_returns": frame.counts.n_returns,
                "msd": everyone.msd,
                "msd_standard_error": None if everyone.n_swimmers == 1 else everyone.msd_standard_error,
            }
        )

    def state(self) -> dict[str, np.ndarray]:
        """The columns so far; they are kept in memory, 80 bytes a frame. NaN where a value is unknown."""
        return {
            name: np.array([math.nan if row[name] is None else row[name] for row in self._rows])
            for name in TIMESERIES_SCHEMA.names
        }

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run."""
        columns = [[None if value != value else value for value in column.tolist()] for column in state.values()]
        self._rows = [dict(zip(state, row, strict=True)) for row in zip(*columns, strict=True)]

    def table(self, info: TableInfo) -> pa.Table:
        """All rows so far, with `info` attached."""
        return info.attach(pa.Table.from_pylist(self._rows, schema=TIMESERIES_SCHEMA))

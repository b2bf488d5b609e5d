"""What all swimmers do together, over time, as a table. Lengths in a, times in a/U."""

from __future__ import annotations

import pyarrow as pa

from porous_swim.observers.base import Every, Frame
from porous_swim.results.tables import TIMESERIES_SCHEMA, TableInfo


class TimeSeries:
    """A row per frame; columns of `TIMESERIES_SCHEMA`."""

    def __init__(self, schedule: Every) -> None:
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

    def finish(self, *, interrupted: bool) -> None:
        """Nothing is open: rows are kept in memory, 80 bytes a frame."""

    def table(self, info: TableInfo) -> pa.Table:
        """All rows so far, with `info` attached."""
        return info.attach(pa.Table.from_pylist(self._rows, schema=TIMESERIES_SCHEMA))

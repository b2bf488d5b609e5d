"""The encounters of a run: rows of the device's log become columns of the encounter table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from porous_swim.core.state import State
from porous_swim.engine.kernel.device_log import CLOCKS, LogInt, LogLong, log_columns
from porous_swim.engine.spill import Spill, row_type
from porous_swim.obstacles.field import ObstacleField
from porous_swim.results.encounter_columns import COLUMNS, AtRelease, Record

# the column that says what a number of steps lacks
CLOCK = {step: name for name, step in CLOCKS.items()} | {
    LogLong.END: "end_clock", LogLong.N_CONTACT: "contact_clock"
}  # fmt: skip


# (swimmers, heights, sines of the pitch, radii), all (m,) -> which of these are in the contact band, (m,) bool
InContact = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


class Records:
    """Collects log rows in any order; the table does not depend on the order. With a `path` most wait on disk.

    `in_contact` is for rows that were summed at the ends of steps: what they lack to the mean of both ends of each step
    is half of what the entry has, less half of what the exit has. Left out, sums are integrals over time already.
    """

    def __init__(
        self, field: ObstacleField, time_step: float, n_swimmers: int, path: Path | None = None, *,
        in_contact: InContact | None = None,
    ) -> None:  # fmt: skip
        self._field, self._time_step, self._in_contact = field, time_step, in_contact
        self._columns = log_columns(field.dimensions)
        self._store = Spill(n_swimmers, path)

    def add(self, real: np.ndarray, integer: np.ndarray, long: np.ndarray) -> np.ndarray:
        """Take rows of the log; return them as one array of `row_type`."""
        rows = self._rows(real, integer, long)
        self._store.add(rows)
        return rows

    def parts(self, *under_way: np.ndarray) -> Iterator[dict[str, np.ndarray]]:
        """Columns of the encounter table in parts of whole swimmers, at least one, sorted by swimmer, then start time.

        `under_way` are rows, as in `add`, of encounters that have not ended. Times in a/U, lengths in a.
        """
        for rows in self._store.parts(self._rows(*under_way, censored=True)):
            yield self._table(rows)

    def state(self) -> dict[str, np.ndarray]:
        """The rows so far."""
        return self._store.state()

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run: see `Spill.restore`."""
        self._store.restore(state)

    def close(self) -> None:
        """Forget what lies on disk."""
        self._store.close()

    def _rows(self, real: np.ndarray, integer: np.ndarray, long: np.ndarray, *, censored: bool = False) -> np.ndarray:
        rows = np.empty(len(real), row_type(self._field.dimensions, real.dtype))
        rows["real"], rows["int"], rows["long"], rows["censored"] = real, integer, long, censored
        return rows

    def _clocked(self, real: np.ndarray, long: np.ndarray, which: LogLong) -> np.ndarray:
        """Times in steps, as real numbers."""
        return long[:, which] + real[:, getattr(self._columns, CLOCK[which])]

    def _table(self, rows: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
        c = self._columns
        # field by field: numpy 2.4 writes beyond its memory where it joins arrays of different structures
        real = np.concatenate([part["real"] for part in rows], dtype=np.float64)
        integer, long, censored = (
            np.concatenate([part[name] for part in rows]) for name in ("int", "long", "censored")
        )
        late = long[:, LogLong.END] < 0
        passages = integer[late], long[late], real[late]
        kept = np.flatnonzero(~late)
        keys = real[kept, c.start_clock], long[kept, LogLong.START], integer[kept, LogInt.SWIMMER]
        order = kept[np.lexsort(keys)]
        real, integer, long, censored = real[order], integer[order], long[order], censored[order]
        self._pass_late(integer, long, real, *passages)
        steps = {step: self._clocked(real, long, step) for step in LogLong}
        time = {step: np.where(long[:, step] >= 0, steps[step] * self._time_step, np.nan) for step in LogLong}
        n_steps = steps[LogLong.END] - steps[LogLong.START]
        center = self._field.centers[integer[:, LogInt.COLLOID]] + integer[:, LogInt.IMAGE :] * self._field.box
        entry, entry_height = self._end("entry", real, integer[:, LogInt.COLLOID], center)
        exit_, exit_height = self._end("exit", real, integer[:, LogInt.COLLOID], center)
        height, contact = real[:, c.height], time[LogLong.N_CONTACT]
        if self._in_contact is not None:
            height = height + 0.5 * (entry_height - exit_height)
            contact = contact - 0.5 * self._time_step * self._stays(integer, exit_height, exit_["exit_pitch"], censored)
        released = np.where(long[:, LogLong.RELEASE] >= 0, 1.0, np.nan)
        # before the first step of an encounter has been booked its mean height is that of its entry
        mean = np.where(n_steps > 0, height / np.where(n_steps > 0, n_steps, 1), real[:, c.min_height])
        made = dict(
            swimmer=integer[:, LogInt.SWIMMER], colloid=integer[:, LogInt.COLLOID],
            start_time=time[LogLong.START], end_time=time[LogLong.END],
            start_censored=np.zeros(len(long), bool), end_censored=censored,
            contact_time=contact, release_time=time[LogLong.RELEASE],
            release_pitch=np.arcsin(np.clip(real[:, c.release_sine], -1, 1)) * released,
            escape_pitch_time=time[LogLong.PITCH], mean_height=mean,
        )  # fmt: skip
        for axis, name in enumerate("xyz"):
            made[f"image_{name}"] = integer[:, LogInt.IMAGE + axis]
        recorded = {
            column.name: self._recorded(column.source, real, released)
            for column in COLUMNS
            if isinstance(column.source, Record)
        }
        return dict(**recorded, **made, **entry, **exit_)  # no name twice

    def _recorded(self, record: Record, real: np.ndarray, released: np.ndarray) -> np.ndarray:
        """What the kernel kept, (n,), NaN where there is no value; `released` (n,) is 1, NaN without a release."""
        if self._field.dimensions not in record.dimensions:
            return np.full(len(real), np.nan)
        values = real[:, getattr(self._columns, record.row)]
        if np.isinf(record.start):  # a least or a greatest value before the first step
            values = np.where(values == record.start, np.nan, values)
        return np.asarray(values * released if isinstance(record, AtRelease) else values)

    def _stays(self, integer: np.ndarray, height: np.ndarray, pitch: np.ndarray, censored: np.ndarray) -> np.ndarray:
        """Which encounters, (n,) bool, are cut off in contact; one that has ended is out of it."""
        assert self._in_contact is not None
        stays, who = np.zeros(len(integer), bool), np.flatnonzero(censored)
        radius = self._field.radii[integer[who, LogInt.COLLOID]]
        stays[who] = self._in_contact(integer[who, LogInt.SWIMMER], height[who], np.sin(pitch[who]), radius)
        return stays

    def _end(
        self, end: str, real: np.ndarray, colloid: np.ndarray, center: np.ndarray
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """Columns of position, director and pitch at the `entry` or the `exit`, and the height there."""
        d = self._field.dimensions
        x, e = np.zeros_like(center), np.zeros_like(center)
        first_x, first_e = getattr(self._columns, f"{end}_x"), getattr(self._columns, f"{end}_e")
        x[:, :d], e[:, :d] = real[:, first_x : first_x + d], real[:, first_e : first_e + d]
        x, e = self._field.from_device(x, colloid), self._field.from_device(e, colloid)
        height, sine = self._field.stance(x, e, colloid)
        pitch = np.arcsin(np.clip(sine, -1.0, 1.0))
        names = [f"{end}_{name}" for name in "xyz"] + [f"{end}_e{name}" for name in "xyz"] + [f"{end}_pitch"]
        return dict(zip(names, [*(center + x).T, *e.T, pitch], strict=True)), height

    def _pass_late(
        self, integer: np.ndarray, long: np.ndarray, real: np.ndarray,
        late_integer: np.ndarray, late_long: np.ndarray, late_real: np.ndarray,
    ) -> None:  # fmt: skip
        """Give encounters the escape pitch that was passed after their end."""
        if len(late_long) == 0:
            return
        lacking = np.flatnonzero(long[:, LogLong.PITCH] < 0)
        swimmer = np.concatenate([integer[lacking, LogInt.SWIMMER], late_integer[:, LogInt.SWIMMER]])
        start = np.concatenate([long[lacking, LogLong.START], late_long[:, LogLong.START]])
        order = np.lexsort((start, swimmer))  # a late passage stands behind its encounter: that came first
        passed = np.flatnonzero(order >= len(lacking))
        rows, late_rows = lacking[order[passed - 1]], order[passed] - len(lacking)
        long[rows, LogLong.PITCH] = late_long[late_rows, LogLong.PITCH]
        real[rows, self._columns.pitch_clock] = late_real[late_rows, self._columns.pitch_clock]

"""The encounters of a run: rows of the device's log become columns of the encounter table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from porous_swim.engine.log import LogInt, LogLong, log_columns
from porous_swim.obstacles.field import ObstacleField

CLOCK = {  # the column that says what a number of steps lacks
    LogLong.START: "start_clock", LogLong.END: "end_clock", LogLong.RELEASE: "release_clock",
    LogLong.PITCH: "pitch_clock", LogLong.N_CONTACT: "contact_clock",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class News:
    """What happened since the last look."""

    residence: np.ndarray  # (n,) a/U, of the encounters that ended
    winding: np.ndarray  # (n,) turns, of the same
    hop_time: np.ndarray  # (m,) a/U, of the flights that ended on another colloid than they began
    hops: np.ndarray  # (m, 2, 4) int32, of the same: colloid and image, that left and that entered

    @classmethod
    def joined(cls, parts: Sequence[News]) -> News:
        """All the news of `parts`, in their order."""
        nothing = cls(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, 2, 4), np.int32))
        names = [item.name for item in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in (nothing, *parts)]) for name in names))


class Records:
    """Collects log rows in any order; the table does not depend on the order."""

    def __init__(self, field: ObstacleField, time_step: float, n_swimmers: int) -> None:
        self._field, self._time_step = field, time_step
        self._columns = log_columns(field.dimensions)
        self._real: list[np.ndarray] = []
        self._int: list[np.ndarray] = []
        self._long: list[np.ndarray] = []
        self._censored: list[np.ndarray] = []
        self._late: list[np.ndarray] = []  # (n, 3): swimmer, start, step of the escape pitch
        self._late_clock: list[np.ndarray] = []  # (n,) what that step lacks
        # of each swimmer's latest encounter, in steps; NaN where it was under way when it was seen
        self._last_start, self._last_end = np.full(n_swimmers, -1.0), np.zeros(n_swimmers)
        self._last_host = np.zeros((n_swimmers, 4), np.int32)  # its colloid and image

    def add(self, real: np.ndarray, integer: np.ndarray, long: np.ndarray, *, censored: bool = False) -> News:
        """Take rows of the log; `censored` are those of encounters still under way."""
        late = long[:, LogLong.END] < 0
        self._late.append(
            np.stack([integer[late, LogInt.SWIMMER], long[late, LogLong.START], long[late, LogLong.PITCH]], axis=1)
        )
        self._late_clock.append(np.array(real[late, self._columns.pitch_clock], float))
        keep = np.flatnonzero(~late)
        keep = keep[np.lexsort((long[keep, LogLong.START], integer[keep, LogInt.SWIMMER]))]
        real, integer, long = real[keep], integer[keep], long[keep]
        for store, rows in ((self._real, real), (self._int, integer), (self._long, long)):
            store.append(np.array(rows))
        self._censored.append(np.full(len(keep), censored))
        start, end = self._clocked(real, long, LogLong.START), self._clocked(real, long, LogLong.END)
        residence = (end - start) * self._time_step
        who, host = integer[:, LogInt.SWIMMER], integer[:, LogInt.COLLOID :]
        return News(residence, real[:, self._columns.winding].astype(float), *self._hops(who, host, start, end))

    def under_way(self, who: np.ndarray, host: np.ndarray, start: np.ndarray) -> News:
        """Note encounters under way: swimmers `who` (n,) with `host` (n, 4) since `start` (n,), in steps."""
        new, nothing = start > self._last_start[who], np.zeros(0)
        return News(nothing, nothing, *self._hops(who[new], host[new], start[new], np.full(np.sum(new), np.nan)))

    def _clocked(self, real: np.ndarray, long: np.ndarray, which: LogLong) -> np.ndarray:
        """Times in steps, as real numbers."""
        return long[:, which] + real[:, getattr(self._columns, CLOCK[which])].astype(float)

    def _hops(
        self, who: np.ndarray, host: np.ndarray, start: np.ndarray, end: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Flight times and pairs of colloids of the hops into encounters, sorted by swimmer and time, not yet noted."""
        if len(who) == 0:
            return np.zeros(0), np.zeros((0, 2, 4), np.int32)
        fresh = start > self._last_start[who]  # the others were seen under way
        first = np.r_[True, who[1:] != who[:-1]]
        before = np.where(first, self._last_end[who], np.r_[0.0, end[:-1]])
        host_before = np.where(first[:, None], self._last_host[who], np.r_[host[:1], host[:-1]])
        known = ~first | (self._last_start[who] >= 0.0)
        last = np.r_[first[1:], True]
        for store, values in ((self._last_start, start), (self._last_end, end), (self._last_host, host)):
            store[who[last]] = values[last]
        hopped = fresh & known & np.any(host != host_before, axis=1)
        return (start - before)[hopped] * self._time_step, np.stack([host_before, host], axis=1)[hopped]

    def columns(self) -> dict[str, np.ndarray]:
        """The encounter table's columns, sorted by start time, then swimmer. Times in a/U, lengths in a."""
        c, d = self._columns, self._field.dimensions
        real = np.concatenate(self._real or [np.zeros((0, c.n_real))]).astype(np.float64)
        integer = np.concatenate(self._int or [np.zeros((0, 5), np.int32)])
        long = np.concatenate(self._long or [np.zeros((0, len(LogLong)), np.int64)])
        censored = np.concatenate(self._censored or [np.zeros(0, bool)])
        self._pass_late(integer, long, real)
        order = np.lexsort((integer[:, LogInt.SWIMMER], real[:, c.start_clock], long[:, LogLong.START]))
        real, integer, long, censored = real[order], integer[order], long[order], censored[order]
        steps = {step: self._clocked(real, long, step) for step in LogLong}
        time = {step: np.where(long[:, step] >= 0, steps[step] * self._time_step, np.nan) for step in LogLong}
        n_steps = steps[LogLong.END] - steps[LogLong.START]
        center = self._field.centers[integer[:, LogInt.COLLOID]] + integer[:, LogInt.IMAGE :] * self._field.box
        released = np.where(long[:, LogLong.RELEASE] >= 0, 1.0, np.nan)
        # before the first step of an encounter has been booked its mean height is that of its entry
        mean = np.where(n_steps > 0, real[:, c.height] / np.where(n_steps > 0, n_steps, 1), real[:, c.min_height])
        columns = dict(
            swimmer=integer[:, LogInt.SWIMMER], colloid=integer[:, LogInt.COLLOID],
            start_time=time[LogLong.START], end_time=time[LogLong.END],
            start_censored=np.zeros(len(long), bool), end_censored=censored,
            contact_time=time[LogLong.N_CONTACT], wall_push=real[:, c.push],
            winding=real[:, c.winding], signed_winding=real[:, c.signed] if d == 2 else np.full(len(long), np.nan),
            release_time=time[LogLong.RELEASE],
            release_pitch=np.arcsin(np.clip(real[:, c.release_sine], -1, 1)) * released,
            release_winding=real[:, c.release_winding] * released, escape_pitch_time=time[LogLong.PITCH],
            min_height=real[:, c.min_height], mean_height=mean, max_height=real[:, c.max_height],
        )  # fmt: skip
        for axis, name in enumerate("xyz"):
            columns[f"image_{name}"] = integer[:, LogInt.IMAGE + axis]
        for end in ("entry", "exit"):
            columns |= self._end(end, real, integer[:, LogInt.COLLOID], center)
        return columns

    def _end(self, end: str, real: np.ndarray, colloid: np.ndarray, center: np.ndarray) -> dict[str, np.ndarray]:
        """Position, director and pitch at the `entry` or the `exit`."""
        d = self._field.dimensions
        x, e = np.zeros_like(center), np.zeros_like(center)
        first_x, first_e = getattr(self._columns, f"{end}_x"), getattr(self._columns, f"{end}_e")
        x[:, :d], e[:, :d] = real[:, first_x : first_x + d], real[:, first_e : first_e + d]
        x, e = self._field.from_device(x), self._field.from_device(e)
        _, sine = self._field.stance(x, e, colloid)
        pitch = np.arcsin(np.clip(sine, -1.0, 1.0))
        names = [f"{end}_{name}" for name in "xyz"] + [f"{end}_e{name}" for name in "xyz"] + [f"{end}_pitch"]
        return dict(zip(names, [*(center + x).T, *e.T, pitch], strict=True))

    def _pass_late(self, integer: np.ndarray, long: np.ndarray, real: np.ndarray) -> None:
        """Give encounters the escape pitch that was passed after their end."""
        late = np.concatenate(self._late or [np.zeros((0, 3), np.int64)])
        if len(late) == 0:
            return
        lacking = np.flatnonzero(long[:, LogLong.PITCH] < 0)
        swimmer = np.concatenate([integer[lacking, LogInt.SWIMMER], late[:, 0]])
        start = np.concatenate([long[lacking, LogLong.START], late[:, 1]])
        order = np.lexsort((start, swimmer))  # a late passage stands behind its encounter: that came first
        passed = np.flatnonzero(order >= len(lacking))
        rows, late_rows = lacking[order[passed - 1]], order[passed] - len(lacking)
        long[rows, LogLong.PITCH] = late[late_rows, 2]
        real[rows, self._columns.pitch_clock] = np.concatenate(self._late_clock)[late_rows]

"""What happened between two looks at a run: encounters that ended, hops that were made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from porous_swim.core.state import State, fitting
from porous_swim.engine.kernel.device_log import LogInt, LogLong, log_columns


@dataclass(frozen=True, eq=False)
class RecentEvents:
    """What happened since the last look."""

    residence: np.ndarray  # (n,) a/U, of the encounters that ended
    winding: np.ndarray  # (n,) turns, of the same
    hop_time: np.ndarray  # (m,) a/U, of the flights that ended on another colloid than they began
    hops: np.ndarray  # (m, 2, 4) int32, of the same: colloid and image, that left and that entered

    @classmethod
    def joined(cls, parts: Sequence[RecentEvents]) -> RecentEvents:
        """All the news of `parts`, in their order."""
        nothing = cls(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, 2, 4), np.int32))
        names = [item.name for item in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in (nothing, *parts)]) for name in names))


class EventsDesk:
    """Makes news of rows of the log, which come in any order between swimmers, in order of time for each."""

    def __init__(self, dimensions: int, time_step: float, n_swimmers: int) -> None:
        self._columns, self._time_step = log_columns(dimensions), time_step
        self._waiting: list[RecentEvents] = []
        # of each swimmer's latest encounter, in steps; NaN where it was under way when it was seen
        self._last_start, self._last_end = np.full(n_swimmers, -1.0), np.zeros(n_swimmers)
        self._last_host = np.zeros((n_swimmers, 4), np.int32)  # its colloid and image

    def note(self, rows: np.ndarray) -> None:
        """Take rows of the log of encounters that ended."""
        rows = rows[rows["long"][:, LogLong.END] >= 0]  # the others bring late passages
        rows = rows[np.lexsort((rows["long"][:, LogLong.START], rows["int"][:, LogInt.SWIMMER]))]
        real, who = rows["real"], rows["int"][:, LogInt.SWIMMER]
        start = rows["long"][:, LogLong.START] + real[:, self._columns.start_clock].astype(float)
        end = rows["long"][:, LogLong.END] + real[:, self._columns.end_clock].astype(float)
        residence, winding = (end - start) * self._time_step, real[:, self._columns.winding].astype(float)
        hops = self._hops(who, rows["int"][:, LogInt.COLLOID :], start, end)
        self._waiting.append(RecentEvents(residence, winding, *hops))

    def take(self, who: np.ndarray, host: np.ndarray, start: np.ndarray) -> RecentEvents:
        """All news since the last call.

        With the encounters under way: swimmers `who` (n,) with `host` (n, 4) since `start` (n,), in steps.
        """
        new, nothing = start > self._last_start[who], np.zeros(0)
        end = np.full(np.count_nonzero(new), np.nan)
        latest = RecentEvents(nothing, nothing, *self._hops(who[new], host[new], start[new], end))
        news, self._waiting = RecentEvents.joined([*self._waiting, latest]), []
        return news

    def state(self) -> dict[str, np.ndarray]:
        """What waits to be told, and the latest encounter of each swimmer."""
        return vars(RecentEvents.joined(self._waiting)) | {
            "last_start": self._last_start, "last_end": self._last_end, "last_host": self._last_host
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run."""
        last = (fitting(state, f"last_{name}", getattr(self, f"_last_{name}")) for name in ("start", "end", "host"))
        self._last_start, self._last_end, self._last_host = (array.copy() for array in last)
        self._waiting = [RecentEvents(*(state[item.name].copy() for item in fields(RecentEvents)))]

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

"""Where swimmers hop: how often from each colloid to each other one, drawn over the colloids.

The image of the colloid entered counts relative to that of the colloid left: a line is as long as its hops.
"""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.core.state import State
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.palette import HOP_SHADES
from porous_swim.observers.rerun.pictures import Pictures
from porous_swim.observers.rerun.stream import RecordingFile
from porous_swim.obstacles.field import ObstacleField

MAX_LINES = 2000  # the busiest: more cannot be told apart, and make the recording large
_WIDTHS = 0.75, 4.0  # points of the screen, of the rarest and of the busiest line


class HopCounts:
    """How many hops led from one colloid to another, by colloid and by the image entered relative to that left."""

    def __init__(self) -> None:
        self._pairs = np.zeros((0, 5), dtype=np.int32)
        self._counts = np.zeros(0, dtype=np.int64)
        self._waiting: list[np.ndarray] = []

    def add(self, hops: np.ndarray) -> None:
        """Count hops, (n, 2, 4) as in a `Frame`."""
        if len(hops):
            image = hops[:, 1, 1:] - hops[:, 0, 1:]
            self._waiting.append(np.column_stack([hops[:, :, 0], image]))

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs (m, 5): colloid left, colloid entered, its relative image; and their counts (m,)."""
        if self._waiting:
            rows = np.concatenate([self._pairs, *self._waiting])
            weights = np.concatenate([self._counts, np.ones(len(rows) - len(self._counts), dtype=np.int64)])
            # as np.unique along an axis, which compares rows byte by byte and takes several times as long
            order = np.lexsort(rows.T[::-1])
            rows = rows[order]
            first = np.flatnonzero(np.r_[True, np.any(rows[1:] != rows[:-1], axis=1)])
            self._pairs, self._counts = rows[first], np.add.reduceat(weights[order], first)
            self._waiting = []
        return self._pairs, self._counts

    def state(self) -> dict[str, np.ndarray]:
        """Pairs and counts."""
        pairs, counts = self.table()
        return {"pairs": pairs, "counts": counts}

    def restore(self, state: State) -> None:
        """Go on from the `state` of other counts."""
        self._pairs, self._counts, self._waiting = state["pairs"].copy(), state["counts"].copy(), []


class HopTrack(Pictures):
    """The network as it grows: half a line for each direction, from the centre of the colloid that was left."""

    def __init__(self, file: RecordingFile, field: ObstacleField, *, n_frames: int, duration: float) -> None:
        super().__init__(n_frames=n_frames)
        self._file, self._field, self._duration = file, field, duration
        self._counts = HopCounts()

    def count(self, frame: Frame) -> None:
        """Count the hops since the events before."""
        self._counts.add(frame.hops)

    def state(self) -> dict[str, np.ndarray]:
        """All that was counted."""
        return {**super().state(), **self._counts.state()}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        super().restore(state)
        self._counts.restore(state)

    def draw(self, *, step: int, time: float) -> None:
        """Log the network as it stands."""
        pairs, counts = self._counts.table()
        if not len(counts):
            return
        order = np.argsort(counts, kind="stable")[-MAX_LINES:]  # the busiest last, on top
        left, entered, hops = pairs[order, 0], pairs[order, 1], counts[order]
        start = self._field.centers[left]
        end = self._field.centers[entered] + pairs[order, 2:] * self._field.box
        # lines grow in width and shade over the run, to the full of both for the busiest at its end
        share = np.sqrt(hops / hops[-1] * min(1.0, time / self._duration))
        lines = rr.LineStrips3D(
            np.stack([start, 0.5 * (start + end)], axis=1).astype(np.float32),
            radii=-np.interp(share, [0.0, 1.0], _WIDTHS) / 2.0,
            colors=_shades(share),
        )
        table = rr.AnyValues(hops=hops, left=left, entered=entered)
        self._file.log_at("world/hops", lines, table, step=step, time=time)
        self._file.log_at("network", rr.TextDocument(_caption(counts, len(order)), media_type="text/markdown"),
                          step=step, time=time)  # fmt: skip


def _shades(share: np.ndarray) -> np.ndarray:
    stops = np.linspace(0.0, 1.0, len(HOP_SHADES))
    return np.column_stack([np.interp(share, stops, channel) for channel in np.transpose(HOP_SHADES)]).astype(np.uint8)


def _caption(counts: np.ndarray, n_drawn: int) -> str:
    drawn = "all are drawn" if n_drawn == len(counts) else f"the {n_drawn:,} busiest are drawn"
    return (
        f"**{counts.sum():,} hops** so far, along {len(counts):,} directed pairs of colloids; {drawn}. "
        f"The busiest pair has {counts.max():,}.\n\n"
        "Each half of a line shows the hops that leave the colloid at its end: the wider and brighter, the more. "
        "Lines across the border of a periodic box are cut in the middle."
    )

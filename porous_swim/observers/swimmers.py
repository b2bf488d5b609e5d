"""Swimmers in a recording: where all recorded ones are, and those that are looked at more closely.

Positions in a, wrapped into the periodic box; rows wait here until they fill a call to Rerun.
"""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.observers.base import Frame
from porous_swim.observers.lanes import LaneTrack
from porous_swim.observers.stream import Moments, RecordingFile
from porous_swim.observers.trails import TrailTrack, wrapped

_BATCH_BYTES = 2 << 20  # raw, in a call: larger gains nothing, smaller pays a kilobyte of schema too often
_ROW_BYTES = 14  # a position in single precision and a state


class SwimmerTrack:
    """The recorded `swimmers`; `trails`, a subset of them; the one `followed`, or none. Ids as in the frames."""

    def __init__(
        self, file: RecordingFile, *, swimmers: np.ndarray, trails: np.ndarray, followed: int | None,
        box: np.ndarray, radius: float,
    ) -> None:  # fmt: skip
        self._file, self._swimmers, self._box = file, swimmers, box
        self._moments = Moments()  # of the rows that wait
        self._positions: list[np.ndarray] = []
        self._states: list[np.ndarray] = []
        self._lanes = LaneTrack(file, trails)
        shown = {"tracked": trails, "followed": np.array([] if followed is None else [followed], dtype=np.int64)}
        self._trails = [
            TrailTrack(file, f"world/{name}", swimmers=ids, box=box, radius=radius)
            for name, ids in shown.items()
            if len(ids)
        ]
        file.log("world/swimmers", rr.Points3D.from_fields(radii=[radius], show_labels=False))

    def observe(self, frame: Frame) -> None:
        """Take in one frame; send the batch when it is full."""
        self._moments.add(frame)
        self._positions.append(frame.position[self._swimmers])
        self._states.append(frame.state[self._swimmers])
        self._lanes.observe(frame)
        for trails in self._trails:
            trails.observe(frame)
        if len(self._moments) * max(1, len(self._swimmers)) * _ROW_BYTES >= _BATCH_BYTES:
            self.finish()

    def finish(self) -> None:
        """Send the rows that wait."""
        if not len(self._moments):
            return
        if len(self._swimmers):
            positions = wrapped(np.concatenate(self._positions), self._box)
            states = np.concatenate(self._states).astype(np.uint16)
            points = rr.Points3D.columns(positions=positions, class_ids=states)
            self._file.send(
                "world/swimmers", points.partition([len(self._swimmers)] * len(self._moments)), self._moments
            )
        for trails in self._trails:
            trails.send(self._moments)
        self._lanes.send()
        self._moments, self._positions, self._states = Moments(), [], []
        self._file.flush()

"""Swimmers in a recording: where all recorded ones are, and those that are looked at more closely.

Positions in a, wrapped into the periodic box; rows wait here until they fill a call to Rerun.
"""

from __future__ import annotations

import numpy as np

from porous_swim.core.state import State, restore_parts, state_of
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.bodies import Body
from porous_swim.observers.rerun.lanes import LaneTrack
from porous_swim.observers.rerun.stream import Moments, RecordingFile
from porous_swim.observers.rerun.trails import TrailTrack, wrapped

_BATCH_BYTES = 2 << 20  # raw, in a call: larger gains nothing, smaller pays a kilobyte of schema too often
_ROW_BYTES = 14  # a position in single precision and a state


class SwimmerTrack:
    """The recorded `swimmers`; `trails`, a subset of them; the one `followed`, or none. Ids as in the frames."""

    def __init__(
        self, file: RecordingFile, *, swimmers: np.ndarray, trails: np.ndarray, followed: int | None,
        box: np.ndarray, body: Body,
    ) -> None:  # fmt: skip
        self._file, self._swimmers, self._box, self._body = file, swimmers, box, body
        self._moments = Moments()  # of the rows that wait
        self._rows: dict[str, list[np.ndarray]] = {"position": [], "director": [], "state": []}
        self._lanes = LaneTrack(file, trails)
        shown = {"tracked": trails, "followed": np.array([] if followed is None else [followed], dtype=np.int64)}
        self._trails = {
            name: TrailTrack(file, f"world/{name}", swimmers=ids, box=box, body=body)
            for name, ids in shown.items()
            if len(ids)
        }
        file.log("world/swimmers", body.style(len(swimmers)))

    def observe(self, frame: Frame) -> None:
        """Take in one frame; send the batch when it is full."""
        self._moments.add(frame)
        for name, rows in self._rows.items():
            rows.append(getattr(frame, name)[self._swimmers])
        self._lanes.observe(frame)
        for trails in self._trails.values():
            trails.observe(frame)
        if len(self._moments) * max(1, len(self._swimmers)) * _ROW_BYTES >= _BATCH_BYTES:
            self.finish()

    def finish(self) -> None:
        """Send the rows that wait."""
        if not len(self._moments):
            return
        if len(self._swimmers):
            position, director, state = (np.concatenate(rows) for rows in self._rows.values())
            n = len(self._swimmers)
            bodies = self._body.columns(wrapped(position, self._box), director, state, n)
            self._file.send("world/swimmers", bodies.partition([n] * len(self._moments)), self._moments)
        for trails in self._trails.values():
            trails.send(self._moments)
        self._lanes.send()
        self._moments, self._rows = Moments(), {name: [] for name in self._rows}
        self._file.flush()

    def state(self) -> dict[str, np.ndarray]:
        """Of lanes and trails; what waits is to be sent first."""
        return {**self._lanes.state(), **state_of(self._trails)}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        self._lanes.restore(state)
        restore_parts(self._trails, state)

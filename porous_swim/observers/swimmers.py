"""Swimmers in a recording: where they are, where the tracked ones point and came from.

Positions in a, wrapped into the periodic box; rows wait here until they fill a call to Rerun.
"""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.observers.base import Frame
from porous_swim.observers.palette import DIRECTOR, STATE_COLORS, STATE_NAMES
from porous_swim.observers.stream import RecordingFile

_BATCH_BYTES = 2 << 20  # raw, in a call: larger gains nothing, smaller pays a kilobyte of schema too often
_ROW_BYTES = 14  # a position in single precision and a state
MAX_LANES = 16  # tracked swimmers with a lane of states: more cannot be read


class SwimmerTrack:
    """The recorded `swimmers`, and those with `trails`, a subset of them; ids as in the frames."""

    def __init__(
        self, file: RecordingFile, *, swimmers: np.ndarray, trails: np.ndarray, box: np.ndarray, radius: float
    ) -> None:
        self._file, self._swimmers, self._trails, self._box = file, swimmers, trails, box
        self._radius = radius
        self._frames: list[tuple[int, float]] = []  # step and time of the rows that wait
        self._rows: dict[str, list[np.ndarray]] = {}
        self._last: np.ndarray | None = None  # (n_trails, 3) unwrapped, of the frame before
        self._last_state = np.full(len(trails), -1)
        self._changes: dict[str, list[tuple[int, float, str]]] = {}  # of each lane: step, time, state
        self._log_styles()

    def observe(self, frame: Frame) -> None:
        """Take in one frame; send the batch when it is full."""
        self._frames.append((frame.step, frame.time))
        self._add("positions", self._wrap(frame.position[self._swimmers]))
        self._add("states", frame.state[self._swimmers].astype(np.uint16))
        if len(self._trails):
            self._add_trails(frame)
            self._add_lanes(frame)
        if len(self._frames) * max(1, len(self._swimmers)) * _ROW_BYTES >= _BATCH_BYTES:
            self.send()

    def send(self) -> None:
        """Send the rows that wait."""
        if not self._frames:
            return
        rows = {name: np.concatenate(parts) for name, parts in self._rows.items()}
        if len(self._swimmers):
            points = rr.Points3D.columns(positions=rows["positions"], class_ids=rows["states"])
            self._send("world/swimmers", points, n=len(self._swimmers))
        if len(self._trails):
            states = rows["trail_states"]
            points = rr.Points3D.columns(positions=rows["trail_positions"], class_ids=states)
            arrows = rr.Arrows3D.columns(vectors=rows["vectors"], origins=rows["origins"])
            strips = rr.LineStrips3D.columns(strips=list(rows["segments"]), class_ids=states)
            for name, columns in (("swimmers", points), ("directors", arrows), ("trails", strips)):
                self._send(f"world/tracked/{name}", columns, n=len(self._trails))
        for lane, changes in self._changes.items():
            steps, times, names = (list(part) for part in zip(*changes, strict=True))
            self._file.send(lane, rr.StateChange.columns(state=names), steps=steps, times=times)
        self._frames, self._rows, self._changes = [], {}, {}
        self._file.flush()

    def _send(self, entity: str, columns: rr.ComponentColumnList, *, n: int) -> None:
        steps, times = [step for step, _ in self._frames], [time for _, time in self._frames]
        self._file.send(entity, columns.partition([n] * len(steps)), steps=steps, times=times)

    def _add(self, name: str, rows: np.ndarray) -> None:
        self._rows.setdefault(name, []).append(rows)  # concatenated before it is sent, hence a copy

    def _add_trails(self, frame: Frame) -> None:
        position, director = frame.position[self._trails], frame.director[self._trails]
        end = self._wrap(position)
        before = position if self._last is None else self._last
        # drawn whole in the image where it ends: a trail breaks at the box and never crosses it
        start = (end - (position - before)).astype(np.float32)
        self._last = position.copy()
        # an arrow is the body of a slender swimmer and sticks out of a round one
        tail = (1.0 - min(self._radius, 1.0)) * director
        self._add("trail_positions", end)
        self._add("trail_states", frame.state[self._trails].astype(np.uint16))
        self._add("origins", (end - tail).astype(np.float32))
        self._add("vectors", (tail + (1.0 + 1.5 * self._radius) * director).astype(np.float32))
        self._add("segments", np.stack([start, end], axis=1))

    def _add_lanes(self, frame: Frame) -> None:
        state = frame.state[self._trails].astype(int)
        for lane in np.flatnonzero(state[:MAX_LANES] != self._last_state[:MAX_LANES]):
            change = (frame.step, frame.time, STATE_NAMES[int(state[lane])])
            self._changes.setdefault(_lane(self._trails[lane]), []).append(change)
        self._last_state = state

    def _wrap(self, position: np.ndarray) -> np.ndarray:
        edge = np.where(self._box > 0.0, self._box, np.inf)
        return np.asarray(position - np.floor(position / edge) * np.where(self._box > 0.0, edge, 0.0), np.float32)

    def _log_styles(self) -> None:
        radius = [self._radius]
        self._file.log("world/swimmers", rr.Points3D.from_fields(radii=radius, show_labels=False))
        if not len(self._trails):
            return
        self._file.log("world/tracked/swimmers", rr.Points3D.from_fields(radii=radius, show_labels=False))
        arrows = rr.Arrows3D.from_fields(radii=[0.25 * self._radius], colors=[DIRECTOR], show_labels=False)
        self._file.log("world/tracked/directors", arrows)
        self._file.log("world/tracked/trails", rr.LineStrips3D.from_fields(radii=[-1.25], show_labels=False))
        names = list(STATE_NAMES)
        style = rr.StateConfiguration(
            values=[STATE_NAMES[state] for state in names], colors=[STATE_COLORS[state] for state in names]
        )
        for swimmer in self._trails[:MAX_LANES]:
            self._file.log(_lane(swimmer), style)


def _lane(swimmer: int) -> str:
    return f"states/swimmer_{swimmer:06d}"

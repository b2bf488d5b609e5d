"""Swimmers that leave a trail in a recording: the trail, the body at its end, the director."""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.core.state import State
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.bodies import Body
from porous_swim.observers.rerun.palette import DIRECTOR
from porous_swim.observers.rerun.stream import Moments, RecordingFile


class TrailTrack:
    """The `swimmers` (ids as in the frames) below `entity`, each drawn as `body`.

    Positions are wrapped into the periodic `box` (3,); rows wait until `send`.
    """

    def __init__(self, file: RecordingFile, entity: str, *, swimmers: np.ndarray, box: np.ndarray, body: Body) -> None:
        self._file, self._entity, self._swimmers, self._box, self._body = file, entity, swimmers, box, body
        self._rows: dict[str, list[np.ndarray]] = {}
        self._last: np.ndarray | None = None  # (n, 3) unwrapped, of the last frame that was sent
        file.log(f"{entity}/swimmers", body.style(len(swimmers)))
        arrows = rr.Arrows3D.from_fields(radii=[0.25 * body.radius], colors=[DIRECTOR], show_labels=False)
        file.log(f"{entity}/directors", arrows)
        file.log(f"{entity}/trails", rr.LineStrips3D.from_fields(radii=[-1.25], show_labels=False))

    def observe(self, frame: Frame) -> None:
        """Take in one frame."""
        for name in ("position", "director", "state"):
            self._rows.setdefault(name, []).append(getattr(frame, name)[self._swimmers])

    def send(self, moments: Moments) -> None:
        """Send the rows that wait, one for each of `moments`."""
        rows = self._drawn(*(np.stack(self._rows[name]) for name in ("position", "director", "state")))
        bodies = self._body.columns(rows["positions"], rows["directors"], rows["states"], len(self._swimmers))
        arrows = rr.Arrows3D.columns(vectors=rows["vectors"], origins=rows["origins"])
        strips = rr.LineStrips3D.columns(strips=rows["segments"], class_ids=rows["states"])
        lengths = [len(self._swimmers)] * len(moments)
        for name, columns in (("swimmers", bodies), ("directors", arrows), ("trails", strips)):
            self._file.send(f"{self._entity}/{name}", columns.partition(lengths), moments)
        self._rows = {}

    def state(self) -> dict[str, np.ndarray]:
        """Where the swimmers were in the last frame that was sent, if there was one."""
        return {} if self._last is None else {"last": self._last}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        self._last = state["last"].copy() if "last" in state else None

    def _drawn(self, position: np.ndarray, director: np.ndarray, state: np.ndarray) -> dict[str, np.ndarray]:
        """What is drawn of vectors (n_frames, n, 3) and states (n_frames, n): rows of swimmers, frame by frame."""
        end = wrapped(position, self._box)
        before = np.concatenate([position[:1] if self._last is None else self._last[None], position[:-1]])
        # drawn whole in the image where it ends: a trail breaks at the box and never crosses it
        start = (end - (position - before)).astype(np.float32)
        self._last = position[-1]
        # an arrow sticks out of its body
        reach = self._body.half_length + 1.5 * self._body.radius
        return {
            "positions": end.reshape(-1, 3),
            "directors": director.reshape(-1, 3),
            "states": state.ravel().astype(np.uint16),
            "origins": end.reshape(-1, 3),
            "vectors": (reach * director).astype(np.float32).reshape(-1, 3),
            "segments": np.stack([start, end], axis=2).reshape(-1, 2, 3),
        }


def wrapped(position: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Positions (..., 3) in the periodic `box` (3,), in single precision."""
    edge = np.where(box > 0.0, box, np.inf)
    return np.asarray(position - np.floor(position / edge) * np.where(box > 0.0, edge, 0.0), np.float32)

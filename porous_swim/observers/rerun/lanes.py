"""States of swimmers in a recording: a lane for each, that changes colour with the state."""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.core.state import State
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.palette import STATE_COLORS, STATE_NAMES
from porous_swim.observers.rerun.stream import Moments, RecordingFile

MAX_LANES = 16  # more cannot be read


class LaneTrack:
    """The first `MAX_LANES` of `swimmers`, ids as in the frames; changes wait until `send`."""

    def __init__(self, file: RecordingFile, swimmers: np.ndarray) -> None:
        self._file, self._swimmers = file, swimmers[:MAX_LANES]
        self._last = np.full(len(self._swimmers), -1)
        self._changes: dict[str, tuple[Moments, list[str]]] = {}
        style = rr.StateConfiguration(values=list(STATE_NAMES.values()), colors=list(STATE_COLORS.values()))
        for swimmer in self._swimmers:
            file.log(lane_of(swimmer), style)

    def observe(self, frame: Frame) -> None:
        """Note whose state differs from that of the frame before."""
        state = frame.state[self._swimmers].astype(int)
        for row in np.flatnonzero(state != self._last):
            moments, names = self._changes.setdefault(lane_of(self._swimmers[row]), (Moments(), []))
            moments.add(frame)
            names.append(STATE_NAMES[int(state[row])])
        self._last = state

    def send(self) -> None:
        """Send the changes that wait."""
        for lane, (moments, names) in self._changes.items():
            self._file.send(lane, rr.StateChange.columns(state=names), moments)
        self._changes = {}

    def state(self) -> dict[str, np.ndarray]:
        """The states of the frame before; what waits is to be sent first."""
        return {"lanes": self._last}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        self._last = state["lanes"].copy()


def lane_of(swimmer: int) -> str:
    """The entity of a swimmer's lane."""
    return f"states/swimmer_{swimmer:06d}"

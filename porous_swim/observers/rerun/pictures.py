"""What is drawn anew now and then rather than at every frame, of what is new since the last time."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from porous_swim.core.state import State
from porous_swim.observers.base import Frame

MOST = 20  # over a run: what they show is seen to grow; each takes some ms of events, of sorting, and of Rerun


class Pictures(ABC):
    """Sees every frame of a run of `n_frames`, draws some `MOST` of them, and the last. Those need events."""

    def __init__(self, *, n_frames: int) -> None:
        self._every = max(1, n_frames // MOST)
        self._n_seen = 0
        self._waiting: tuple[int, float] | None = None  # step and time of the last events, unless those have been drawn

    @abstractmethod
    def count(self, frame: Frame) -> None:
        """Take in the events of a frame."""

    @abstractmethod
    def draw(self, *, step: int, time: float) -> None:
        """Log a picture of all that was counted."""

    @property
    def due(self) -> bool:
        """Whether the next frame is to be drawn."""
        return self._n_seen % self._every == 0

    def observe(self, frame: Frame) -> None:
        """Count; draw where that is due."""
        due = self.due
        self._n_seen += 1
        if not frame.has_events:
            return
        self.take(frame)
        if due:
            self.draw(step=frame.step, time=frame.time)
            self._waiting = None

    def take(self, frame: Frame) -> None:
        """Count; what was not drawn yet is at the end."""
        self.count(frame)
        self._waiting = frame.step, frame.time

    def finish(self) -> None:
        """Draw how it ended."""
        if self._waiting is not None:
            step, time = self._waiting
            self.draw(step=step, time=time)

    def state(self) -> dict[str, np.ndarray]:
        """What was seen, and what is still to be drawn; those who count add it."""
        waiting = [] if self._waiting is None else [self._waiting]
        return {"n_seen": np.array(self._n_seen), "waiting": np.array(waiting, dtype=float).reshape(-1, 2)}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        self._n_seen = int(state["n_seen"])
        self._waiting = next(((int(step), time) for step, time in state["waiting"].tolist()), None)

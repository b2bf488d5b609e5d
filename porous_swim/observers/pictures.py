"""What is drawn anew now and then rather than at every frame."""

from __future__ import annotations

from abc import ABC, abstractmethod

from porous_swim.observers.base import Frame


class Pictures(ABC):
    """Takes in every frame of a run of `n_frames`, draws at most some `most` of them, and the last."""

    def __init__(self, *, n_frames: int, most: int) -> None:
        self._every = max(1, n_frames // most)
        self._n_seen = 0
        self._waiting: Frame | None = None  # the last frame, unless it has been drawn

    @abstractmethod
    def count(self, frame: Frame) -> None:
        """Take in what happened since the frame before."""

    @abstractmethod
    def draw(self, *, step: int, time: float) -> None:
        """Log a picture of all that was counted."""

    def observe(self, frame: Frame) -> None:
        """Count; draw where that is due."""
        self.count(frame)
        due = self._n_seen % self._every == 0
        if due:
            self.draw(step=frame.step, time=frame.time)
        self._waiting = None if due else frame
        self._n_seen += 1

    def finish(self) -> None:
        """Draw how it ended."""
        if self._waiting is not None:
            self.draw(step=self._waiting.step, time=self._waiting.time)

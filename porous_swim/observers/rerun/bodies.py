"""How swimmers look: dots for spheres, ellipsoids or thick lines for rods. Lengths in a."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import rerun as rr

MAX_ELLIPSOIDS = 2000  # more take seconds a picture without a GPU; lines are always quick


@dataclass(frozen=True)
class Body:
    """A swimmer as drawn: its semi-minor axis `radius`, and its `half_length`."""

    radius: float
    half_length: float

    @property
    def round(self) -> bool:
        """Whether it is a sphere."""
        return self.half_length == self.radius

    def style(self, n_swimmers: int) -> rr.AsComponents:
        """What all frames share."""
        if self.round:
            return rr.Points3D.from_fields(radii=[self.radius], show_labels=False)
        if n_swimmers > MAX_ELLIPSOIDS:
            return rr.LineStrips3D.from_fields(radii=[self.radius], show_labels=False)
        return rr.Ellipsoids3D.from_fields(fill_mode="solid", show_labels=False)

    def columns(
        self, position: np.ndarray, director: np.ndarray, state: np.ndarray, n_swimmers: int
    ) -> rr.ComponentColumnList:
        """Rows for swimmers at `position` (n, 3) in single precision with `director` (n, 3) and `state` (n,).

        `n_swimmers` are those of a frame, as `style` was told.
        """
        states = state.astype(np.uint16)
        if self.round:
            return rr.Points3D.columns(positions=position, class_ids=states)
        if n_swimmers > MAX_ELLIPSOIDS:
            half = (self.half_length * director).astype(np.float32)
            ends = np.stack([position - half, position + half], axis=1)
            return rr.LineStrips3D.columns(strips=ends, class_ids=states)
        half_sizes = np.tile(np.array([self.half_length, self.radius, self.radius], np.float32), (len(position), 1))
        return rr.Ellipsoids3D.columns(
            centers=position, half_sizes=half_sizes, quaternions=_turning(director), class_ids=states
        )


def _turning(director: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4), real part last, that turn the x axis the shortest way to `director`, (n, 3)."""
    x, y, z = director.T
    turn = np.stack([np.zeros(len(x)), -z, y, 1.0 + x], axis=1)
    length = np.linalg.norm(turn, axis=1, keepdims=True)
    back = np.array([0.0, 0.0, 1.0, 0.0])  # half a turn: the shortest ways are all alike
    turn = np.where(length > 1e-6, turn / np.maximum(length, 1e-6), back)
    return turn.astype(np.float32)

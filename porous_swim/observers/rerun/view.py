"""Where the camera stands, and how large things are drawn. Lengths in a."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porous_swim.observers.rerun.bodies import Body
from porous_swim.obstacles.field import ObstacleField

_MARGIN = 1.15  # of the size that fits exactly
_HALF_VIEW = np.tan(np.radians(55.0) / 2.0)  # Rerun's vertical field of view
_MIN_DOT = 1.0 / 400.0  # of the scene's size: the smallest sphere that is still seen as a dot


@dataclass(frozen=True)
class Scenery:
    """The part of space worth looking at: a box around what happens."""

    lower: np.ndarray  # (3,)
    upper: np.ndarray  # (3,)
    dimensions: int

    @classmethod
    def of(cls, field: ObstacleField, position: np.ndarray) -> Scenery:
        """The box of a periodic field; else what holds the colloids and most of the `position`s, (n, 3)."""
        most = np.quantile(position, [0.05, 0.95], axis=0) if len(position) else np.zeros((0, 3))
        corners = np.concatenate([field.outline(most), most, np.zeros((1, 3))])
        repeats = field.box > 0.0
        lower = np.where(repeats, 0.0, corners.min(axis=0))
        upper = np.where(repeats, field.box, corners.max(axis=0))
        if not np.any(repeats):  # room for what leaves
            margin = 0.2 * float(np.max(upper - lower)) + 2.0
            lower, upper = lower - margin, upper + margin
        return cls(lower, upper, field.dimensions)

    @property
    def center(self) -> np.ndarray:
        """The middle, (3,)."""
        center: np.ndarray = 0.5 * (self.lower + self.upper)
        return center

    @property
    def size(self) -> float:
        """The longest edge."""
        return float(np.max(self.upper - self.lower))

    def eye(self) -> tuple[np.ndarray, np.ndarray]:
        """Position and upward direction, each (3,), of a camera that sees space from a corner."""
        direction, up = np.array([0.55, -0.85, 0.5]), np.array([0.0, 0.0, 1.0])
        distance = 0.52 * float(np.linalg.norm(self.upper - self.lower)) / _HALF_VIEW
        return self.center + _MARGIN * distance * direction / np.linalg.norm(direction), up

    def body(self, aspect_ratio: float) -> Body:
        """A swimmer of half-length 1 as it is drawn: at its own size, or as the smallest that is seen."""
        dot = _MIN_DOT * self.size
        if aspect_ratio == 1.0:
            return Body(max(1.0, dot), max(1.0, dot))
        return Body(max(aspect_ratio, 0.5 * dot), max(1.0, 2.0 * dot))

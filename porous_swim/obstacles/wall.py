"""A plane wall: the one obstacle that has a normal in place of a centre."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from porous_swim.core.parts import Direction, KeyedError, Point, as_vector, unit_vector
from porous_swim.obstacles.base import Layout
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.model import Surface

_KEY = "obstacles"


@dataclass(frozen=True, eq=False)
class WallField(ObstacleField):
    """One wall in open space: colloid 0, of infinite radius; for its centre stands a point of the wall.

    Of the axes of the device the last in which swimmers move is its normal.
    """

    axes: np.ndarray  # (3, 3), rows

    @classmethod
    def through(cls, point: np.ndarray, normal: np.ndarray, dimensions: int) -> WallField:
        """The wall through `point` (3,), a, whose unit `normal` (3,) points into the fluid."""
        return cls(point[None, :], np.array([np.inf]), np.zeros(3), dimensions, wall_axes(normal, dimensions))

    @property
    def surface(self) -> Surface:
        """The kind of surface: a plane."""
        return "plane"

    @property
    def normal(self) -> np.ndarray:
        """The unit normal, into the fluid, (3,)."""
        normal: np.ndarray = self.axes[self.dimensions - 1]
        return normal

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return index 0 (n,), image 0 (n, 3) and the height (n,) of `points` (n, 3) above the wall."""
        n = len(points)
        return np.zeros(n, dtype=np.int64), np.zeros((n, 3), dtype=np.int64), self._heights(points - self.centers)

    def near(self, points: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the points (m,) below `height`, index 0 (m,), and their offsets from the wall's point (m, 3)."""
        offset = points - self.centers
        low = np.flatnonzero(self._heights(offset) < height)
        return low, np.zeros(len(low), dtype=np.int64), offset[low]

    def to_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of space in the axes of the device."""
        return np.asarray(vectors @ self.axes.T)

    def from_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of the device in the axes of space."""
        return np.asarray(vectors @ self.axes)

    def stance(self, offset: np.ndarray, director: np.ndarray, colloid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height and sine of the pitch, both (n,), of swimmers at `offset` (n, 3) from the wall's point."""
        return self._heights(offset), np.asarray(director @ self.normal)

    def above(self, colloid: int, direction: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return (n, 3) copies of the point at `height` over the wall's point, and of the normal."""
        normal = np.tile(self.normal, (len(direction), 1))
        return self.centers + height * normal, normal

    def outline(self, points: np.ndarray) -> np.ndarray:
        """Return the part of the wall below `points` (n, 3): their feet (n, 3)."""
        return np.asarray(points - self._heights(points - self.centers)[:, None] * self.normal)

    def name(self, colloid: int) -> str:
        """What messages call it."""
        return "the wall"

    def _heights(self, offset: np.ndarray) -> np.ndarray:
        return np.asarray(offset @ self.normal)


def wall_axes(normal: np.ndarray, dimensions: int) -> np.ndarray:
    """Return right-handed axes, the rows (3, 3), with the unit `normal` (3,) last of those in which swimmers move."""
    if dimensions == 2:
        return np.array([[normal[1], -normal[0], 0.0], normal, [0.0, 0.0, 1.0]])
    across = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(normal, across), normal])


class Wall(Layout):
    """One plane wall, with fluid on one side, in open space."""

    OPEN = True

    layout: Literal["wall"]
    normal: Direction
    """Direction from the wall into the fluid; any length."""
    position: Point = (0.0, 0.0, 0.0)
    """A point of the wall."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where normal, position or box do not fit `domain`."""
        if domain.periodic:
            message = "a wall stands in open space: expected open (nothing needs to repeat along it), found periodic"
            raise KeyedError("domain.boundary", message)
        domain.refuse_size("an open domain is unbounded")
        as_vector(self.position, key=f"{_KEY}.position", dimensions=domain.dimensions)
        unit_vector(self.normal, key=f"{_KEY}.normal", dimensions=domain.dimensions)

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many obstacles there will be."""
        return 1

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the field of the wall."""
        point = as_vector(self.position, key=f"{_KEY}.position", dimensions=domain.dimensions)
        normal = unit_vector(self.normal, key=f"{_KEY}.normal", dimensions=domain.dimensions)
        return WallField.through(point, normal, domain.dimensions)

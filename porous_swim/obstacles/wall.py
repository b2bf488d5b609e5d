"""A plane wall: the body that has a normal in place of a centre, and the layout that puts it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from porous_swim.core.parts import Direction, KeyedError, Point, as_vector, unit_vector
from porous_swim.obstacles.base import Layout
from porous_swim.obstacles.bodies import Bodies, Solids
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.model import Surface

THICKNESS = 1.0  # a, as drawn
_KEY = "obstacles"
_SHOWN = 0.75  # of the longest edge of a picture, from the wall's middle to its edge


@dataclass(frozen=True, eq=False)
class PlaneWall(Bodies):
    """One plane wall, with fluid on one side; it repeats along no axis.

    Of the axes of the device the last in which swimmers move is its normal.
    """

    SURFACE: ClassVar[Surface] = "plane"
    ROUND: ClassVar[bool] = False
    ENDLESS: ClassVar[bool] = True

    point: np.ndarray  # (3,), a; any of the wall, from which offsets are measured
    normal: np.ndarray  # (3,), unit, into the fluid
    dimensions: int

    @property
    def centers(self) -> np.ndarray:  # type: ignore[override]
        """Its point, (1, 3)."""
        return self.point[None, :]

    @property
    def radii(self) -> np.ndarray:  # type: ignore[override]
        """Infinite, (1,)."""
        return np.array([np.inf])

    @property
    def at_surface(self) -> np.ndarray:
        """0, (1,): what the device has for a distance is a height already."""
        return np.zeros(1)

    @cached_property
    def axes(self) -> np.ndarray:
        """The axes of the device, rows (3, 3)."""
        return wall_axes(self.normal, self.dimensions)

    def search(self, box: np.ndarray) -> PlaneWall:
        """Return itself: there is nothing to look for."""
        return self

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return index 0 (n,), image 0 (n, 3) and the height (n,) of `points` (n, 3) above the wall."""
        n = len(points)
        return np.zeros(n, dtype=np.int64), np.zeros((n, 3), dtype=np.int64), self._heights(points - self.point)

    def near(self, points: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the points (m,) below `height`, index 0 (m,), and their offsets from the wall's point (m, 3)."""
        offset = points - self.point
        low = np.flatnonzero(self._heights(offset) < height)
        return low, np.zeros(len(low), dtype=np.int64), offset[low]

    def to_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of space in the axes of the device."""
        return np.asarray(vectors @ self.axes.T)

    def from_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of the device in the axes of space."""
        return np.asarray(vectors @ self.axes)

    def stance(self, offset: np.ndarray, director: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height and sine of the pitch, both (n,), of swimmers at `offset` (n, 3) from the wall's point."""
        return self._heights(offset), np.asarray(director @ self.normal)

    def above(self, which: int, direction: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return (n, 3) copies of the point at `height` over the wall's point, and of the normal."""
        normal = np.tile(self.normal, (len(direction), 1))
        return self.point + height * normal, normal

    def bulk(self, dimensions: int) -> np.ndarray:
        """Return 0, (1,): it bounds the fluid and takes no share of it."""
        return np.zeros(1)

    def outline(self, points: np.ndarray) -> np.ndarray:
        """Return the part of the wall below `points` (n, 3): their feet (n, 3)."""
        return np.asarray(points - self._heights(points - self.point)[:, None] * self.normal)

    def solids(self, which: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Solids:
        """Return the part of it below the picture, as a slab whose upper face is the plane."""
        size, last = np.full(3, _SHOWN * float(np.max(upper - lower))), self.dimensions - 1
        size[last] = 0.5 * THICKNESS
        size[last + 1 :] = THICKNESS  # across the plane of two dimensions
        middle = self.outline(0.5 * (lower + upper)[None, :]) - size[last] * self.normal
        return Solids("box", middle, size[None, :], self.axes)

    def name(self, which: int, number: int) -> str:
        """What messages call it."""
        return "the wall"

    def described(self) -> str:
        """Where it stands."""
        point, normal = ("(" + ", ".join(f"{x:g}" for x in v) + ")" for v in (self.point, self.normal))
        return f"a plane wall through {point} with normal {normal}"

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
    ROUND: ClassVar[bool] = PlaneWall.ROUND  # of what it puts; else a rod may touch two, and costs more

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
        return ObstacleField((PlaneWall(point, normal, domain.dimensions),), np.zeros(3), domain.dimensions)

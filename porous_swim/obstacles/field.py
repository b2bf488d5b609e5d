"""The colloids of a run: where they are, how large, and the box that repeats them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np

from porous_swim.obstacles.nearest import NearestSphere
from porous_swim.physics.model import Surface


@dataclass(frozen=True, eq=False)
class ObstacleField:
    """Spheres fixed in space. A periodic box spans [0, box) on each axis that has an edge.

    In two dimensions all centres have z = 0 and the box has no edge along z.
    """

    centers: np.ndarray  # (n_colloids, 3), a
    radii: np.ndarray  # (n_colloids,), a
    box: np.ndarray  # (3,), a; edge lengths, 0 along an axis that does not repeat
    dimensions: int  # 2 or 3
    notes: tuple[str, ...] = field(
        default=(), kw_only=True
    )  # sentences about what had to be done to place the colloids

    @property
    def surface(self) -> Surface:
        """The kind of surface that colloids have."""
        return "sphere"

    @property
    def periodic(self) -> bool:
        """Whether the field repeats."""
        return bool(np.any(self.box > 0.0))

    @property
    def packing_fraction(self) -> float | None:
        """Share of the box inside colloids, of its area in 2-D; None where the field is open."""
        if not self.periodic:
            return None
        return float(bulk(self.radii, self.dimensions).sum() / np.prod(self.box[: self.dimensions]))

    @property
    def spacing(self) -> float | None:
        """Mean distance of colloids, a: edge of the cube (square in 2-D) that each has; None unless all axes repeat."""
        edges = self.box[: self.dimensions]
        if self.surface != "sphere" or len(self.radii) == 0 or np.any(edges == 0.0):
            return None
        return float((np.prod(edges) / len(self.radii)) ** (1.0 / self.dimensions))

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the colloid with the nearest surface for each of `points`, (n, 3) absolute positions.

        Gives its index (n,), its periodic image (n, 3) counted in boxes, and the height of the point above
        its surface (n,), negative inside. In an empty field the index is -1 and the height infinite.
        """
        return self._spheres.nearest(points)

    def near(self, points: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return all pairs of a point and a colloid's image whose surface is less than `height` away.

        Gives the index of the point (m,), of the colloid (m,), and the offset of the point from that image's
        centre (m, 3).
        """
        return self._spheres.near(points, height)

    def to_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of space in the axes in which the device has offsets and directors: the same."""
        return vectors

    def from_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of the device in the axes of space."""
        return vectors

    def stance(self, offset: np.ndarray, director: np.ndarray, colloid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height and sine of the pitch, both (n,), of swimmers at `offset` (n, 3) from `colloid` (n,)."""
        distance = np.linalg.norm(offset, axis=1)
        sine = np.einsum("ij,ij->i", director, offset) / np.where(distance > 0.0, distance, 1.0)
        return distance - self.radii[colloid], sine

    def above(self, colloid: int, direction: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3) at `height` above a colloid in unit `direction`s (n, 3), and the normals there."""
        return self.centers[colloid] + (self.radii[colloid] + height) * direction, direction

    def outline(self, points: np.ndarray) -> np.ndarray:
        """Return corners (m, 3) of what is to be seen of the colloids beside `points` (n, 3)."""
        radii = self.radii[:, None]
        return np.concatenate([self.centers - radii, self.centers + radii])

    def name(self, colloid: int) -> str:
        """What messages call a colloid."""
        return f"colloid {colloid} of radius {self.radii[colloid]:g}"

    @cached_property
    def _spheres(self) -> NearestSphere:
        return NearestSphere(self.centers, self.radii, self.box)


def bulk(radii: np.ndarray, dimensions: int) -> np.ndarray:
    """Return the areas of discs (2-D) or the volumes of spheres (3-D) of `radii`, (n,)."""
    return np.asarray(pi * radii**2 if dimensions == 2 else 4.0 / 3.0 * pi * radii**3)

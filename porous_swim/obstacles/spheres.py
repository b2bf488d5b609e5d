"""Spheres: bodies with a centre and a radius."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np

from porous_swim.obstacles.bodies import Bodies, Solids
from porous_swim.obstacles.nearest import NearestSphere
from porous_swim.physics.model import Surface


@dataclass(frozen=True, eq=False)
class Spheres(Bodies):
    """Spheres; in two dimensions the plane z = 0 cuts them through their centres."""

    SURFACE: ClassVar[Surface] = "sphere"
    ROUND: ClassVar[bool] = True
    ENDLESS: ClassVar[bool] = False

    centers: np.ndarray  # (n, 3), a
    radii: np.ndarray  # (n,), a

    @property
    def at_surface(self) -> np.ndarray:
        """The radii, (n,)."""
        return self.radii

    def search(self, box: np.ndarray) -> NearestSphere:
        """Return the search for the nearest surface in `box` (3,)."""
        return NearestSphere(self.centers, self.radii, box)

    def stance(self, offset: np.ndarray, director: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height and sine of the pitch, both (n,), of swimmers at `offset` (n, 3) from the centres."""
        distance = np.linalg.norm(offset, axis=1)
        sine = np.einsum("ij,ij->i", director, offset) / np.where(distance > 0.0, distance, 1.0)
        return distance - self.radii[which], sine

    def above(self, which: int, direction: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3) at `height` above a sphere in unit `direction`s (n, 3), and the normals there."""
        return self.centers[which] + (self.radii[which] + height) * direction, direction

    def bulk(self, dimensions: int) -> np.ndarray:
        """Return their areas (2-D) or volumes (3-D), (n,)."""
        return bulk(self.radii, dimensions)

    def nearest_gaps(self, box: np.ndarray) -> np.ndarray:
        """Return the gap from each (n,) to the nearest other, infinite where there is none."""
        return self.search(box).nearest_other()[1]

    def narrow_gaps(self, width: float, box: np.ndarray) -> np.ndarray:
        """Return the gaps (m,) below `width` between two surfaces, sorted, each pair of spheres once.

        Pairs over the edges of a periodic box count, too, a sphere and its own image included; 0 where surfaces touch
        or overlap.
        """
        spheres, found = self.search(box), [np.zeros(0)]
        size = np.floor(np.log2(self.radii))
        for value in np.unique(size):  # of like radius: one large sphere does not widen the search around all others
            members = np.flatnonzero(size == value)
            point, other, offset = spheres.near(self.centers[members], float(self.radii[members].max()) + width)
            distance = np.linalg.norm(offset, axis=1)
            itself = (members[point] == other) & (distance == 0.0)
            gap = distance - self.radii[members[point]] - self.radii[other]
            found.append(gap[(gap < width) & ~itself])
        gaps = np.sort(np.concatenate(found))[::2]  # each pair was found from both ends
        return np.maximum(gaps, 0.0)

    def outline(self, points: np.ndarray) -> np.ndarray:
        """Return the corners (2 n, 3) of the cubes around them."""
        radii = self.radii[:, None]
        return np.concatenate([self.centers - radii, self.centers + radii])

    def solids(self, which: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Solids:
        """Return some of them whole."""
        half_sizes = np.repeat(self.radii[which, None], 3, axis=1)
        return Solids("ellipsoid", self.centers[which], half_sizes, np.eye(3))

    def name(self, which: int, number: int) -> str:
        """What messages call one."""
        return f"colloid {number} of radius {self.radii[which]:g}"

    def described(self) -> str:
        """How many there are."""
        n = len(self.radii)
        return f"{n:,} colloid{'' if n == 1 else 's'}"


def bulk(radii: np.ndarray, dimensions: int) -> np.ndarray:
    """Return the areas of discs (2-D) or the volumes of spheres (3-D) of `radii`, (n,)."""
    return np.asarray(pi * radii**2 if dimensions == 2 else 4.0 / 3.0 * pi * radii**3)

"""The bodies of a run: where they are, how large, and the box that repeats them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from porous_swim.obstacles.bodies import Bodies, Search, Solids
from porous_swim.obstacles.spheres import Spheres
from porous_swim.physics.model import Surface


@dataclass(frozen=True, eq=False)
class ObstacleField:
    """Bodies fixed in space, of one kind or several. A periodic box spans [0, box) on each axis that has an edge.

    All bodies, whatever they are, are numbered through as "colloids": first those of the first kind. In two dimensions
    all centres have z = 0 and the box has no edge along z.
    """

    bodies: tuple[Bodies, ...]  # at least one kind, of which there may be none
    box: np.ndarray  # (3,), a; edge lengths, 0 along an axis that does not repeat
    dimensions: int  # 2 or 3
    notes: tuple[str, ...] = field(
        default=(), kw_only=True
    )  # sentences about what had to be done to place the colloids

    @classmethod
    def of_spheres(
        cls, centers: np.ndarray, radii: np.ndarray, box: np.ndarray, dimensions: int, *, notes: tuple[str, ...] = ()
    ) -> ObstacleField:
        """The field of spheres: `centers` (n, 3) and `radii` (n,), a."""
        return cls((Spheres(centers, radii),), box, dimensions, notes=notes)

    @cached_property
    def centers(self) -> np.ndarray:
        """What offsets from each body are measured from, (n_colloids, 3), a."""
        return np.concatenate([each.centers for each in self.bodies])

    @cached_property
    def radii(self) -> np.ndarray:
        """Radius of each body, (n_colloids,), a; infinite where its surface is flat."""
        return np.concatenate([each.radii for each in self.bodies])

    @cached_property
    def at_surface(self) -> np.ndarray:
        """What the device takes from a distance to get a height, (n_colloids,), a."""
        return np.concatenate([each.at_surface for each in self.bodies])

    @property
    def surface(self) -> Surface:
        """The surface that all bodies have: a kernel is compiled for one."""
        surfaces = sorted({each.SURFACE for each in self.bodies})
        if len(surfaces) > 1:
            raise NotImplementedError(f"obstacles: kernels are compiled for one surface, not {' and '.join(surfaces)}")
        return surfaces[0]

    @property
    def is_round(self) -> bool:
        """Whether swimmers can go all the way round every body."""
        return all(each.ROUND for each in self.bodies)

    @property
    def bounded(self) -> bool:
        """Whether there are bodies that can be seen whole."""
        return any(len(each.radii) and not each.ENDLESS for each in self.bodies)

    @property
    def periodic(self) -> bool:
        """Whether the field repeats."""
        return bool(np.any(self.box > 0.0))

    @property
    def bulk(self) -> float:
        """The volume of all bodies, their area in 2-D."""
        return float(np.concatenate([each.bulk(self.dimensions) for each in self.bodies]).sum())

    @property
    def packing_fraction(self) -> float | None:
        """Share of the box inside colloids, of its area in 2-D; None where the field is open."""
        if not self.periodic:
            return None
        return float(self.bulk / np.prod(self.box[: self.dimensions]))

    @property
    def spacing(self) -> float | None:
        """Mean distance of colloids, a: edge of the cube (square in 2-D) that each has; None unless all axes repeat."""
        edges = self.box[: self.dimensions]
        if len(self.radii) == 0 or np.any(edges == 0.0):
            return None
        return float((np.prod(edges) / len(self.radii)) ** (1.0 / self.dimensions))

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the colloid with the nearest surface for each of `points`, (n, 3) absolute positions.

        Gives its index (n,), its periodic image (n, 3) counted in boxes, and the height of the point above
        its surface (n,), negative inside. In an empty field the index is -1 and the height infinite.
        """
        index, image, height = self._searches[0].nearest(points)
        for search, first in zip(self._searches[1:], self._firsts[1:], strict=True):
            other, other_image, other_height = search.nearest(points)
            nearer = other_height < height
            index = np.where(nearer, first + other, index)
            image = np.where(nearer[:, None], other_image, image)
            height = np.where(nearer, other_height, height)
        return index, image, height

    def near(self, points: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return all pairs of a point and a colloid's image whose surface is less than `height` away.

        Gives the index of the point (m,), of the colloid (m,), and the offset of the point from that image's
        centre (m, 3).
        """
        found = [search.near(points, height) for search in self._searches]
        point, body, offset = ([each[k] for each in found] for k in range(3))
        colloid = [first + own for first, own in zip(self._firsts, body, strict=True)]
        return np.concatenate(point), np.concatenate(colloid), np.concatenate(offset)

    def to_device(self, vectors: np.ndarray, colloid: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of space in the axes in which the device has what is seen from `colloid` (n,)."""
        turned = np.empty(vectors.shape)
        for bodies, _, rows in self._kinds(colloid):
            turned[rows] = bodies.to_device(vectors[rows])
        return turned

    def from_device(self, vectors: np.ndarray, colloid: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of the device, seen from `colloid` (n,), in the axes of space."""
        turned = np.empty(vectors.shape)
        for bodies, _, rows in self._kinds(colloid):
            turned[rows] = bodies.from_device(vectors[rows])
        return turned

    def stance(self, offset: np.ndarray, director: np.ndarray, colloid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height and sine of the pitch, both (n,), of swimmers at `offset` (n, 3) from `colloid` (n,)."""
        height, sine = np.empty((2, len(offset)))
        for bodies, which, rows in self._kinds(colloid):
            height[rows], sine[rows] = bodies.stance(offset[rows], director[rows], which)
        return height, sine

    def above(self, colloid: int, direction: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3) at `height` above a colloid in unit `direction`s (n, 3), and the normals there."""
        bodies, which = self._one(colloid)
        return bodies.above(which, direction, height)

    def nearest_gaps(self) -> np.ndarray:
        """Return the gaps (n,), a, from each body to the nearest other of its kind; of some kinds none is known."""
        return np.concatenate([each.nearest_gaps(self.box) for each in self.bodies])

    def narrow_gaps(self, width: float) -> np.ndarray:
        """Return the gaps (m,), a, below `width` between two bodies of a kind, each pair once, sorted."""
        return np.sort(np.concatenate([each.narrow_gaps(width, self.box) for each in self.bodies]))

    def outline(self, points: np.ndarray) -> np.ndarray:
        """Return corners (m, 3) of what is to be seen of the colloids beside `points` (n, 3)."""
        return np.concatenate([each.outline(points) for each in self.bodies])

    def solids(self, colloid: np.ndarray, lower: np.ndarray, upper: np.ndarray, *, endless: bool) -> Iterator[Solids]:
        """Yield what is drawn of each kind of `colloid` (n,), `endless` or not, between `lower` and `upper`, (3,)."""
        for bodies, which, _ in self._kinds(colloid):
            if endless == bodies.ENDLESS and len(which):
                yield bodies.solids(which, lower, upper)

    def name(self, colloid: int) -> str:
        """What messages call a colloid."""
        bodies, which = self._one(colloid)
        return bodies.name(which, colloid)

    def described(self) -> str:
        """What `check` calls all bodies."""
        return " and ".join(each.described() for each in self.bodies)

    @cached_property
    def _searches(self) -> list[Search]:
        return [each.search(self.box) for each in self.bodies]

    @cached_property
    def _firsts(self) -> list[int]:
        """The number of the first body of each kind."""
        return np.cumsum([0, *(len(each.radii) for each in self.bodies)])[:-1].tolist()

    def _kinds(self, colloid: np.ndarray) -> Iterator[tuple[Bodies, np.ndarray, np.ndarray | slice]]:
        """Of each kind its bodies, which of them are in `colloid` (n,), and the rows in which they are."""
        if len(self.bodies) == 1:  # all rows, in one piece: sums are rounded as ever
            yield self.bodies[0], colloid, slice(None)
            return
        for bodies, first in zip(self.bodies, self._firsts, strict=True):
            rows = np.flatnonzero((colloid >= first) & (colloid < first + len(bodies.radii)))
            yield bodies, colloid[rows] - first, rows

    def _one(self, colloid: int) -> tuple[Bodies, int]:
        kind = int(np.searchsorted(self._firsts, colloid, side="right")) - 1
        return self.bodies[kind], colloid - self._firsts[kind]

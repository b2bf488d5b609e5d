"""Which colloids are neighbours: those whose cells in the power diagram share a face, periodic images too. In a."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from scipy.spatial import QhullError

from porous_swim.analysis.hopping.power_diagram import Faces, faces
from porous_swim.analysis.places import all_round, centers_of, radii_of, tiled, wrapped

LEAST_FACE = 0.01  # of the surface of either cell: less opens by rounding where four cells of a lattice meet
MOST_POINTS = 250_000  # of one diagram, images too: in space a quarter of a minute and 2 GB
_MARGIN = 3.0  # spacings around the box that are looked at first
_MOST_STEPS = 100  # of the frame along an edge


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Pairs of neighbours, each of them both ways."""

    first: np.ndarray  # (m,) colloid
    second: np.ndarray  # (m,) colloid
    image: np.ndarray  # (m, 3) of the second relative to the first
    face: np.ndarray  # (m,) size of the common face: a in the plane, a^2 in space

    def have(self, first: np.ndarray, second: np.ndarray, image: np.ndarray) -> np.ndarray:
        """Which pairs of colloids (n,), (n,) and relative images (n, 3) are among them, (n,) bool."""
        reach = int(np.max(np.abs(self.image), initial=0))
        n = int(max(each.max(initial=0) for each in (self.first, first, second))) + 1

        def keys(one: np.ndarray, two: np.ndarray, of: np.ndarray) -> np.ndarray:
            key = one.astype(np.int64) * n + two
            for axis in range(3):
                key = key * (2 * reach + 1) + np.clip(of[:, axis], -reach, reach) + reach
            return key

        near = np.all(np.abs(image) <= reach, axis=1)
        return near & np.isin(keys(first, second, image), keys(self.first, self.second, self.image))


def neighbours(colloids: pa.Table, *, box: tuple[float, float, float]) -> Neighbours | None:
    """All pairs whose common face is more than 1 % of the surface of one of their cells; None where that is not known.

    That is so where there are too many colloids, or open fields so thin that rounding decides. Outside of an open field
    a frame of points, a spacing away, closes the cells. Centres in a plane or on a line have their diagram there.
    """
    centers, radii, edges = centers_of(colloids), radii_of(colloids), np.asarray(box, float)
    inside, moved = wrapped(centers, edges)
    extent = np.where(edges > 0.0, edges, np.ptp(inside, axis=0) if len(inside) else 0.0)
    spread = np.flatnonzero(extent > 0.0)
    if len(spread) == 0 or not all_round(colloids):
        return Neighbours(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3), int), np.zeros(0))
    spacing = float(np.prod(extent[spread] / extent[spread].max()) / len(inside)) ** (1.0 / len(spread))
    spacing *= float(extent[spread].max())
    axes = np.sort([*spread, *np.flatnonzero(extent == 0.0)][: max(len(spread), 2)])
    found = _diagram(inside, radii, edges, axes, spacing)
    if found is None:
        return None
    cells, base, image = found
    surface = np.bincount(cells.first, weights=cells.size, minlength=len(inside))
    real = cells.second < len(base)
    first, place, size = cells.first[real], cells.second[real], cells.size[real]
    second = base[place]
    kept = size > LEAST_FACE * np.minimum(surface[first], surface[second])
    first, second, place, size = first[kept], second[kept], place[kept], size[kept]
    return Neighbours(first, second, image[place] - moved[second] + moved[first], size)


def _diagram(
    inside: np.ndarray, radii: np.ndarray, edges: np.ndarray, axes: np.ndarray, spacing: float
) -> tuple[Faces, np.ndarray, np.ndarray] | None:
    """Faces of the cells in the box, among all images that can touch them: of which colloid and which image each is."""
    margin = _MARGIN * spacing
    repeats = edges[axes] > 0.0
    while True:
        points, base, image = tiled(inside, edges, np.full(3, margin))
        frame = _frame(points[:, axes], ~repeats, spacing, away=spacing + float(np.max(radii)))
        if len(points) + len(frame) > MOST_POINTS:
            return None
        every = np.concatenate([points[:, axes], frame])
        try:
            cells = faces(every, np.append(radii[base], np.zeros(len(frame))), n=len(inside))
        except QhullError:  # the images are in a line: the box is narrow
            if not repeats.any():
                return None
            margin *= 2.0
            continue
        seen = np.maximum(cells.corners + cells.reach[:, None] - edges[axes], cells.reach[:, None] - cells.corners)
        needed = float(np.max(seen[:, repeats], initial=0.0))
        if (cells.closed and needed <= margin) or not repeats.any():
            return cells, base, image
        margin = max(1.5 * margin, min(needed, 4.0 * margin))


def _frame(points: np.ndarray, is_open: np.ndarray, spacing: float, *, away: float) -> np.ndarray:
    """Points (m, d) on the sides of a box around `points` (n, d), across the axes (d,) that are open."""
    low, high = points.min(axis=0) - away, points.max(axis=0) + away
    sides = [np.zeros((0, len(low)))]
    for axis in np.flatnonzero(is_open):
        steps = [
            np.array([a, b]) if k == axis
            else np.linspace(a, b, int(np.clip(np.ceil((b - a) / spacing), 1, _MOST_STEPS)) + 1)
            for k, (a, b) in enumerate(zip(low, high, strict=True))
        ]  # fmt: skip
        sides.append(np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, len(low)))
    return np.unique(np.concatenate(sides), axis=0)

"""Where the colloids of a table are, and how far their neighbours are. Lengths in a."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from scipy.spatial import cKDTree

from porous_swim.analysis.columns import column, vectors
from porous_swim.errors import ResultsError

# Centres are kept in fixed point: neighbours of a lattice are at one distance only up to rounding.
SAME_DISTANCE = 1.0001


def centers_of(colloids: pa.Table) -> np.ndarray:
    """Centres by colloid number, (n_colloids, 3); the rows may come in any order."""
    return vectors(colloids, "x", "y", "z")[np.argsort(column(colloids, "colloid"))]


def radii_of(colloids: pa.Table) -> np.ndarray:
    """Radii by colloid number, (n_colloids,); the rows may come in any order."""
    return column(colloids, "radius")[np.argsort(column(colloids, "colloid"))]


def at_wall(colloids: pa.Table) -> bool:
    """Whether the one obstacle is a plane wall, whose radius is infinite."""
    return bool(np.any(np.isinf(radii_of(colloids))))


def sphere_radii_of(colloids: pa.Table) -> np.ndarray:
    """The same where offsets from centres must mean something; `ResultsError` for a plane wall."""
    if at_wall(colloids):
        raise ResultsError("colloids: found a plane wall, which has no centre; this statistic is one of spheres")
    return radii_of(colloids)


def neighbour_distances(colloids: pa.Table, *, box: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Distance from each centre to the nearest other one, and to the nearest beyond that distance, (n_colloids,) each.

    Periodic images count, those of the colloid itself too. Infinite where there is no such neighbour.
    """
    edges = np.asarray(box)
    repeats = edges > 0.0
    centers = centers_of(colloids)
    centers[:, repeats] -= np.floor(centers[:, repeats] / edges[repeats]) * edges[repeats]
    n = len(centers)
    if n == 0:
        return np.zeros(0), np.zeros(0)
    # Within two of the shortest edge lie two images of the colloid itself; most fields need only a few spacings.
    furthest = 2.0 * float(np.min(edges[repeats])) if repeats.any() else np.inf
    spacing = (float(np.prod(edges[repeats])) / n) ** (1.0 / max(int(repeats.sum()), 1))
    reach, k = min(4.0 * spacing, furthest) if repeats.any() else np.inf, 32
    while True:
        points = _images(centers, edges, reach)
        k = min(k, len(points))
        distance = np.asarray(cKDTree(points).query(centers, k=range(1, k + 1))[0])[:, 1:]  # the first is itself
        distance = np.where(distance <= reach * SAME_DISTANCE, distance, np.inf)
        nearest = distance[:, 0] if distance.shape[1] else np.full(n, np.inf)
        beyond = np.where(distance > nearest[:, None] * SAME_DISTANCE, distance, np.inf)
        second = np.min(beyond, axis=1, initial=np.inf)
        missing = np.isinf(second)
        cut_short = missing & np.isfinite(distance[:, -1]) if distance.shape[1] else missing
        if np.any(cut_short) and k < len(points):  # who has all within reach needs no longer list but a longer reach
            k *= 2
        elif np.any(missing) and reach < furthest:
            reach = min(2.0 * reach, furthest)
        else:
            return nearest, second


def _images(centers: np.ndarray, edges: np.ndarray, reach: float) -> np.ndarray:
    """The centres and their images up to `reach` outside the box, (n, 3)."""
    points = centers
    margin = reach * SAME_DISTANCE
    for axis, edge in enumerate(edges):
        if edge > 0.0:
            step = np.zeros(3)
            step[axis] = edge
            points = np.concatenate([points + number * step for number in (-2, -1, 0, 1, 2)])
            points = points[(points[:, axis] >= -margin) & (points[:, axis] <= edge + margin)]
    return points

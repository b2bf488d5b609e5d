"""Faces between the cells of spheres: the power diagram, of points and radii in the plane or in space.

The cell of a sphere is where |x - centre|^2 - radius^2 is the least: its Voronoi cell where all radii are equal. Lifted
to one dimension more, the spheres have the diagram as the lower side of their convex hull. Source: Aurenhammer, SIAM J.
Comput. 16, 78 (1987).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import ConvexHull

_LOWER = -1e-10  # last component of a facet's unit normal; above, the facet is on the upper side


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of the cells of the first `n` points, whose cells are whole where `closed`."""

    first: np.ndarray  # (m,) number of the point, below n
    second: np.ndarray  # (m,) number of the other one
    size: np.ndarray  # (m,) length in the plane, area in space
    corners: np.ndarray  # (n_corners, d) of these cells
    reach: np.ndarray  # (n_corners,) a further point nearer than this to the corner could cut it off
    closed: bool  # False where a cell is open to the outside


def faces(points: np.ndarray, radii: np.ndarray, *, n: int) -> Faces:
    """Of the cells of the first `n` points, from points (m, d) and radii (m,); `QhullError` for points in one plane.

    Facets of the hull that lie in one plane (corners at which many cells meet, as in lattices) share its corner, so
    that faces between cells that meet in no more than that have size 0.
    """
    middle = points[:n].mean(axis=0)
    x, weight = points - middle, radii**2
    hull = ConvexHull(np.column_stack([x, np.sum(x**2, axis=1) - weight]))
    normal = hull.equations[:, :-1]
    lower = normal[:, -1] < _LOWER
    corner = np.zeros((len(normal), x.shape[1]))
    corner[lower] = -0.5 * normal[lower, :-1] / normal[lower, -1:]
    ours = np.any(hull.simplices < n, axis=1)
    first, second, size = _sized(hull, corner, lower, ours & lower, n)
    of_cells = ours & lower
    at = hull.simplices[of_cells, 0]
    power = np.sum((x[at] - corner[of_cells]) ** 2, axis=1) - weight[at]
    reach = np.sqrt(np.maximum(power + np.max(weight, initial=0.0), 0.0))
    return Faces(first, second, size, corner[of_cells] + middle, reach, bool(np.all(lower[ours])))


def _sized(
    hull: ConvexHull, corner: np.ndarray, lower: np.ndarray, ours: np.ndarray, n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on both sides of each face, and its size, (m,) each; from every cell of the first `n` points."""
    d = corner.shape[1]
    one = np.repeat(np.flatnonzero(ours), d + 1)
    opposite = np.tile(np.arange(d + 1), int(ours.sum()))
    other = hull.neighbors[one, opposite]
    once = lower[other] & ((one < other) | ~ours[other])
    one, other, opposite = one[once], other[once], opposite[once]
    rest = np.array([[k for k in range(d + 1) if k != left] for left in range(d + 1)])
    shared = hull.simplices[one[:, None], rest[opposite]]  # (n_sides, d)
    pairs = np.concatenate([np.sort(shared[:, list(ends)], axis=1) for ends in combinations(range(d), 2)])
    repeats = len(pairs) // max(len(one), 1)
    begin, end = np.tile(corner[one], (repeats, 1)), np.tile(corner[other], (repeats, 1))
    wanted = pairs[:, 0] < n
    pairs, begin, end = pairs[wanted], begin[wanted], end[wanted]
    key = pairs[:, 0].astype(np.int64) * (int(hull.npoints) + 1) + pairs[:, 1]
    _, where, face = np.unique(key, return_index=True, return_inverse=True)
    size = _lengths(begin, end, face) if d == 2 else _areas(begin, end, face)
    a, b = pairs[where].T
    back = b < n
    return np.concatenate([a, b[back]]), np.concatenate([b, a[back]]), np.concatenate([size, size[back]])


def _lengths(begin: np.ndarray, end: np.ndarray, face: np.ndarray) -> np.ndarray:
    return np.bincount(face, weights=np.linalg.norm(end - begin, axis=1))


def _areas(begin: np.ndarray, end: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Of convex polygons from their sides, which may come in any order: triangles about a point inside."""
    sums = [np.bincount(face, weights=axis) for axis in (0.5 * (begin + end)).T]
    middle = np.stack(sums, axis=1) / np.bincount(face)[:, None]
    cross = np.cross(begin - middle[face], end - middle[face])
    return np.bincount(face, weights=0.5 * np.linalg.norm(cross, axis=1))

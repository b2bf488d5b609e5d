"""Closed pores: room between colloids out of which no swimmer finds a way, as surfaces all around are too close.

A swimmer's centre keeps a least height above every colloid, so it moves outside of a union of larger spheres. What is
outside is connected as the simplices of their regular triangulation (that of power distances) that are not in its
weighted alpha complex are, across faces that are not in it either: H. Edelsbrunner, Discrete Comput. Geom. 13, 415
(1995). Exact for any radii, and no grid has to resolve narrow gaps. A part of the field is looked at, with its
surroundings: what is closed there is closed in all of it, as further colloids can only close more. Lengths in a.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from porous_swim.obstacles.field import ObstacleField

_MOST = {2: 4000, 3: 3000}  # colloids and images that are looked at
_CORE = 0.5  # of the edges of what is looked at: where points are drawn
_POINTS = 2000  # of the room that a centre can enter, or fewer
_TINY = 1e-8  # of the squared size of what is looked at: what just touches is open, and ties are decided


class _Simplices(NamedTuple):
    """The regular triangulation of spheres: lower facets of the hull of lifted centres."""

    corners: np.ndarray  # (n, d + 1) spheres
    neighbours: np.ndarray  # (n, d + 1) simplices across the face opposite to each corner; -1 at the outside
    planes: np.ndarray  # (n, d + 1) height above x: planes[:, :d] @ x + planes[:, d]


def closed_share(field: ObstacleField, clearance: float) -> float:
    """Share of the room that a centre can enter, at least `clearance` above every surface, that is in closed pores.

    At least so much is closed: a pore that reaches the margin of what is looked at counts as open. 0 where there is
    no such room. It is found from points drawn at random, always the same, within some 0.02.
    """
    d = field.dimensions
    if not _narrow(field, clearance):
        return 0.0
    place, radius, middle, half = _block(field, clearance)
    scale = float(half.max())
    # no two squared radii are the same, and none is larger than it is
    square = (radius / scale) ** 2 - _TINY * (1.0 + np.random.default_rng(0).random(len(radius)))
    try:
        found = _triangulated(place / scale, square)
        closed = _closed(found, place / scale, square)
    except (QhullError, ValueError, np.linalg.LinAlgError):  # too few, or all in a line or in a plane
        return 0.0
    points = (2.0 * np.random.default_rng(1).random((4 * _POINTS, d)) - 1.0) * _CORE * half
    height = field.nearest(np.pad(points + middle, ((0, 0), (0, 3 - d))))[2]
    free = points[height > clearance][:_POINTS] / scale
    inside = [int(np.argmax(found.planes @ point)) for point in np.c_[free, np.ones(len(free))]]
    return float(np.mean(closed[inside])) if inside else 0.0


def _narrow(field: ObstacleField, clearance: float) -> bool:
    """Whether any gap is too narrow for a centre to pass."""
    gaps = field.nearest_gaps()
    if len(gaps) == 0:
        return False
    own = field.box[field.box > 0.0].min(initial=np.inf) - 2.0 * field.radii.max()  # to its own image
    return bool(min(gaps.min(), own) < 2.0 * clearance * (1.0 - 1e-9))


def _block(field: ObstacleField, clearance: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Colloids and images in a block: centres (n, d) from its middle, grown radii (n,), middle and half edges (d,)."""
    d, edges = field.dimensions, field.box[: field.dimensions]
    centers, repeats = field.centers[:, :d], edges > 0.0
    size = np.where(repeats, 3.0 * edges, np.ptp(centers, axis=0))  # a box and its images around it
    middle = np.where(repeats, 0.5 * edges, centers.min(axis=0) + 0.5 * size)
    n = len(centers) * 3.0 ** int(repeats.sum())
    half = 0.5 * size * min(1.0, (_MOST[d] / n) ** (1.0 / d)) * (1.0 + 1e-9)
    places, radii = [], []
    for shift in product(*((-1, 0, 1) if repeat else (0,) for repeat in repeats)):
        moved = centers + np.array(shift) * edges - middle
        within = np.all(np.abs(moved) <= half, axis=1)
        places.append(moved[within])
        radii.append(field.radii[within] + clearance)
    return np.concatenate(places), np.concatenate(radii), middle, half


def _triangulated(place: np.ndarray, square: np.ndarray) -> _Simplices:
    """The regular triangulation of spheres at `place` (n, d) with `square` (n,) radii."""
    hull = ConvexHull(np.c_[place, np.sum(place**2, axis=1) - square])
    lower = hull.equations[:, -2] < -1e-6  # sizes are 1: facets at the margin may stand upright
    number = np.where(lower, np.cumsum(lower) - 1, -1)
    equations = hull.equations[lower]
    planes = -np.c_[equations[:, :-2], equations[:, -1]] / equations[:, [-2]]
    return _Simplices(hull.simplices[lower], number[hull.neighbors[lower]], planes)


def _closed(found: _Simplices, place: np.ndarray, square: np.ndarray) -> np.ndarray:
    """(n_simplices,) whether each belongs to a pore that is closed all around; False for those full of colloids."""
    n, k = found.corners.shape
    size = _orthosphere(place[found.corners], square[found.corners])[1]
    empty = size > 0.0
    faces, others = [], []
    for corner in range(k):  # the face opposite to it
        face = np.delete(found.corners, corner, axis=1)
        other = found.neighbours[:, corner]
        middle, least = _orthosphere(place[face], square[face])
        apex = found.corners[:, corner]
        attached = np.sum((middle - place[apex]) ** 2, axis=1) - square[apex] < least
        beyond = np.arange(n)[:, None] == found.neighbours[other]  # which face of the other it is
        far = found.corners[other][np.arange(n), np.argmax(beyond, axis=1)]
        attached |= np.sum((middle - place[far]) ** 2, axis=1) - square[far] < least
        passable = empty & ((least > 0.0) | attached) & ((other < 0) | empty[other])
        faces.append(np.flatnonzero(passable))
        others.append(other[passable])
    first, second = np.concatenate(faces), np.concatenate(others)
    outside = n  # a node for all that is beyond the margin
    second = np.where(second < 0, outside, second)
    graph = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(n + 1, n + 1))
    pore = connected_components(graph, directed=False)[1]
    return np.asarray(empty & (pore[:n] != pore[outside]))


def _orthosphere(place: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre (n, d) and squared radius (n,) of the least spheres orthogonal to k spheres each, (n, k, d) and (n, k)."""
    edge = place[:, 1:] - place[:, :1]
    right = 0.5 * (np.sum(edge**2, axis=2) - square[:, 1:] + square[:, :1])
    gram = edge @ np.swapaxes(edge, 1, 2)
    step = np.einsum("ni,nid->nd", np.linalg.solve(gram, right[:, :, None])[:, :, 0], edge)
    return place[:, 0] + step, np.sum(step**2, axis=1) - square[:, 0]

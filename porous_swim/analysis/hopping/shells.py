"""Whether distances between the centres of colloids fall into shells, as in a lattice, and where these end. In a."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from scipy.spatial import cKDTree

from porous_swim.analysis.places import centers_of, tiled, wrapped

LEAST_GAP = 0.05  # of the distance at which it begins: lattices that a picture has stretched by less keep their shells
LEAST_GAP_OF_SHELL = 0.5  # of the width of the shell before it: neighbours scatter less than shells are apart
MOST_WIDTH = 0.75  # of the distance at which a shell begins: wider, all that are few would be one
_N_NEAREST = 32  # three shells and more of any lattice
_MOST_IMAGES = 10  # of each colloid, where they are many
_MOST_CENTERS = 20_000  # to look around from: more tell no more


@dataclass(frozen=True)
class ShellEnds:
    """Distances, a, up to which centres are nearest and second-nearest neighbours; NaN where no gap tells."""

    first: float
    second: float


def shell_ends(colloids: pa.Table, *, box: tuple[float, float, float]) -> ShellEnds:
    """The ends of the first two shells of neighbours, in the middle of the gaps behind them.

    All distances of a field are looked at together. A shell ends at a gap without any, of 5 % of the distance or more
    and half as wide as the shell, once every colloid has a neighbour within it, and is at most 3/4 as wide as the
    distance at which it begins. So vacancies, and centres that are known to some per cent of their spacing, leave
    shells what they are; centres in disorder have none.
    """
    found = _nearest_distances(centers_of(colloids), np.asarray(box))
    if found.size == 0:
        return ShellEnds(math.nan, math.nan)
    # beyond the last neighbour found of any colloid some distances are missing, unless all were found
    all_found = found.shape[1] < _N_NEAREST
    distance = np.sort(found, axis=None) if all_found else np.sort(found[found <= np.min(found[:, -1])])
    distance = np.append(distance, math.inf) if all_found else distance
    first = _end_of_shell(distance, begin=0, least=float(np.max(found[:, 0])))
    if first is None:
        return ShellEnds(math.nan, math.nan)
    second = _end_of_shell(distance, begin=first + 1, least=0.0)
    return ShellEnds(_middle(distance, first), math.nan if second is None else _middle(distance, second))


def _end_of_shell(distance: np.ndarray, *, begin: int, least: float) -> int | None:
    """Number of the last of increasing distances (n,) in the shell that begins at one, and ends at `least` or later."""
    inside = distance[begin:-1]
    gap = np.diff(distance[begin:])
    width = inside - inside[:1]
    ends = (gap >= LEAST_GAP * inside) & (gap >= LEAST_GAP_OF_SHELL * width) & (width <= MOST_WIDTH * inside[:1])
    ends = np.flatnonzero(ends & (inside >= least))
    return begin + int(ends[0]) if len(ends) else None


def _middle(distance: np.ndarray, last: int) -> float:
    """In the gap after a distance, of which the last may be infinite."""
    return float(min(0.5 * (distance[last] + distance[last + 1]), 2.0 * distance[last]))


def _nearest_distances(centers: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Distances from centres (all, or some of very many) to their nearest others and images, (n, k), increasing."""
    n, repeats = len(centers), edges > 0.0
    if n == 0 or (n == 1 and not repeats.any()):
        return np.zeros((0, 0))
    inside, _ = wrapped(centers, edges)
    some = inside[:: -(-n // _MOST_CENTERS)]
    if not repeats.any():
        k = min(_N_NEAREST, n - 1)
        return np.asarray(cKDTree(inside).query(some, k=range(2, k + 2))[0])
    reach = 2.0 * (float(np.prod(edges[repeats])) / n) ** (1.0 / int(repeats.sum()))
    while True:
        points, _, _ = tiled(inside, edges, np.full(3, reach))
        if len(points) > max(_MOST_IMAGES * n, _MOST_CENTERS):  # a colloid is far from all others: there are no shells
            return np.zeros((0, 0))
        if len(points) > _N_NEAREST:
            found = np.asarray(cKDTree(points).query(some, k=range(2, _N_NEAREST + 2))[0])  # the first is itself
            if float(np.max(found[:, -1])) <= reach:  # else an image that was left out may be nearer
                return found
        reach *= 1.5

"""Random sequential addition of spheres in a periodic box."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from porous_swim.obstacles.nearest import wrap

_MOST_ROUNDS_WITHOUT_ROOM = 20  # of _FEWEST_TRIES each: then the rest of the room is a 1e-6 of the box
_FEWEST_TRIES = 50_000
_MOST_TRIES, _MOST_TRIES_EACH = 10_000_000, 100  # of all spheres, or of each if that is more: half a minute for 10^4


def insert(radii: np.ndarray, box: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return centres (m, d) of spheres of `radii` (n,) in `box` (d,); m < n where no room is left, or hardly any.

    Equal radii stand together. Trial places are uniform; a sphere that overlaps an earlier one is dropped and
    tried elsewhere. Whole rounds of trials are tested at once; of two that overlap the earlier one stands, so
    the law is that of one by one.
    """
    placed, left = np.zeros((0, len(box))), max(_MOST_TRIES, _MOST_TRIES_EACH * len(radii))
    for value, count in _runs(radii):
        goal, barren = len(placed) + count, 0
        while len(placed) < goal and barren < _MOST_ROUNDS_WITHOUT_ROOM and left > 0:
            tries = max(2 * (goal - len(placed)), _FEWEST_TRIES if barren else 1000)
            left -= tries
            fresh = wrap(rng.random((tries, len(box))) * box, box)
            fresh = fresh[_free_of(fresh, value, placed, radii[: len(placed)], box)]
            fresh = fresh[_free_of_earlier(fresh, value, box)]
            barren = 0 if len(fresh) else barren + 1
            placed = np.concatenate([placed, fresh[: goal - len(placed)]])
        if len(placed) < goal:
            break
    return placed


def _runs(radii: np.ndarray) -> list[tuple[float, int]]:
    starts = np.flatnonzero(np.r_[True, radii[1:] != radii[:-1]])
    return [(float(radii[i]), int(n)) for i, n in zip(starts, np.diff(np.r_[starts, len(radii)]), strict=True)]


def _free_of(fresh: np.ndarray, radius: float, placed: np.ndarray, radii: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return which of `fresh` keep clear of all `placed` spheres."""
    free = np.ones(len(fresh), dtype=bool)
    for value in np.unique(radii):  # one tree per radius: there the nearest centre is the nearest surface
        distance, _ = KDTree(placed[radii == value], boxsize=box).query(fresh[free])
        free[free] = distance >= value + radius
    return free


def _free_of_earlier(fresh: np.ndarray, radius: float, box: np.ndarray) -> np.ndarray:
    """Return which of `fresh` keep clear of those before them that stand themselves."""
    stands = np.ones(len(fresh), dtype=bool)
    pairs = KDTree(fresh, boxsize=box).query_pairs(2.0 * radius, output_type="ndarray")
    # In the order of the later one; its fate is settled before it can drop others, all of them later still.
    for early, late in pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]:
        if stands[early]:
            stands[late] = False
    return stands

"""Gaps between neighbouring colloids through which a swimmer does not pass."""

from __future__ import annotations

import numpy as np

from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.nearest import NearestSphere


def narrow_gaps(field: ObstacleField, width: float) -> np.ndarray:
    """Return the gaps (n,), in a, between surfaces that are less than `width` apart, each pair of colloids once.

    Pairs over the edges of a periodic box count, too, a colloid and its own image included; 0 where surfaces touch or
    overlap. A wall has no gaps.
    """
    centers, radii = field.centers, field.radii
    if len(radii) == 0 or not np.all(np.isfinite(radii)):
        return np.zeros(0)
    spheres = NearestSphere(centers, radii, field.box)
    found = [np.zeros(0)]
    size = np.floor(np.log2(radii))
    for value in np.unique(size):  # of like radius: one large colloid does not widen the search around all others
        members = np.flatnonzero(size == value)
        point, other, offset = spheres.near(centers[members], float(radii[members].max()) + width)
        distance = np.linalg.norm(offset, axis=1)
        itself = (members[point] == other) & (distance == 0.0)
        gap = distance - radii[members[point]] - radii[other]
        found.append(gap[(gap < width) & ~itself])
    gaps = np.sort(np.concatenate(found))[::2]  # each pair was found from both ends
    return np.maximum(gaps, 0.0)

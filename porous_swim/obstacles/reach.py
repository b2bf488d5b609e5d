"""What no index of the colloids can hold, told from counts and edges alone, before any of its work is done."""

from __future__ import annotations

from math import pi

import numpy as np

from porous_swim.core.parts import KeyedError
from porous_swim.obstacles.cells import CELLS_PER_COLLOID, MAX_CELLS_PER_AXIS, MOST_IMAGES
from porous_swim.obstacles.field import ObstacleField

_MOST_ELONGATED = 20 * MAX_CELLS_PER_AXIS  # beyond, even the shortest cells are many times as long as the box is wide
_SWIMMER, _MOST_TOUCHED = 1.0, 1000  # a, and colloids within that of a point: more of them are no obstacles but a fluid
_MOST_CANDIDATES = 5e7  # colloids in the lists of all cells: some gigabytes while they are made


def check_reach(field: ObstacleField, escape_height: float) -> None:
    """Raise a `KeyedError` where the box is too long, or the escape height reaches too many colloids at once."""
    edges = field.box[field.box > 0.0]
    if len(edges) == 0 or len(field.radii) == 0:
        return
    shortest, longest = float(edges.min()), float(edges.max())
    if longest > _MOST_ELONGATED * shortest:
        raise KeyedError(
            "domain.size",
            f"the box is {longest:.3g} long and {shortest:.3g} wide: expected at most {_MOST_ELONGATED:,} times as "
            "long as wide",
        )
    key = "encounter.escape_height"
    if escape_height > MOST_IMAGES * shortest:
        raise KeyedError(
            key,
            f"expected at most {MOST_IMAGES} times the shortest edge of the box ({shortest:.3g}), found "
            f"{escape_height:g}",
        )
    d, n = field.dimensions, len(field.radii)
    touched = _within(field, edges, _SWIMMER)
    if touched > _MOST_TOUCHED:
        raise KeyedError(
            "obstacles",
            f"a swimmer touches about {touched:.2g} colloids at once, images included: expected at most "
            f"{_MOST_TOUCHED:,}, so larger colloids, fewer, or a larger box",
        )
    within = _within(field, edges, escape_height)
    if within * CELLS_PER_COLLOID[d] * n > _MOST_CANDIDATES:
        raise KeyedError(
            key,
            f"{escape_height:g} reaches about {within:.2g} of {n:,} colloids at once: expected a height within which a "
            f"swimmer meets at most {_MOST_CANDIDATES / (CELLS_PER_COLLOID[d] * n):.2g}",
        )


def _within(field: ObstacleField, edges: np.ndarray, height: float) -> float:
    """Return about how many colloids and images have their surface within `height` of a point."""
    reach = height + float(np.mean(field.radii))
    ball = pi * reach**2 if field.dimensions == 2 else 4.0 / 3.0 * pi * reach**3
    return len(field.radii) / float(np.prod(edges)) * ball

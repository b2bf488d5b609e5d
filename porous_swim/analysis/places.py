"""Where the colloids of a table are, and their periodic images. Lengths in a."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, vectors
from porous_swim.core.errors import ResultsError


def centers_of(colloids: pa.Table) -> np.ndarray:
    """Centres by colloid number, (n_colloids, 3); the rows may come in any order."""
    return vectors(colloids, "x", "y", "z")[np.argsort(column(colloids, "colloid"))]


def radii_of(colloids: pa.Table) -> np.ndarray:
    """Radii by colloid number, (n_colloids,); the rows may come in any order."""
    return column(colloids, "radius")[np.argsort(column(colloids, "colloid"))]


def all_round(colloids: pa.Table) -> bool:
    """Whether swimmers can go round every colloid: a plane wall is a colloid of infinite radius."""
    return not np.any(np.isinf(radii_of(colloids)))


def own_name(colloids: pa.Table) -> str | None:
    """What the one obstacle is called in place of a colloid; None where all are colloids."""
    return None if all_round(colloids) else "a plane wall"


def sphere_radii_of(colloids: pa.Table) -> np.ndarray:
    """Radii where offsets from centres must mean something; `ResultsError` for a plane wall."""
    if not all_round(colloids):
        raise ResultsError(
            f"colloids: found {own_name(colloids)}, which has no centre; this statistic is one of spheres"
        )
    return radii_of(colloids)


def wrapped(centers: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) moved into a box with edges (3,), 0 along an axis that does not repeat, and by how many (n, 3)."""
    moved = np.floor(np.divide(centers, edges, out=np.zeros_like(centers), where=edges > 0.0)).astype(int)
    return centers - moved * edges, moved


def tiled(centers: np.ndarray, edges: np.ndarray, margins: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres (n, 3) in a box and their images up to `margins` (3,) outside it along the axes that repeat.

    Returns points (m, 3), the centres themselves first; of which centre each is an image, (m,); and of which image,
    (m, 3).
    """
    points, base, image = centers, np.arange(len(centers)), np.zeros((len(centers), 3), int)
    for axis in np.flatnonzero(edges > 0.0):
        edge, reach = edges[axis], int(np.ceil(margins[axis] / edges[axis]))
        numbers = np.array([0, *(sign * k for k in range(1, reach + 1) for sign in (-1, 1))])
        steps = np.zeros((len(numbers), 3), int)
        steps[:, axis] = numbers
        points, base = (points[None] + (steps * edges)[:, None]).reshape(-1, 3), np.tile(base, len(numbers))
        image = (image[None] + steps[:, None]).reshape(-1, 3)
        inside = (points[:, axis] >= -margins[axis]) & (points[:, axis] <= edge + margins[axis])
        points, base, image = points[inside], base[inside], image[inside]
    return points, base, image

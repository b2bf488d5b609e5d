"""Colloids in pictures of a plane, with their periodic images."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import EllipseCollection

_FACE, _EDGE = "#dfe3ea", "#9aa3b2"


def colloid_discs(axis: Any, centers: np.ndarray, radii: np.ndarray, *, alpha: float = 1.0) -> None:
    """Discs at centres (n, 2) of radii (n,), a."""
    discs = EllipseCollection(
        2.0 * radii, 2.0 * radii, np.zeros(len(radii)), units="xy", offsets=centers,
        offset_transform=axis.transData, facecolor=_FACE, edgecolor=_EDGE, linewidth=0.5, alpha=alpha, zorder=1.0,
    )  # fmt: skip
    axis.add_collection(discs)


def images_in(
    centers: np.ndarray, radii: np.ndarray, *, box: tuple[float, float], low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (m, 2) and radii (m,) of colloids (n, 2), (n,) and images that reach into the rectangle low to high (2,).

    `box` has the edges after which they repeat, 0 for none. Of those behind each other, in three dimensions, one stays.
    """
    reach = float(radii.max(initial=0.0))
    for axis in (0, 1):
        if len(radii) == 0:
            break
        if box[axis] > 0.0:
            first = int(np.floor((low[axis] - reach - centers[:, axis].max()) / box[axis]))
            last = int(np.ceil((high[axis] + reach - centers[:, axis].min()) / box[axis]))
            number, step = np.arange(first, last + 1), np.eye(2)[axis] * box[axis]
            centers = (centers[None] + number[:, None, None] * step).reshape(-1, 2)
            radii = np.tile(radii, len(number))
        inside = (centers[:, axis] + radii > low[axis]) & (centers[:, axis] - radii < high[axis])
        centers, radii = centers[inside], radii[inside]
    rows = np.unique(np.round(np.column_stack([centers, radii]), 6), axis=0)
    return rows[:, :2], rows[:, 2]

"""The nearest of many spheres by surface distance, exact on the host, in open and periodic boxes.

A k-d tree finds nearest centres, not nearest surfaces. The spheres are therefore sorted into classes whose
radii differ by less than a factor of two; in each the search widens until no sphere left out can be nearer.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import ceil

import numpy as np
from scipy.spatial import KDTree


@dataclass(frozen=True)
class _SizeClass:
    members: np.ndarray  # (n,) indices of the spheres
    radii: np.ndarray  # (n,)
    tree: KDTree


class NearestSphere:
    """Search over spheres: centres (n, 3), radii (n,), box (3,) with edge 0 where nothing repeats."""

    def __init__(self, centers: np.ndarray, radii: np.ndarray, box: np.ndarray):
        """Build one tree for each class of sizes."""
        self.centers, self.radii, self.box = centers, radii, box
        size = np.floor(np.log2(radii)) if len(radii) else np.zeros(0)
        self._classes = []
        for value in np.unique(size):
            members = np.flatnonzero(size == value)
            tree = KDTree(self._wrapped(centers[members]), boxsize=box)
            self._classes.append(_SizeClass(members, radii[members], tree))

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return index (n,), image (n, 3) and height above the surface (n,) of the nearest sphere."""
        index, height = self._search(points, excluded=None)
        image = np.zeros((len(points), 3), dtype=np.int64)
        if len(self.radii):
            image = self._image(points - self.centers[index])
            # The tree's distances lose digits far from the origin: measure from the image itself.
            offset = points - (self.centers[index] + image * self.box)
            height = np.linalg.norm(offset, axis=1) - self.radii[index]
        return index, image, height

    def nearest_other(self) -> tuple[np.ndarray, np.ndarray]:
        """Return for each sphere the one with the nearest surface (-1: none), and the gap to it (n,)."""
        index, height = self._search(self.centers, excluded=np.arange(len(self.radii)))
        return index, height - self.radii

    def near(self, points: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return point (m,), sphere (m,) and offset (m, 3) for all images with a height below `height`."""
        wrapped = self._wrapped(points)
        found = [(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 3)))]
        for size in self._classes:
            rows = size.tree.query_ball_point(wrapped, height + size.radii.max())
            counts = np.array([len(row) for row in rows], dtype=np.int64)
            if counts.sum() == 0:
                continue
            point = np.repeat(np.arange(len(points)), counts)
            sphere = size.members[np.concatenate([np.asarray(row, dtype=np.int64) for row in rows if row])]
            offset = points[point] - self.centers[sphere]
            offset -= self._image(offset) * self.box
            for shift in self._shifts(height + float(size.radii.max())):
                shifted = offset - shift
                close = np.linalg.norm(shifted, axis=1) - self.radii[sphere] < height
                found.append((point[close], sphere[close], shifted[close]))
        point, sphere, offset = (np.concatenate(part) for part in zip(*found, strict=True))
        return point, sphere, offset

    def _search(self, points: np.ndarray, excluded: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        wrapped = self._wrapped(points)
        best = np.full(len(points), np.inf)
        index = np.full(len(points), -1, dtype=np.int64)
        for size in self._classes:
            pending, k = np.arange(len(points)), 2
            while len(pending):
                distance, row = (np.asarray(part) for part in size.tree.query(wrapped[pending], k=k))
                there = np.isfinite(distance)  # the tree pads rows with infinity where it runs out of spheres
                row = np.where(there, row, 0)
                height = np.where(there, distance - size.radii[row], np.inf)
                if excluded is not None:
                    height[size.members[row] == excluded[pending, None]] = np.inf
                column = height.argmin(axis=1)
                lines = np.arange(len(pending))
                better = height[lines, column] < best[pending]
                best[pending[better]] = height[lines, column][better]
                index[pending[better]] = size.members[row[lines, column]][better]
                # Spheres further down the list lie at least distance - largest radius away.
                pending = pending[distance[:, -1] - size.radii.max() < best[pending]]
                k *= 4
        return index, best

    def _image(self, offset: np.ndarray) -> np.ndarray:
        edge = np.where(self.box > 0.0, self.box, np.inf)
        return np.asarray(np.rint(offset / edge), dtype=np.int64)

    def _shifts(self, reach: float) -> list[np.ndarray]:
        # An offset to the nearest image is within half an edge: images further than reach + edge/2 are out.
        ranges = [ceil(reach / edge + 0.5) if edge > 0.0 else 0 for edge in self.box]
        return [np.array(shift) * self.box for shift in product(*(range(-n, n + 1) for n in ranges))]

    def _wrapped(self, points: np.ndarray) -> np.ndarray:
        return wrap(points, self.box)


def wrap(points: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return (n, 3) `points` moved into [0, box) along every axis that repeats."""
    edge = np.where(box > 0.0, box, 1.0)
    inside = np.where(box > 0.0, points - np.floor(points / edge) * edge, points)
    return np.where((box > 0.0) & (inside >= edge), 0.0, inside)  # -1e-17 + edge rounds to edge

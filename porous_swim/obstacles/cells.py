"""A cell index of the colloids: for each cell, all that can be nearest, second nearest or touched anywhere in it.

Built once on the host. With q the middle of a cell, delta its half diagonal and d_j(q) the distance from q to the
surface of colloid j, the cell lists every j with d_j(q) <= max(d_second(q), reach) + 2 delta: whoever is nearest or
second nearest to a point of the cell, or nearer to it than `reach`, is in the list, whatever the radii. The list is in
the order of d_j(q): nobody behind a j with d_j(q) - delta beyond the second nearest found so far can be nearer.

Centres are kept in fixed point, 2^52 units to an edge of the box: differences of centres are then exact
integers, periodic images are exact shifts, and no position loses digits in a large box.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from porous_swim.errors import SceneError
from porous_swim.obstacles.field import ObstacleField

FIXED_BITS = 52
CELLS_PER_COLLOID = {2: 8, 3: 4}
MAX_CELLS_PER_AXIS = 1024  # cell numbers are made from 52-bit positions in 64-bit integers
MOST_IMAGES = 100  # in either direction: an image number has 8 bits
ROUNDING = 1e-6  # of lengths, some times that of single precision
ANCHOR_RADIUS = -1e6  # an empty field has one sphere at the origin that nobody can reach


@dataclass(frozen=True)
class CellIndex:
    """What the search on the device reads. `edge` and `origin` are those of the indexed region."""

    center: np.ndarray  # (n_colloids, 3) int64, fixed point within the region
    radius: np.ndarray  # (n_colloids,) float64, a
    origin: np.ndarray  # (3,) float64, a; lower corner of the region
    edge: np.ndarray  # (3,) float64, a; 1 along z in two dimensions
    periodic: np.ndarray  # (3,) int32; whether the region repeats along the axis
    n_cells: np.ndarray  # (3,) int32
    first: np.ndarray  # (n_cells + 1,) int32; where a cell's candidates begin
    candidate: np.ndarray  # (n_candidates,) int32; colloid
    shift: np.ndarray  # (n_candidates,) int32; periodic image, 8 bits an axis, each stored plus 128
    least: np.ndarray  # (n_candidates,) float64, a; no point of the cell is nearer to the surface, rounding allowed for

    @property
    def longest(self) -> float:
        """The longest offset that a search meets near a colloid: sets the rounding of distances."""
        return float(np.linalg.norm(self.edge / self.n_cells) + 2.0 * np.abs(self.radius).max())


def build_cells(field: ObstacleField, *, reach: float) -> CellIndex:
    """Index `field`; every colloid whose surface is within `reach` of a point is in the list of its cell."""
    centers, radii = field.centers, np.where(np.isinf(field.radii), 0.0, field.radii)  # a wall is its own centre
    if len(radii) == 0:
        centers, radii = np.zeros((1, 3)), np.array([ANCHOR_RADIUS])
    axes = np.arange(3) < field.dimensions
    periodic = field.box > 0.0
    origin, edge = _region(centers, radii, field.box, axes, periodic)
    n_cells = _cell_counts(edge, axes, len(radii), field)
    middle = _cell_middles(origin, edge, n_cells, axes)
    half_diagonal = 0.5 * float(np.linalg.norm((edge / n_cells)[axes])) * (1.0 + 1e-6)
    repeat = np.where(periodic, edge, 0.0)
    wrapped = np.where(periodic, centers % np.where(periodic, edge, 1.0), centers)  # a periodic region starts at 0
    first, candidate, shift, distance = _candidates(middle, half_diagonal, reach, wrapped, radii, repeat)
    least = distance - half_diagonal
    least -= ROUNDING * (np.abs(least) + np.abs(radii[candidate]) + half_diagonal)
    fixed = np.rint((centers - origin) / edge * 2.0**FIXED_BITS).astype(np.int64)
    fixed[:, periodic] %= 1 << FIXED_BITS
    fixed[:, ~axes] = 0
    return CellIndex(
        fixed, radii.astype(np.float64), origin, edge, periodic.astype(np.int32), n_cells.astype(np.int32),
        first, candidate, shift, least,
    )  # fmt: skip


def _region(centers, radii, box, axes, periodic):
    """Lower corner and edges of the indexed region: the box, or the colloids and a margin around them."""
    margin = np.abs(radii[:, None]) * (radii[:, None] > 0) + 4.0
    low, high = (centers - margin).min(axis=0), (centers + margin).max(axis=0)
    origin = np.where(periodic | ~axes, 0.0, low)
    edge = np.where(periodic, box, np.where(axes, high - low, 1.0))
    return origin, edge


def _cell_counts(edge, axes, n_colloids, field):
    """Nearly cubic cells, a few for each colloid; one where there is a single colloid without images."""
    if n_colloids == 1 and not field.periodic:
        return np.ones(3, dtype=np.int64)
    d = field.dimensions
    size = (np.prod(edge[axes]) / (CELLS_PER_COLLOID[d] * n_colloids)) ** (1.0 / d)
    counts = np.clip(np.ceil(edge / size), 1, MAX_CELLS_PER_AXIS).astype(np.int64)
    return np.where(axes, counts, 1)


def _cell_middles(origin, edge, n_cells, axes):
    """(n_cells, 3) middles, the last axis running fastest; z = 0 in two dimensions."""
    ticks = [
        origin[d] + (np.arange(n_cells[d]) + 0.5) * edge[d] / n_cells[d] if axes[d] else np.zeros(1) for d in range(3)
    ]
    return np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)


def _candidates(middle, half_diagonal, reach, centers, radii, edge):
    """Compressed rows of candidates for each cell, nearest surface first."""
    n_images = np.where(edge > 0.0, 1, 0)
    while True:  # more images until none beyond them can matter
        ghost, owner, image = _ghosts(centers, edge, n_images)
        bound = np.maximum(_second_distance(middle, ghost, radii[owner]), reach) + 2.0 * half_diagonal
        bound = np.where(np.isfinite(bound), bound, np.inf)
        far = bound.max() + radii.max() + half_diagonal
        needed = (
            np.where(edge > 0.0, np.ceil(far / np.where(edge > 0.0, edge, 1.0)), 0) if np.isfinite(far) else n_images
        )
        if np.all(needed <= n_images):
            break
        if np.any(needed > MOST_IMAGES):
            raise SceneError(
                f"domain.size: the box is too long for its width: a swimmer may be {far:.3g} from the second nearest "
                f"colloid, across more than {MOST_IMAGES} periodic images"
            )
        n_images = needed.astype(int)
    return _lists(middle, bound, ghost, owner, image, radii)


def _ghosts(centers, edge, n_images):
    """All images of the colloids up to `n_images` boxes away: positions, owners, image numbers."""
    shifts = np.array(list(product(*(range(-int(n), int(n) + 1) for n in n_images))), dtype=np.int64)
    ghost = (centers[None, :, :] + (shifts * edge)[:, None, :]).reshape(-1, 3)
    owner = np.tile(np.arange(len(centers)), len(shifts))
    return ghost, owner, np.repeat(shifts, len(centers), axis=0)


def _second_distance(middle, ghost, radius):
    """(n_cells,) bound of the distance from each middle to the second nearest surface, inf where there is none."""
    best = np.full((len(middle), 2), np.inf)
    edges = np.unique(np.quantile(radius, np.linspace(0.0, 1.0, 9)))
    for group in np.unique(
        np.searchsorted(edges, radius)
    ):  # colloids of like radius: their nearest centres are nearest surfaces
        member = np.flatnonzero(np.searchsorted(edges, radius) == group)
        distance, index = cKDTree(ghost[member]).query(middle, k=[1, 2], workers=-1)
        surface = distance - radius[member[np.minimum(index, len(member) - 1)]]
        best = np.sort(np.concatenate([best, surface], axis=1), axis=1)[:, :2]
    return best[:, 1]


def _lists(middle, bound, ghost, owner, image, radii):
    if len(ghost) <= 2:
        bound = np.full(len(middle), 1e300)
    tree = cKDTree(ghost)
    rows = tree.query_ball_point(middle, np.minimum(bound + radii.max(), 1e300), workers=-1)
    length = np.fromiter((len(row) for row in rows), dtype=np.int64, count=len(rows))
    index = np.concatenate([np.asarray(row, dtype=np.int64) for row in rows])
    cell = np.repeat(np.arange(len(middle)), length)
    distance = np.linalg.norm(middle[cell] - ghost[index], axis=1) - radii[owner[index]]
    keep = distance <= bound[cell]
    cell, index, distance = cell[keep], index[keep], distance[keep]
    order = np.lexsort((index, distance, cell))
    cell, index = cell[order], index[order]
    first = np.searchsorted(cell, np.arange(len(middle) + 1)).astype(np.int32)
    packed = ((image[index] + 128) << np.array([0, 8, 16])).sum(axis=1)
    return first, owner[index].astype(np.int32), packed.astype(np.int32), distance[order]

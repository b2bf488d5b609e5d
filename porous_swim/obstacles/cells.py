"""A cell index of the colloids: for each cell, all that can be nearest, second nearest or touched anywhere in it.

Built once on the host. With q the middle of a cell, delta its half diagonal and d_j(q) the distance from q to the
surface of colloid j, the cell lists every j with d_j(q) <= max(d_second(q), reach) + 2 delta: whoever is nearest or
second nearest to a point of the cell, or nearer to it than `reach`, is in the list, whatever the radii. The list is in
the order of d_j(q): nobody behind a j with d_j(q) - delta beyond the second nearest found so far can be nearer.

Centres are kept in fixed point, 2^52 units to an edge of the box: differences of centres are then exact
integers, periodic images are exact shifts, and no position loses digits in a large box.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import chain, product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from porous_swim.core.errors import SceneError
from porous_swim.core.machine import usable_processors
from porous_swim.obstacles.field import ObstacleField

FIXED_BITS = 52
CELLS_PER_COLLOID = {2: 8, 3: 4}
MAX_CELLS_PER_AXIS = 1024  # cell numbers are made from 52-bit positions in 64-bit integers
MOST_IMAGES = 100  # in either direction: an image number has 8 bits
MARGIN = 3.0  # distances from colloid to colloid within which images are taken first
MOST_CANDIDATES = 2**31 - 1
FEWER = "give fewer colloids, or a smaller encounter.escape_height"
CELLS_AT_ONCE = 1 << 14  # whose candidates are found and sorted together
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


class _Ghosts(NamedTuple):
    """Images of colloids: where they are, of which they are, and in which box, packed as in `CellIndex.shift`."""

    place: np.ndarray  # (n_ghosts, 3) a
    owner: np.ndarray  # (n_ghosts,) int32
    image: np.ndarray  # (n_ghosts,) int32


def build_cells(field: ObstacleField, *, reach: float, threads: int | None = None) -> CellIndex:
    """Index `field`; every colloid whose surface is within `reach` of a point is in the list of its cell.

    `threads` are by default as many as this process may use. `SceneError` where the index does not fit into memory.
    """
    centers, radii = field.centers, field.at_surface
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
    threads = threads or usable_processors()
    try:
        first, candidate, shift, distance = _candidates(
            middle, half_diagonal, reach, wrapped, radii, repeat, threads=threads
        )
    except MemoryError:
        raise SceneError(
            f"obstacles: the cell index of {len(radii):,} colloids does not fit into memory: {FEWER}"
        ) from None
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


def _candidates(middle, half_diagonal, reach, centers, radii, edge, *, threads):
    """Compressed rows of candidates for each cell, nearest surface first."""
    repeats, largest = edge > 0.0, max(float(radii.max()), 0.0)
    shortest = float(edge[repeats].min(initial=math.inf))
    margin = min(shortest, MARGIN * _spacing(centers, edge) + largest)
    while True:  # a wider margin of images until none beyond it can matter
        ghosts = _ghosts(centers, edge, margin)
        second = _second_distance(middle, ghosts, radii, n_copies=3 ** int(repeats.sum()), threads=threads)
        bound = np.maximum(second, reach) + 2.0 * half_diagonal
        far = float(bound.max()) + float(radii.max()) + half_diagonal
        if far <= margin or not repeats.any():
            break
        if margin >= MOST_IMAGES * shortest:
            raise SceneError(
                f"domain.size: the box is too long for its width: a swimmer may be {far:.3g} from the second nearest "
                f"colloid, across more than {MOST_IMAGES} periodic images"
            )
        margin = min(far * (1.0 + 1e-9), 2.0 * margin, MOST_IMAGES * shortest)
    if len(ghosts.place) <= 2:
        bound = np.full(len(middle), 1e300)
    return _lists(middle, np.minimum(bound, 1e300), ghosts, radii, threads=threads)


def _spacing(centers, edge):
    """A length, about from a colloid to the next."""
    repeats = edge > 0.0
    return float((np.prod(edge[repeats]) / len(centers)) ** (1.0 / max(1, int(repeats.sum()))))


def _ghosts(centers, edge, margin):
    """All images of the colloids within `margin` of the box, box by box."""
    n_images = np.where(edge > 0.0, np.ceil(margin / np.where(edge > 0.0, edge, 1.0)), 0).astype(int)
    low, high = np.where(edge > 0.0, -margin, -np.inf), np.where(edge > 0.0, edge + margin, np.inf)
    places, owners, images = [], [], []
    for shift in product(*(range(-n, n + 1) for n in n_images)):
        place = centers + np.array(shift) * edge
        near = np.flatnonzero(np.all((place >= low) & (place <= high), axis=1))
        places.append(place[near])
        owners.append(near.astype(np.int32))
        images.append(np.full(len(near), sum((n + 128) << 8 * d for d, n in enumerate(shift)), dtype=np.int32))
    return _Ghosts(np.concatenate(places), np.concatenate(owners), np.concatenate(images))


def _second_distance(middle, ghosts, radii, *, n_copies, threads):
    """(n_cells,) bound of the distance from each middle to the second nearest surface, inf where there is none."""
    best = np.full((len(middle), 2), np.inf)
    # colloids of like radius, divided by eighths of all in boxes `n_copies` together: nearest centres, nearest surfaces
    rank = ((len(radii) * n_copies - 1) * np.linspace(0.0, 1.0, 9)).astype(int) // n_copies
    group = np.searchsorted(np.unique(np.sort(radii)[rank]), radii)[ghosts.owner]
    for value in np.unique(group):
        member = np.flatnonzero(group == value)
        distance, index = cKDTree(ghosts.place[member]).query(middle, k=[1, 2], workers=threads)
        surface = distance - radii[ghosts.owner[member[np.minimum(index, len(member) - 1)]]]
        best = np.sort(np.concatenate([best, surface], axis=1), axis=1)[:, :2]
    return best[:, 1]


def _lists(middle, bound, ghosts, radii, *, threads):
    """Rows of candidates within `bound` (n_cells,), a part of the cells after the other: few wait to be sorted."""
    trees = _trees(ghosts, radii)
    cells = [slice(begin, begin + CELLS_AT_ONCE) for begin in range(0, len(middle), CELLS_AT_ONCE)]
    parts = [_part(middle[part], bound[part], trees, ghosts, radii, threads=threads) for part in cells]
    lengths, owner, image, distance = (np.concatenate(part) for part in zip(*parts, strict=True))
    first = np.concatenate([[0], np.cumsum(lengths)])
    if first[-1] > MOST_CANDIDATES:
        raise SceneError(
            f"obstacles: the cell index of {len(radii):,} colloids would have {first[-1]:,} entries, and at most "
            f"{MOST_CANDIDATES:,} can be counted: {FEWER}"
        )
    return first.astype(np.int32), owner, image, distance


def _trees(ghosts, radii):
    """(largest radius, ghosts, tree) for each class of sizes, which differ by less than a factor of two within.

    A search among all would have to go as far as the largest radius reaches, and meet all that is small on the way.
    """
    radius = np.abs(radii)[ghosts.owner]
    size = np.frexp(radius)[1]
    members = [np.flatnonzero(size == value) for value in np.unique(size)]
    return [(max(radii[ghosts.owner[m]].max(), 0.0), m, cKDTree(ghosts.place[m])) for m in members]


def _part(middle, bound, trees, ghosts, radii, *, threads):
    """Number of candidates of each of some cells; of all of them colloid, packed image and distance, cell by cell."""
    found = []
    for largest, members, tree in trees:
        rows = tree.query_ball_point(middle, bound + largest, workers=threads)
        cell = np.repeat(np.arange(len(middle)), np.fromiter(map(len, rows), dtype=np.int64, count=len(rows)))
        index = members[np.fromiter(chain.from_iterable(rows), dtype=np.int64, count=len(cell))]
        distance = np.linalg.norm(middle[cell] - ghosts.place[index], axis=1) - radii[ghosts.owner[index]]
        keep = distance <= bound[cell]
        found.append((cell[keep], index[keep], distance[keep]))
    cell, index, distance = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.lexsort((index, distance, cell))
    index = index[order]
    lengths = np.bincount(cell, minlength=len(middle))
    return lengths, ghosts.owner[index], ghosts.image[index], distance[order]

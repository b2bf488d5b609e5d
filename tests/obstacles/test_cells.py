"""The cell index: exact for any radii, and as large as what it keeps."""

from __future__ import annotations

import tracemalloc
from itertools import product

import numpy as np
import pytest

from porous_swim.core.errors import SceneError
from porous_swim.obstacles import cells
from porous_swim.obstacles.cells import CellIndex, build_cells
from porous_swim.obstacles.field import ObstacleField

REACH = 1.5


def one_large_among_small(n: int) -> ObstacleField:
    """A bead of radius 100 among n^2 of radius 0.5, in a periodic plane of 1000 by 1000."""
    rng = np.random.default_rng(0)
    ticks = np.arange(n) * (1000.0 / n)
    grid = np.stack(np.meshgrid(ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 2) + rng.uniform(0, 0.3, (n * n, 2))
    grid = grid[np.hypot(*(grid - 500.0).T) > 102.0]
    centers = np.zeros((len(grid) + 1, 3))
    centers[0, :2], centers[1:, :2] = 500.0, grid
    return ObstacleField.of_spheres(centers, np.r_[100.0, np.full(len(grid), 0.5)], np.array([1000.0, 1000.0, 0.0]), 2)


def scattered(radii: np.ndarray, box: list[float], *, periodic: bool) -> ObstacleField:
    """Beads anywhere: overlaps do not matter here."""
    edges, d = np.array(box), int(np.sum(np.array(box) > 0.0))
    centers = np.random.default_rng(4).random((len(radii), 3)) * edges
    return ObstacleField.of_spheres(centers, radii, edges if periodic else np.zeros(3), d)


def listed(index: CellIndex, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances of `point`, in the indexed region, to the surfaces of the candidates of its cell, and their `least`."""
    cell = 0
    for d in range(3):
        cell = cell * index.n_cells[d] + int((point[d] - index.origin[d]) / index.edge[d] * index.n_cells[d])
    rows = slice(index.first[cell], index.first[cell + 1])
    image = ((index.shift[rows, None] >> np.array([0, 8, 16])) & 0xFF) - 128
    colloid = index.candidate[rows]
    place = index.origin + index.center[colloid] * 2.0**-cells.FIXED_BITS * index.edge + image * index.edge
    return np.linalg.norm(point - place, axis=1) - index.radius[colloid], index.least[rows]


def nearest_two(field: ObstacleField, point: np.ndarray) -> np.ndarray:
    """The two least distances to surfaces, by brute force over three boxes each way."""
    shifts = np.array(list(product(range(-3, 4) if field.periodic else (0,), repeat=3))) * field.box
    offset = point - (field.centers[None, :, :] + np.unique(shifts, axis=0)[:, None, :])
    return np.sort((np.linalg.norm(offset, axis=2) - field.radii).ravel())[:2]


RNG = np.random.default_rng(7)
FIELDS = {
    "one large among small": one_large_among_small(16),
    "equal": scattered(np.full(60, 2.0), [40.0, 60.0, 30.0], periodic=True),
    "over two decades": scattered(0.1 * 10.0 ** RNG.uniform(0.0, 2.0, 150), [60.0, 90.0, 0.0], periodic=True),
    "over two decades in space": scattered(0.1 * 10.0 ** RNG.uniform(0.0, 2.0, 80), [40.0, 40.0, 60.0], periodic=False),
}


@pytest.mark.parametrize("name", FIELDS)
def test_nearest_and_second_nearest_are_those_of_brute_force(name: str) -> None:
    field = FIELDS[name]
    index = build_cells(field, reach=REACH)
    points = index.origin + np.random.default_rng(5).random((1500, 3)) * index.edge
    points[:, field.dimensions :] = 0.0
    for point in points:
        found, least = listed(index, point)
        # coordinates up to 1000 in units of 2^-52 of the box: some 1e-12
        assert np.sort(found)[:2] == pytest.approx(nearest_two(field, point), abs=1e-9)
        assert np.all(found >= least)


def test_memory_follows_the_candidates_that_are_kept_whatever_the_radii() -> None:
    """Searching as far as the largest radius reaches took 183 times what is kept; now a part of the cells at a time."""
    field = one_large_among_small(50)
    tracemalloc.start()
    index = build_cells(field, reach=REACH)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    kept = sum(getattr(index, name).nbytes for name in ("first", "candidate", "shift", "least"))
    assert peak < 20 * kept


def test_a_cell_index_that_does_not_fit_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*arguments: object, **options: object) -> None:
        raise MemoryError

    field = FIELDS["equal"]
    monkeypatch.setattr(cells, "MOST_CANDIDATES", 100)
    with pytest.raises(SceneError, match=r"obstacles: the cell index of 60 colloids would have .* entries"):
        build_cells(field, reach=REACH)
    monkeypatch.setattr(cells, "_lists", full)
    with pytest.raises(SceneError, match="cell index of 60 colloids does not fit into memory: give fewer colloids"):
        build_cells(field, reach=REACH)

"""Neighbours and shells: lattices as in textbooks, measured and disordered ones against independent counts."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa
import pytest
from scipy.spatial import Voronoi

from porous_swim.analysis import hop_shells, hop_statistics, hop_table
from porous_swim.analysis.columns import column
from porous_swim.analysis.hopping.neighbours import Neighbours, neighbours
from porous_swim.analysis.hopping.shells import shell_ends
from tests.analysis.test_hop_network import SIX, hexagonal, walk
from tests.support import synthetic

SQUARE = math.sqrt(0.5)
LATTICES = {  # basis, box, neighbours, second and third distance over the first
    "square": ([[0, 0, 0]], (1, 1, 0), 4, math.sqrt(2.0), 2.0),
    "hexagonal": ([[0, 0, 0], [0.5, math.sqrt(0.75), 0]], (1, math.sqrt(3.0), 0), 6, math.sqrt(3.0), 2.0),
    "simple cubic": ([[0, 0, 0]], (1, 1, 1), 6, math.sqrt(2.0), math.sqrt(3.0)),
    "face-centred": ([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]], (1, 1, 1), 12, 1 / SQUARE, math.sqrt(3)),
    "body-centred": ([[0, 0, 0], [0.5, 0.5, 0.5]], (1, 1, 1), 14, math.sqrt(4.0 / 3.0), math.sqrt(8.0 / 3.0)),
    "chain": ([[0, 0, 0]], (1, 7, 0), 4, 2.0, 3.0),  # in a narrow box: beside it, too, are images
}


def field(centers: np.ndarray, radii: np.ndarray | float = 1.0) -> pa.Table:
    table = synthetic.colloids(synthetic.info(), np.asarray(centers, float))
    number = table.schema.get_field_index("radius")
    return table.set_column(number, table.schema.field("radius"), pa.array(np.broadcast_to(radii, len(table)) * 1.0))


def repeated(basis: list, box: tuple, times: int) -> tuple[np.ndarray, tuple]:
    """A lattice of so many cells along each axis."""
    counts = [times if edge else 1 for edge in box]
    cells = np.stack(np.meshgrid(*[np.arange(count) for count in counts], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    centers = (np.array(basis, float) + cells * np.array(box, float)).reshape(-1, 3)
    edges = tuple(float(edge * count) for edge, count in zip(box, counts, strict=True))
    return centers + np.array([0.3, -0.1, 0.0]), edges


def per_colloid(found: Neighbours | None, n: int) -> list[int]:
    assert found is not None
    return np.bincount(found.first, minlength=n).tolist()


@pytest.mark.parametrize("times", [1, 3])
@pytest.mark.parametrize("name", LATTICES)
def test_lattices_have_the_neighbours_and_the_shells_of_textbooks(name: str, times: int) -> None:
    basis, box, count, second, third = LATTICES[name]
    if name == "chain" and times > 1:
        return
    centers, edges = repeated(basis, box, times)
    assert per_colloid(neighbours(field(centers), box=edges), len(centers)) == [count] * len(centers)
    first = {"face-centred": SQUARE, "body-centred": math.sqrt(0.75)}.get(name, 1.0)
    ends = shell_ends(field(centers), box=edges)
    assert first < ends.first < first * second
    assert first * second < ends.second < first * third


def test_faces_that_rounding_opens_at_the_corners_of_a_square_lattice_join_nobody() -> None:
    centers, edges = repeated(*LATTICES["square"][:2], 6)
    measured = np.round(centers + 1e-3 * np.random.default_rng(1).normal(size=centers.shape) * [1, 1, 0], 4)
    assert per_colloid(neighbours(field(measured), box=edges), 36) == [4] * 36


def test_faces_of_lattices_have_their_sizes() -> None:
    hexagon = neighbours(field(repeated(*LATTICES["hexagonal"][:2], 2)[0]), box=(2.0, 2.0 * math.sqrt(3.0), 0.0))
    assert hexagon is not None
    assert hexagon.face == pytest.approx(np.full(24 * 2, 1.0 / math.sqrt(3.0)), rel=1e-9)
    octahedron = neighbours(field(LATTICES["body-centred"][0]), box=(1.0, 1.0, 1.0))  # truncated
    assert octahedron is not None
    square, six = 1.0 / 8.0, 3.0 * math.sqrt(3.0) / 16.0  # of edges sqrt(2)/4
    assert sorted(octahedron.face) == pytest.approx([square] * 12 + [six] * 16, rel=1e-9)


def test_centres_outside_of_the_box_have_the_neighbours_of_their_images_inside() -> None:
    box = (12.0, 15.0, 0.0)
    centers = np.random.default_rng(9).uniform(0.0, 1.0, (40, 3)) * box
    found = [neighbours(field(centers + shift), box=box) for shift in ([0.0, 0.0, 0.0], [-7.0, 38.0, 0.0])]
    pairs = [set(zip(each.first, each.second, *each.image.T, strict=True)) for each in found if each is not None]
    assert pairs[0] == pairs[1]
    assert len(pairs[0]) > 150


@pytest.mark.parametrize(("box", "n"), [((9.0, 30.0, 0.0), 150), ((3.0, 5.0, 20.0), 80)])
def test_neighbours_of_random_centres_are_those_of_scipys_voronoi_cells(box, n, monkeypatch) -> None:
    monkeypatch.setattr(f"{neighbours.__module__}.LEAST_FACE", 1e-9)
    centers = np.random.default_rng(4).uniform(0.0, 1.0, (n, 3)) * box
    found = neighbours(field(centers), box=box)
    d = 2 if box[2] == 0.0 else 3
    images = np.stack(np.meshgrid(*[[0, -1, 1, -2, 2][: 5 if k < d else 1] for k in range(3)], indexing="ij"), axis=-1)
    every = (images.reshape(-1, 1, 3) * np.array(box) + centers).reshape(-1, 3)
    ridges = Voronoi(every[:, :d]).ridge_points
    both = np.concatenate([ridges, ridges[:, ::-1]])
    both = both[both[:, 0] < n]
    expected = {(a, b % n, *images.reshape(-1, 3)[b // n]) for a, b in both}
    assert found is not None
    assert set(zip(found.first, found.second, *found.image.T, strict=True)) == expected
    assert found.have(found.first, found.second, found.image).all()
    assert not found.have(found.first, found.second, found.image + 7).any()


@pytest.mark.parametrize("box", [(12.0, 15.0, 0.0), (6.0, 5.0, 7.0)])
def test_cells_of_spheres_of_many_sizes_fill_the_box_and_are_where_their_power_is_the_least(box, monkeypatch) -> None:
    """Volumes by the divergence theorem from the faces, against drawn points by the definition of a cell."""
    monkeypatch.setattr(f"{neighbours.__module__}.LEAST_FACE", 0.0)
    rng, edges = np.random.default_rng(5), np.array(box)
    d, n = np.count_nonzero(edges), 60
    centers, radii = rng.uniform(0.0, 1.0, (n, 3)) * edges, rng.uniform(0.2, 1.0, n)
    found = neighbours(field(centers, radii), box=box)
    assert found is not None
    bond = centers[found.second] - centers[found.first] + found.image * edges
    length = np.linalg.norm(bond, axis=1)
    height = (length**2 + radii[found.first] ** 2 - radii[found.second] ** 2) / (2.0 * length)
    volume = np.bincount(found.first, weights=found.face * height / d, minlength=n)
    assert volume.sum() == pytest.approx(np.prod(edges[:d]), rel=1e-9)
    points = rng.uniform(0.0, 1.0, (40_000, 1, 3)) * edges
    offset = points - centers
    offset[..., :d] -= np.rint(offset[..., :d] / edges[:d]) * edges[:d]
    nearest = np.argmin(np.sum(offset**2, axis=2) - radii**2, axis=1)
    share = np.bincount(nearest, minlength=n) / len(points)
    expected = volume / np.prod(edges[:d])
    # 4.5 binomial standard errors: one false alarm in 1000 for 120 cells
    assert np.all(np.abs(share - expected) <= 4.5 * np.sqrt(expected / len(points)) + 1e-12)


def test_an_open_patch_has_neighbours_within_it_alone() -> None:
    x, y = np.divmod(np.arange(25), 5)
    found = neighbours(field(np.stack([10.0 * x, 10.0 * y, 0.0 * x], axis=1), 3.5), box=(0.0, 0.0, 0.0))
    sides = (x % 4 == 0).astype(int) + (y % 4 == 0)
    assert per_colloid(found, 25) == (4 - sides).tolist()


def test_a_strip_that_repeats_along_one_axis_alone_has_no_neighbours_across_its_sides() -> None:
    x, y = np.divmod(np.arange(15), 3)
    found = neighbours(field(np.stack([10.0 * x, 10.0 * y, 0.0 * x], axis=1), 3.5), box=(50.0, 0.0, 0.0))
    assert per_colloid(found, 15) == np.where(y == 1, 4, 3).tolist()


def test_one_colloid_far_from_many_others_leaves_no_shells_and_takes_no_time() -> None:
    crowd = np.random.default_rng(1).uniform(0.0, 10.0, (3000, 3))
    centers = np.concatenate([crowd, [[5e5, 5e5, 5e5]]])
    assert math.isnan(shell_ends(field(centers), box=(1e6, 1e6, 1e6)).first)


@pytest.mark.parametrize(("centers", "counts"), [
    ([[0, 0, 0], [3, 0, 0]], [1, 1]),
    ([[0, 0, 0], [1, 1, 0], [2, 2, 0], [3, 3, 0]], [1, 2, 2, 1]),
    ([[1, 2, 3]], [0]),
    (np.zeros((0, 3)), []),
])  # fmt: skip
def test_centres_on_a_line_or_alone_in_the_open_have_those_beside_them(centers, counts) -> None:
    assert per_colloid(neighbours(field(centers), box=(0.0, 0.0, 0.0)), len(counts)) == counts


def test_a_plane_wall_has_no_neighbours() -> None:
    assert per_colloid(neighbours(field([[0, 0, 0]], np.inf), box=(0.0, 0.0, 0.0)), 1) == [0]


@pytest.mark.parametrize("jitter", [0.0, 1e-4, 1e-3, 0.01, 0.1, 0.5])
def test_hops_of_a_measured_hexagonal_lattice_lead_to_nearest_neighbours(jitter: float) -> None:
    about, centers = hexagonal()
    rng = np.random.default_rng(6)
    table = walk(about, centers, SIX, rng.integers(0, 6, (100, 20)))
    measured = synthetic.colloids(about, centers + jitter * rng.normal(size=centers.shape) * [1.0, 1.0, 0.0])
    assert hop_statistics(table, measured).nearest_share.value == 1.0
    shells = hop_shells(hop_table(table, measured))
    assert (shells.nearest.value, shells.second.value, shells.farther.value) == (1.0, 0.0, 0.0)


def test_vacancies_leave_shells_what_they_are() -> None:
    about, centers = hexagonal()
    there = np.delete(np.arange(16), [3, 9])
    full, part = (shell_ends(field(centers[which]), box=about.box) for which in (np.arange(16), there))
    assert (part.first, part.second) == pytest.approx((full.first, full.second), rel=1e-9)


def test_in_a_disordered_field_cells_tell_neighbours_and_there_are_no_shells() -> None:
    rng = np.random.default_rng(7)
    about = synthetic.info(n_swimmers=200, last_time=30.0, dimensions=2, box=(40.0, 40.0, 0.0))
    centers = rng.uniform(0.0, 1.0, (60, 3)) * [40.0, 40.0, 0.0]
    colloids = synthetic.colloids(about, centers)
    assert math.isnan(shell_ends(colloids, box=about.box).first)
    to = rng.integers(0, 60, 400)
    table = synthetic.encounters(
        about, swimmer=np.repeat(np.arange(200), 2), start_time=np.tile([0.0, 2.0], 200),
        end_time=np.tile([1.0, 3.0], 200), colloid=to,
    )  # fmt: skip
    hops = hop_table(table, colloids)
    assert np.isnan(column(hops, "shell")).all()
    assert all(math.isnan(share.value) for share in vars(hop_shells(hops)).values())
    found = neighbours(colloids, box=about.box)
    assert found is not None
    pairs = set(zip(found.first, found.second, *found.image.T, strict=True))
    moved = [(a, b, 0, 0, 0) for a, b in to.reshape(200, 2) if a != b]
    share = np.mean([move in pairs for move in moved])
    assert 0.0 < share < 1.0
    assert hop_statistics(table, colloids).nearest_share.value == pytest.approx(share, rel=1e-12)


def test_a_few_colloids_in_disorder_in_the_open_are_not_one_shell() -> None:
    centers = np.random.default_rng(1).uniform(0.0, 20.0, (15, 3))
    assert math.isnan(shell_ends(field(centers), box=(0.0, 0.0, 0.0)).first)


def test_too_many_colloids_without_shells_have_no_share_of_nearest_and_say_so(monkeypatch) -> None:
    monkeypatch.setattr(f"{neighbours.__module__}.MOST_POINTS", 50)
    rng = np.random.default_rng(8)
    about = synthetic.info(n_swimmers=1, last_time=30.0, dimensions=2, box=(40.0, 40.0, 0.0))
    table = synthetic.encounters(about, swimmer=[0, 0], start_time=[0.0, 2.0], end_time=[1.0, 3.0], colloid=[0, 1])
    colloids = synthetic.colloids(about, rng.uniform(0.0, 1.0, (60, 3)) * [40.0, 40.0, 0.0])
    share = hop_statistics(table, colloids).nearest_share
    assert math.isnan(share.value)
    assert "form no shells, and their cells are not known" in str(share.warning)

"""Where colloids are placed."""

from __future__ import annotations

from itertools import product
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from porous_swim.core.errors import SceneError
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.nearest import NearestSphere
from porous_swim.scene.scene import Scene


def scene_of(obstacles: dict[str, Any], folder: Path = Path(), **sections: Any) -> Scene:
    release = {"kind": "point", "position": [0.5, 0.5, 0]}
    data = {
        "swimmers": {"count": 1, "dipole_strength": 0.8, "release": release},
        "obstacles": obstacles,
        "run": {"time_step": 0.01, "duration": 1.0, "seed": 5},
    }
    return Scene.from_mapping(data | sections, folder=folder)


def place(obstacles: dict[str, Any], folder: Path = Path(), **domain: Any) -> ObstacleField:
    return scene_of(obstacles, folder, domain=domain).place_obstacles()


def distances(field: ObstacleField) -> np.ndarray:
    """All distances between colloid 0 and the images of all colloids within two boxes: brute force."""
    shifts = np.array(list(product(range(-2, 3), repeat=3))) * field.box
    shifts = np.unique(shifts, axis=0)
    offset = field.centers[None, :, :] + shifts[:, None, :] - field.centers[0]
    return np.sort(np.linalg.norm(offset.reshape(-1, 3), axis=1))[1:]


@pytest.mark.parametrize(
    ("layout", "cells", "neighbours", "second", "fraction"),
    [  # distance of second neighbours over spacing; packing fraction where spheres touch
        ("square", [3, 4], 4, sqrt(2), pi / 4),
        ("hexagonal", [4, 3], 6, sqrt(3), pi / sqrt(12)),
        ("sc", [2, 3, 4], 6, sqrt(2), pi / 6),
        ("bcc", [3, 3, 2], 8, 2 / sqrt(3), pi * sqrt(3) / 8),
        ("fcc", [2, 2, 3], 12, sqrt(2), pi / sqrt(18)),
    ],
)
def test_lattices_have_their_neighbours(
    layout: str, cells: list[int], neighbours: int, second: float, fraction: float
) -> None:
    obstacles = {"layout": layout, "radius": 2.0, "spacing": 6.0, "cells": cells}
    field = place(obstacles, dimensions=len(cells))
    found = distances(field)
    assert found[:neighbours] == pytest.approx(6.0, rel=1e-14)  # rounding of the coordinates
    assert found[neighbours] == pytest.approx(6.0 * second, rel=1e-14)
    assert field.packing_fraction == pytest.approx(fraction * (4.0 / 6.0) ** len(cells), rel=1e-14)
    assert np.all((field.centers >= 0.0) & ((field.centers < field.box) | (field.box == 0.0)))


def test_touching_spheres_are_no_overlap() -> None:
    field = place({"layout": "fcc", "radius": 3.0, "spacing": 6.0, "cells": [2, 2, 2]}, dimensions=3)
    assert field.packing_fraction == pytest.approx(pi / sqrt(18), rel=1e-14)


def test_an_open_lattice_has_no_box() -> None:
    obstacles = {"layout": "square", "radius": 2.0, "spacing": 6.0, "cells": [3, 4]}
    field = place(obstacles, dimensions=2, boundary="open")
    assert len(field.radii) == 12
    assert not field.periodic
    assert field.packing_fraction is None


def test_a_colloid_outside_of_its_box_is_wrapped() -> None:
    field = place(
        {"layout": "single", "radius": 2.0, "position": [-1.0, 12.0, 10.0]},
        boundary="periodic",
        size=[10, 10, 10],
    )
    assert field.centers.tolist() == [[9.0, 2.0, 0.0]]


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("layout", ["random", "packing"])
def test_disorder_reaches_the_stated_fraction_and_gap(layout: str, dimensions: int) -> None:
    field = place(
        {
            "layout": layout,
            "radius": [2.0, 3.0],
            "fractions": [3, 1],
            "count": 200,
            "packing_fraction": 0.2,
            "min_gap": 0.5,
        },
        dimensions=dimensions,
    )
    assert np.unique(field.radii, return_counts=True)[1].tolist() == [150, 50]
    assert field.packing_fraction == pytest.approx(0.2, rel=1e-12)
    _, gap = NearestSphere(field.centers, field.radii, field.box).nearest_other()
    assert gap.min() >= 0.5 - 1e-9  # rounding of a packing's contacts
    assert np.all(field.centers[:, 2] == 0.0) == (dimensions == 2)


def test_a_box_and_a_fraction_give_the_nearest_count() -> None:
    field = place({"layout": "random", "radius": 1.0, "packing_fraction": 0.1}, dimensions=2, size=[40, 30])
    assert len(field.radii) == round(0.1 * 1200 / pi)


def test_placement_follows_the_seed() -> None:
    scene = scene_of({"layout": "random", "radius": 1.0, "count": 50, "packing_fraction": 0.1})
    first, again = scene.place_obstacles(), scene.place_obstacles()
    other = scene.replace({"run.seed": 6}).place_obstacles()
    assert np.array_equal(first.centers, again.centers)
    assert not np.array_equal(first.centers, other.centers)


@pytest.mark.parametrize("layout", ["random", "packing"])
def test_a_medium_with_a_seed_of_its_own_stays_while_the_swimmers_change(layout: str) -> None:
    obstacles = {"layout": layout, "radius": 1.0, "count": 50, "packing_fraction": 0.1}
    scene = scene_of(obstacles, swimmers={"count": 5, "dipole_strength": 0.8}).replace({"run.seed": 6})
    kept = scene.replace({"obstacles.seed": 6, "run.seed": 7})
    field = scene.place_obstacles()
    assert np.array_equal(kept.place_obstacles().centers, field.centers)
    one, other = (each.place_swimmers(field, lambda s, A: np.ones_like(s)).position for each in (scene, kept))
    assert not np.array_equal(one, other)
    # a seed that says what is so anyway is the same run; any other is not
    assert scene.replace({"obstacles.seed": 6}).scene_id == scene.scene_id
    assert len({each.scene_id for each in (scene, kept, kept.replace({"obstacles.seed": 8}))}) == 3


def test_random_addition_is_uniform_where_overlaps_are_rare() -> None:
    """At a fraction of 1e-9 overlaps do not matter: coordinates are uniform (significance 1e-4)."""
    from scipy.stats import kstest

    field = place({"layout": "random", "radius": 1e-3, "count": 3000, "packing_fraction": 1e-9})
    for axis in range(3):
        assert kstest(field.centers[:, axis] / field.box[axis], "uniform").pvalue > 1e-4


def test_1e5_colloids_are_checked_and_searched() -> None:
    rng = np.random.default_rng(1)
    field = place({"layout": "fcc", "radius": 2.0, "spacing": 6.0, "cells": [30, 30, 28]})
    assert len(field.radii) == 100_800
    points = rng.random((1000, 3)) * field.box
    _, _, height = field.nearest(points)
    assert height.max() < 6.0 / sqrt(2) - 2.0 + 1e-9  # the octahedral hole is the deepest


def polydisperse(seed: int, n: int, box: list[float]) -> ObstacleField:
    rng = np.random.default_rng(seed)
    edges = np.array(box)
    centers = rng.random((n, 3)) * np.where(edges > 0.0, edges, 20.0)
    return ObstacleField.of_spheres(
        centers, 0.1 * 10.0 ** rng.uniform(0.0, 1.5, n), edges, 3
    )  # overlaps do not matter here


@pytest.mark.parametrize("box", [[20.0, 20.0, 20.0], [0.0, 0.0, 0.0], [20.0, 0.0, 7.0]])
def test_the_nearest_surface_is_the_nearest_by_brute_force(box: list[float]) -> None:
    field = polydisperse(2, 200, box)
    points = np.random.default_rng(3).uniform(-30.0, 50.0, (300, 3))
    index, image, height = field.nearest(points)
    far = [range(-12, 13) if edge == 7.0 else range(-4, 5) if edge else (0,) for edge in box]
    shifts = np.array(list(product(*far))) * field.box
    best = np.min(
        [np.linalg.norm(points[:, None, :] - (field.centers + shift), axis=2) - field.radii for shift in shifts],
        axis=(0, 2),
    )
    assert height == pytest.approx(best, abs=1e-12)  # coordinates up to 100, rounding 1e-14 of them
    own = np.linalg.norm(points - field.centers[index] - image * field.box, axis=1) - field.radii[index]
    assert own == pytest.approx(best, abs=1e-12)


def test_all_images_within_reach_are_found() -> None:
    field = ObstacleField.of_spheres(np.array([[1.0, 1.0, 1.0]]), np.array([1.0]), np.array([2.5, 2.5, 2.5]), 3)
    # Halfway to the image in x: two surfaces at 0.25, the other two in y at sqrt(1.25^2 + 2.5^2) - 1 = 1.795
    _, _, offset = field.near(np.array([[2.25, 1.0, 1.0]]), 0.3)
    assert sorted(offset[:, 0].tolist()) == pytest.approx([-1.25, 1.25])
    assert len(field.near(np.array([[2.25, 1.0, 1.0]]), 1.8)[0]) == 2 + 2 * 4


def test_heights_above_a_wall_count_along_its_normal_whatever_its_length() -> None:
    field = place({"layout": "wall", "normal": [0, 6, 8], "position": [1, 2, 3]})
    index, image, height = field.nearest(np.array([[7.0, 2.6, 3.8], [-9.0, 2.0, 3.0], [1.0, 10.0, -4.0]]))
    assert height == pytest.approx([1.0, 0.0, -0.8], abs=1e-15)
    assert (index.tolist(), image.any()) == ([0, 0, 0], False)
    assert not field.periodic
    assert field.packing_fraction is None


def test_an_empty_field_has_no_nearest() -> None:
    index, image, height = place({"layout": "none"}).nearest(np.zeros((2, 3)))
    assert index.tolist() == [-1, -1]
    assert np.all(np.isinf(height))
    assert image.shape == (2, 3)


def test_colloids_come_from_a_table(tmp_path: Path) -> None:
    (tmp_path / "beads.csv").write_text("x, y, radius\n1,2,0.5\n\n4,25,1.5\n")
    field = place({"layout": "file", "path": "beads.csv"}, tmp_path, dimensions=2, size=[10, 10])
    assert field.centers.tolist() == [[1.0, 2.0, 0.0], [4.0, 5.0, 0.0]]
    assert field.radii.tolist() == [0.5, 1.5]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("x,y\n1,2\n", "expected the columns x, y, z, radius in the first line, found x, y"),
        ("x,y,z,radius\n1,2,3,a\n", "beads.csv, line 2: radius must be a finite number, found 'a'"),
        ("x,y,z,radius\n1,2,3,nan\n", "beads.csv, line 2: radius must be a finite number, found 'nan'"),
        ("x,y,z,radius\n1,2,3\n", "beads.csv, line 2: expected 4 numbers, found 3"),
        ("x,y,z,radius\n1,2,3,-1\n", "colloid 0 must have a radius above 0, found -1"),
        ("x,y,z,radius\n", "expected at least one colloid below the header"),
        ("", "expected the columns x, y, z, radius in the first line, found nothing"),
        (
            "x,y,z,radius\n1,1,1,0.5\n5,5,5,2\n8,5,5,2\n",
            "colloids 1 and 2 overlap by 1: centres 3 apart, radii 2 and 2",
        ),
        (
            "x,y,z,radius\n0.5,5,5,2\n8.5,5,5,1\n",
            "colloids 0 and 1 overlap by 1 through the periodic boundary: centres 2 apart, radii 2 and 1",
        ),
    ],
)
def test_a_bad_table_is_named(tmp_path: Path, table: str, message: str) -> None:
    (tmp_path / "beads.csv").write_text(table)
    with pytest.raises(SceneError) as caught:
        place({"layout": "file", "path": "beads.csv"}, tmp_path, size=[10, 10, 10])
    assert str(caught.value).startswith("obstacles.path: ")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("obstacles", "domain", "message"),
    [
        ({"layout": "single", "radius": 6.0}, {"boundary": "periodic", "size": [20, 20, 10]},
         "domain.size: the box is 10 long in z, so a colloid of radius 6 overlaps its own image: expected "
         "at least 12"),
        ({"layout": "single", "radius": 6.0}, {"size": [20, 20, 20]},
         "domain.size: leave it out: an open domain is unbounded"),
        ({"layout": "single", "radius": 6.0}, {"boundary": "periodic"},
         "domain.size: this layout needs the box: give 3 edge lengths"),
        ({"layout": "wall", "normal": [0, 0, 1]}, {"boundary": "periodic", "size": [9, 9, 9]},
         "domain.boundary: a wall stands in open space: expected open (nothing needs to repeat along it), "
         "found periodic"),
        ({"layout": "wall", "normal": [0, 0, 1]}, {"size": [9, 9, 9]},
         "domain.size: leave it out: an open domain is unbounded"),
        ({"layout": "wall", "normal": [0, 0, 0]}, {},
         "obstacles.normal: expected a direction, found the zero vector"),
        ({"layout": "wall", "normal": [0, 0, 1]}, {"dimensions": 2},
         "obstacles.normal: expected a z component of 0 in two dimensions, found 1"),
        ({"layout": "wall", "normal": [0, 1], "position": [0, 1, 2]}, {"dimensions": 2},
         "obstacles.position: expected a z component of 0 in two dimensions, found 2"),
        ({"layout": "wall", "normal": [0, 0, 1], "radius": 3.0}, {},
         "obstacles.radius: unknown key; allowed with layout: wall: layout, normal, position"),
        ({"layout": "fcc", "radius": 6.0, "spacing": 11.0, "cells": [1, 1, 1]}, {},
         "obstacles.spacing: colloids of radius 6 overlap by 1: expected at least 12, found 11"),
        ({"layout": "fcc", "radius": 1.0, "spacing": 11.0, "cells": [1, 1]}, {},
         "obstacles.cells: expected 3 numbers of cells, found 2"),
        ({"layout": "hexagonal", "radius": 1.0, "spacing": 11.0, "cells": [1, 1]}, {},
         "domain.dimensions: the layout hexagonal needs 2, found 3"),
        ({"layout": "random", "radius": 1.0, "count": 3}, {},
         "obstacles: expected two of count, packing_fraction and domain.size, found count"),
        ({"layout": "random", "radius": [1.0, 2.0], "fractions": [1], "count": 3}, {"size": [9, 9, 9]},
         "obstacles.fractions: expected as many as there are radii (2), found 1"),
        ({"layout": "packing", "radius": 1.0, "count": 300, "packing_fraction": 0.9}, {"dimensions": 2},
         "obstacles: the colloids cannot be packed to a fraction of 0.9, gaps included: "),
        ({"layout": "packing", "radius": 1.0, "count": 300, "packing_fraction": 0.8}, {},
         "obstacles: the colloids would fill 0.8 of the box and 0.66 is more than a random packing of equal ones"),
        ({"layout": "packing", "radius": 1.0, "count": 30, "packing_fraction": 0.75}, {},
         "obstacles: the colloids would fill 0.75 of the box and 0.7405 is the densest packing of equal ones"),
        ({"layout": "packing", "radius": [1.0, 0.5], "count": 30}, {"size": [4, 4, 4]},
         "obstacles: the colloids would fill 1.104 of the box and 1 is all of the box"),
        ({"layout": "random", "radius": 1.0, "count": 10**6, "packing_fraction": 0.4}, {},
         "obstacles: the colloids would fill 0.4 of the box and 0.394 is more than equal ones fill that are put down"),
        ({"layout": "random", "radius": 1.0, "count": 10**5, "packing_fraction": 0.3, "min_gap": 0.5}, {},
         "obstacles: the colloids would fill 0.5859 of the box, gaps included, and 0.394"),
        ({"layout": "packing", "radius": 1.0, "count": 2 * 10**6, "packing_fraction": 0.1}, {},
         "obstacles: expected at most 1,000,000 colloids, which take some ten minutes, found 2,000,000"),
        ({"layout": "random", "radius": 1.0, "count": 100, "packing_fraction": 0.6}, {"dimensions": 2},
         "obstacles: only "),
    ],
)  # fmt: skip
def test_colloids_that_do_not_fit_are_named(obstacles: dict[str, Any], domain: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        place(obstacles, **domain)
    assert str(caught.value).startswith(message)

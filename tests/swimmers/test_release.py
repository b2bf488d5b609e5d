"""Where swimmers start."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest

from porous_swim.core.errors import SceneError
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.scene import Scene
from porous_swim.swimmers.placement import Swimmers

SIGNIFICANCE = 1e-4  # of each Kolmogorov-Smirnov test; seeds are fixed, so a pass stays a pass


def sphere(s: np.ndarray, A: np.ndarray) -> np.ndarray:
    return np.ones_like(s)


def rod(s: np.ndarray, A: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(s * s + 0.01 * (1.0 - s * s)))  # aspect ratio 0.1 at a plane


def scene_of(release: dict[str, Any], *, count: int = 2000, folder: Path = Path(), **sections: Any) -> Scene:
    data = {
        "swimmers": {"count": count, "dipole_strength": 0.8, "release": release},
        "obstacles": {"layout": "single", "radius": 4.0, "position": [5, 5, 5]},
        "domain": {"boundary": "periodic", "size": [10, 10, 10]},
        "run": {"time_step": 0.01, "duration": 1.0, "seed": 5},
    }
    return Scene.from_mapping(data | sections, folder=folder)


FLAT: dict[str, Any] = {
    "obstacles": {"layout": "single", "radius": 3.0, "position": [5, 5]},
    "domain": {"dimensions": 2, "boundary": "periodic", "size": [10, 10]},
}
WALL: dict[str, Any] = {
    "obstacles": {"layout": "wall", "normal": [0, 0, 3], "position": [1, 2, 2]}, "domain": {}
}  # fmt: skip


def released(scene: Scene, contact_height: Any = sphere) -> tuple[ObstacleField, Swimmers]:
    field = scene.place_obstacles()
    return field, scene.place_swimmers(field, contact_height)


def test_a_uniform_release_is_uniform_where_swimmers_fit() -> None:
    """Below half an edge the cube of the distance from the colloid is uniform; beyond, the box cuts."""
    scene = scene_of({"kind": "uniform"}, count=20_000, domain={"boundary": "periodic", "size": [16, 16, 16]},
                     obstacles={"layout": "single", "radius": 4.0, "position": [8, 8, 8]})  # fmt: skip
    field, swimmers = released(scene)
    distance = np.linalg.norm(swimmers.position - field.centers[0], axis=1)
    assert distance.min() >= 5.0 - 1e-9
    inside = distance[distance < 8.0]
    assert kstest((inside**3 - 125.0) / (512.0 - 125.0), "uniform").pvalue > SIGNIFICANCE
    share = 4.0 / 3.0 * np.pi * (512.0 - 125.0) / (16.0**3 - 4.0 / 3.0 * np.pi * 125.0)
    assert len(inside) / 20_000 == pytest.approx(share, abs=4.0 * np.sqrt(0.25 / 20_000))  # 4 standard errors


def test_directors_of_a_uniform_release_are_isotropic() -> None:
    _, space = released(scene_of({"kind": "uniform"}))
    for axis in range(3):
        assert kstest(0.5 * (space.director[:, axis] + 1.0), "uniform").pvalue > SIGNIFICANCE
    _, plane = released(scene_of({"kind": "uniform"}, **FLAT))
    angle = np.arctan2(plane.director[:, 1], plane.director[:, 0])
    assert kstest(angle / (2.0 * np.pi) + 0.5, "uniform").pvalue > SIGNIFICANCE
    assert not np.any(plane.director[:, 2])
    assert not np.any(plane.position[:, 2])


def test_rods_lie_nearer_to_the_wall_than_they_stand() -> None:
    field, swimmers = released(scene_of({"kind": "uniform"}, count=5000), rod)
    offset = swimmers.position - field.centers[0]
    offset -= np.rint(offset / field.box) * field.box
    distance = np.linalg.norm(offset, axis=1)
    sine = np.einsum("ij,ij->i", swimmers.director, offset) / distance
    height = distance - 4.0
    assert np.all(height >= rod(sine, height) - 1e-9)
    assert height.min() < 0.5


def test_swimmers_keep_clear_of_colloids_behind_the_boundary() -> None:
    scene = scene_of({"kind": "uniform"}, obstacles={"layout": "single", "radius": 3.5, "position": [0, 0, 0]})
    field, swimmers = released(scene)
    _, _, height = field.nearest(swimmers.position)
    assert height.min() >= 1.0 - 1e-9


@pytest.mark.parametrize("release", [{"kind": "uniform"}, {"kind": "parallel", "height": 1.2},
                                     {"kind": "beam", "origin": [0, 0, 0], "director": [0, 1, 0],
                                     "width": 2.0},
                                     {"kind": "point", "position": [0, 0, 0]}])  # fmt: skip
def test_the_first_swimmers_do_not_depend_on_how_many_follow(release: dict[str, Any]) -> None:
    box = {"boundary": "periodic", "size": [14, 14, 14]}
    few = released(scene_of(release, count=3, domain=box))[1]
    many = released(scene_of(release, count=1500, domain=box))[1]
    again = released(scene_of(release, count=1500, domain=box))[1]
    assert np.array_equal(few.position, many.position[:3])
    assert np.array_equal(few.director, many.director[:3])
    assert np.array_equal(again.position, many.position)
    assert np.linalg.norm(many.director, axis=1) == pytest.approx(1.0, abs=1e-15 * 4)  # rounding of a square root


def test_a_beam_fills_its_disc_evenly() -> None:
    release = {"kind": "beam", "origin": [-20, 1, 2], "director": [3, 0, 4], "width": 4.0}
    _, swimmers = released(scene_of(release, obstacles={"layout": "none"}, domain={}))
    across = swimmers.position - np.array([-20.0, 1.0, 2.0])
    assert np.abs(across @ np.array([0.6, 0.0, 0.8])).max() < 1e-12
    assert kstest(np.sum(across**2, axis=1) / 4.0, "uniform").pvalue > SIGNIFICANCE
    assert np.unique(swimmers.director, axis=0) == pytest.approx(np.array([[0.6, 0.0, 0.8]]))


def test_a_beam_in_the_plane_fills_its_segment_evenly() -> None:
    release = {"kind": "beam", "origin": [-20, 1], "director": [1, 1], "width": 4.0}
    _, swimmers = released(scene_of(release, obstacles={"layout": "none"}, domain={"dimensions": 2}))
    along = (swimmers.position - np.array([-20.0, 1.0, 0.0])) @ np.array([-1.0, 1.0, 0.0]) / np.sqrt(2.0)
    assert kstest(along / 4.0 + 0.5, "uniform").pvalue > SIGNIFICANCE
    assert not np.any(swimmers.position[:, 2])


@pytest.mark.parametrize("sections", [{"domain": {"boundary": "periodic", "size": [14, 14, 14]}}, FLAT])
def test_a_parallel_release_lies_along_the_surface(sections: dict[str, Any]) -> None:
    field, swimmers = released(scene_of({"kind": "parallel", "height": 1.5}, **sections))
    offset = swimmers.position - field.centers[0]
    assert np.linalg.norm(offset, axis=1) == pytest.approx(field.radii[0] + 1.5, rel=1e-12)
    assert np.abs(np.einsum("ij,ij->i", offset, swimmers.director)).max() < 1e-12
    normal = offset / np.linalg.norm(offset, axis=1, keepdims=True)
    if field.dimensions == 3:
        assert kstest(0.5 * (normal[:, 2] + 1.0), "uniform").pvalue > SIGNIFICANCE
    else:
        turn = np.sign(np.cross(normal, swimmers.director)[:, 2])
        assert abs(turn.mean()) < 4.0 / np.sqrt(2000)  # 4 standard errors
        assert not np.any(swimmers.director[:, 2])


def test_a_parallel_release_at_a_wall_is_over_its_point_with_headings_all_round() -> None:
    _, swimmers = released(scene_of({"kind": "parallel", "height": 1.5}, **WALL))
    assert swimmers.position == pytest.approx(np.tile([1.0, 2.0, 3.5], (2000, 1)), abs=1e-15)
    assert not np.any(swimmers.director[:, 2])
    angle = np.arctan2(swimmers.director[:, 1], swimmers.director[:, 0])
    assert kstest(angle / (2.0 * np.pi) + 0.5, "uniform").pvalue > SIGNIFICANCE


def test_swimmers_come_from_a_table(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text("x,y,z,ex,ey,ez\n0,0,0,0,0,2\n30,0,0,3,4,0\n")
    _, swimmers = released(scene_of({"kind": "file", "path": "s.csv"}, count=2, folder=tmp_path))
    assert swimmers.position.tolist() == [[0, 0, 0], [30, 0, 0]]
    assert swimmers.director == pytest.approx(np.array([[0, 0, 1], [0.6, 0.8, 0]]))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("x,y,z,ex,ey,ez\n0,0,0,0,0,0\n", "s.csv: swimmer 0 has the zero vector for a director"),
        ("x,y,z,ex,ey\n0,0,0,0,0\n", "s.csv: expected the columns x, y, z, ex, ey, ez in the first line"),
        ("x,y,z,ex,ey,ez\n", "s.csv: expected as many rows as swimmers.count (1), found 0"),
        ("x,y,z,ex,ey,ez\n5,5,5,1,0,0\n", "swimmer 0 at (5, 5, 5) lies 5 too near to colloid 0 of radius 4"),
    ],
)
def test_a_bad_table_of_swimmers_is_named(tmp_path: Path, table: str, message: str) -> None:
    (tmp_path / "s.csv").write_text(table)
    with pytest.raises(SceneError) as caught:
        released(scene_of({"kind": "file", "path": "s.csv"}, count=1, folder=tmp_path))
    assert str(caught.value).startswith(f"swimmers.release.path: {message}")


UNBOUNDED = (
    "swimmers.release: a uniform release fills a periodic box, and domain.boundary is open: expected domain.boundary: "
    "periodic, or here point, beam, parallel or file"
)


@pytest.mark.parametrize(
    ("release", "sections", "message"),
    [
        ({"kind": "point", "position": [9.5, 5, 5]}, {}, "swimmers.release.position: swimmer 0 at (9.5, "
         "5, 5) lies 0.5 too "
         "near to colloid 0 of radius 4"),
        ({"kind": "point", "position": [0, 0, 0], "director": [0, 0, 0]}, {},
         "swimmers.release.director: expected a direction, found the zero vector"),
        ({"kind": "point", "position": [0, 0]}, {},
         "swimmers.release.position: expected 3 numbers in three dimensions, found 2"),
        ({"kind": "point", "position": [0, 0], "director": [0, 1, 1]}, FLAT,
         "swimmers.release.director: expected a z component of 0 in two dimensions, found 1"),
        ({"kind": "parallel", "height": 0.9}, {}, "swimmers.release.height: swimmer 0 at"),
        ({"kind": "parallel", "height": 2.0, "colloid": 1}, {},
         "swimmers.release.colloid: expected the index of one of 1 colloids, found 1"),
        ({"kind": "point", "position": [3, 0, 1.5]}, WALL,
         "swimmers.release.position: swimmer 0 at (3, 0, 1.5) lies 1.5 too near to the wall: "
         "expected at least the contact height above its surface"),
        ({"kind": "beam", "origin": [0, 0, -40], "director": [0, 0, 1], "width": 3}, WALL,
         "swimmers.release: swimmer 0 at"),
        ({"kind": "parallel", "height": 2.0, "colloid": 1}, WALL,
         "swimmers.release.colloid: expected the index of one of 1 colloids, found 1"),
        ({"kind": "uniform"}, WALL, UNBOUNDED),
        ({"kind": "uniform"}, {"domain": {}}, UNBOUNDED),
        # the largest hole between touching spheres of radius 2 takes a sphere of (sqrt(2) - 1) 2 = 0.83
        ({"kind": "uniform"}, {"obstacles": {"layout": "fcc", "radius": 2.0, "spacing": 4.0, "cells": [1, 1,
        1]},
                               "domain": {}}, "swimmers.release: swimmers do not fit: 0 of 102400 trials"),
    ],
)  # fmt: skip
def test_swimmers_that_do_not_fit_are_named(release: dict[str, Any], sections: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        released(scene_of(release, **sections))
    assert str(caught.value).startswith(message), str(caught.value)


def test_a_director_of_any_length_is_a_direction() -> None:
    release = {"kind": "point", "position": [0, 0, 0], "director": [0, 1e-300, 0]}
    assert released(scene_of(release))[1].director[0].tolist() == [0.0, 1.0, 0.0]

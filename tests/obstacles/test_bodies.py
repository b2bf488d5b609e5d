"""A field of several kinds of bodies: each answer is that of the kind alone, or of the nearest among all."""

from __future__ import annotations

import numpy as np
import pytest

from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.spheres import Spheres
from porous_swim.obstacles.wall import PlaneWall
from tests.support.engines import field_of, plane_wall

CENTERS = np.array([[0.0, 0.0, 5.0], [9.0, 1.0, 7.0], [2.0, -8.0, 6.0]])
RADII = np.array([3.0, 2.0, 1.0])
POINT, NORMAL = np.array([1.0, 2.0, 0.0]), np.array([2.0, -1.0, 2.0]) / 3.0
ROUNDING = 1e-13  # of lengths below 32 in double precision, a few operations


def mixed() -> ObstacleField:
    """Three spheres, a wall, and one sphere more: numbers 0 to 2, 3 and 4."""
    bodies = (Spheres(CENTERS, RADII), PlaneWall(POINT, NORMAL, 3), Spheres(np.array([[20.0, 0.0, 0.0]]), np.ones(1)))
    return ObstacleField(bodies, np.zeros(3), 3)


def heights_by_hand(points: np.ndarray) -> np.ndarray:
    """(n, 5) heights above each body."""
    centers = np.concatenate([CENTERS, [[20.0, 0.0, 0.0]]])
    spheres = np.linalg.norm(points[:, None] - centers, axis=2) - [*RADII, 1.0]
    return np.insert(spheres, 3, (points - POINT) @ NORMAL, axis=1)


def test_the_nearest_body_is_exact_among_spheres_and_walls():
    points = np.random.default_rng(1).uniform(-12.0, 24.0, (400, 3))
    heights = heights_by_hand(points)
    index, image, height = mixed().nearest(points)
    assert set(index) == {0, 1, 2, 3, 4}
    assert np.array_equal(index, heights.argmin(axis=1))
    assert height == pytest.approx(heights.min(axis=1), abs=ROUNDING)
    assert not image.any()


def test_all_bodies_within_a_height_are_found_whatever_they_are():
    points = np.random.default_rng(2).uniform(-12.0, 24.0, (300, 3))
    point, colloid, offset = mixed().near(points, 2.5)
    found = set(zip(point.tolist(), colloid.tolist(), strict=True))
    assert found == {(i, j) for i, j in np.argwhere(heights_by_hand(points) < 2.5).tolist()}
    assert offset == pytest.approx(points[point] - mixed().centers[colloid], abs=ROUNDING)


def test_height_and_pitch_are_those_of_the_kind_of_each_body():
    rng, field = np.random.default_rng(3), mixed()
    offset, e = rng.normal(size=(2, 50, 3)) * 6.0
    e /= np.linalg.norm(e, axis=1)[:, None]
    colloid = rng.integers(0, 5, 50)
    height, sine = field.stance(offset, e, colloid)
    distance = np.linalg.norm(offset, axis=1)
    flat = colloid == 3
    radii = np.array([*RADII, 0.0, 1.0])
    expected = np.where(flat, offset @ NORMAL, distance - radii[colloid])
    assert height == pytest.approx(expected, abs=ROUNDING)
    assert sine == pytest.approx(np.where(flat, e @ NORMAL, np.sum(e * offset, axis=1) / distance), abs=ROUNDING)


def test_the_device_sees_each_body_in_axes_of_its_own():
    rng, field = np.random.default_rng(4), mixed()
    vectors, colloid = rng.normal(size=(50, 3)), rng.integers(0, 5, 50)
    turned = field.to_device(vectors, colloid)
    assert np.array_equal(turned[colloid != 3], vectors[colloid != 3])
    assert turned[colloid == 3, 2] == pytest.approx(vectors[colloid == 3] @ NORMAL, abs=ROUNDING)
    assert field.from_device(turned, colloid) == pytest.approx(vectors, abs=ROUNDING)


def test_bodies_are_numbered_through_in_messages():
    assert [mixed().name(i) for i in (1, 3, 4)] == ["colloid 1 of radius 2", "the wall", "colloid 4 of radius 1"]
    above, normal = mixed().above(4, np.array([[0.0, 0.0, 1.0]]), 2.0)
    assert np.array_equal(above, [[20.0, 0.0, 3.0]])
    assert np.array_equal(normal, [[0.0, 0.0, 1.0]])


def test_a_kernel_is_compiled_for_one_kind_of_surface():
    assert field_of([0, 0, 0], 2.0).surface == "sphere"
    assert plane_wall(POINT, NORMAL).surface == "plane"
    with pytest.raises(NotImplementedError, match="plane and sphere"):
        _ = mixed().surface

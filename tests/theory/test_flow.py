"""The flow around a swimmer near a sphere: no slip, the drift that it causes, its limits and symmetries."""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps

RANDOM = np.random.default_rng(4)


def directions(n: int) -> np.ndarray:
    v = RANDOM.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def swimmer(radius: float, height: float, pitch: float) -> dict:
    n, t = directions(2)
    t = np.cross(n, t)
    t /= np.linalg.norm(t)
    return {
        "position": (radius + height) * n, "director": np.cos(pitch) * t + np.sin(pitch) * n, "radius": radius,
        "dipole_strength": 0.8,
    }  # fmt: skip


CASES = [(1.0, 0.5, -1.2), (20.0, 1.0, 0.2), (5.0, 3.0, 1.5), (200.0, 1.0, 0.0), (0.3, 10.0, 0.7)]


@pytest.mark.parametrize("case", CASES)
def test_the_fluid_sticks_to_the_sphere_everywhere_also_opposite_to_the_swimmer(case):
    about = swimmer(*case)
    opposite = -about["position"] / np.linalg.norm(about["position"])
    near = opposite + 1e-3 * directions(20)
    points = about["radius"] * np.concatenate([directions(500), [opposite, -opposite], near])
    points *= about["radius"] / np.linalg.norm(points, axis=1, keepdims=True)
    flow = ps.flow_field(points, **about)
    largest = about["dipole_strength"] * 2.0 / case[1] ** 2  # of the free flow on the sphere, at its nearest point
    assert np.abs(flow).max() < 1e-10 * largest


@pytest.mark.parametrize("case", CASES)
def test_far_from_the_sphere_it_is_the_flow_of_a_free_dipole(case):
    about = swimmer(*case)
    offset = 1e-3 * directions(50)  # near the swimmer its own flow, ~ 1/r^2, outweighs the image by 1e5 and more
    along = offset @ about["director"] / 1e-3
    free = about["dipole_strength"] * offset / 1e-9 * (3.0 * along[:, None] ** 2 - 1.0)
    flow = ps.flow_field(about["position"] + offset, **about)
    image = about["dipole_strength"] / min(case[1], 1.0) ** 2 * 4.0
    assert np.abs(flow - free).max() < image + 1e-9 * np.abs(free).max()


def image_near(about: dict, offsets: np.ndarray) -> np.ndarray:
    """The image's flow at points near the swimmer: the mean over +-offset, in which the free dipole (odd) cancels."""
    return 0.5 * (
        ps.flow_field(about["position"] + offsets, **about) + ps.flow_field(about["position"] - offsets, **about)
    )


@pytest.mark.parametrize("case", CASES)
def test_at_the_swimmer_the_image_is_the_velocity_that_drift_gives(case):
    about = swimmer(*case)
    velocity, _ = ps.drift(
        [about["position"]], [about["director"]], radius=about["radius"], dipole_strength=about["dipole_strength"]
    )  # fmt: skip
    step = 0.02 * min(case[1], 1.0) * np.eye(3)[:1]
    # even in the offset: the error falls as its square, twice the step tells it
    fine, coarse = image_near(about, step)[0], image_near(about, 2.0 * step)[0]
    expected = velocity[0] - about["director"]
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("case", CASES)
def test_no_fluid_is_made_or_lost(case):
    about = swimmer(*case)
    step = 1e-4 * case[1]
    points = about["radius"] * 1.3 * directions(100) + 0.3 * directions(100)
    away = np.linalg.norm(points - about["position"], axis=1) > 0.3 * case[1]
    points = points[away & (np.linalg.norm(points, axis=1) > about["radius"] * 1.05)]
    divergence, size = np.zeros(len(points)), np.zeros(len(points))
    for axis in np.eye(3):
        derivative = (ps.flow_field(points + step * axis, **about) - ps.flow_field(points - step * axis, **about)) / (
            2.0 * step
        )
        divergence += derivative @ axis
        size += np.abs(derivative).sum(axis=1)
    # central differences: (step/distance)^2 of the gradient, and rounding 1e-16 u/step
    assert np.all(np.abs(divergence) < 1e-5 * size + 1e-9)


def test_mirror_images_flow_as_mirror_images():
    about = swimmer(5.0, 2.0, 0.4)
    points = 9.0 * directions(30)
    mirror = np.array([1.0, -1.0, 1.0])
    reflected = {**about, "position": about["position"] * mirror, "director": about["director"] * mirror}
    assert ps.flow_field(points * mirror, **reflected) == pytest.approx(
        ps.flow_field(points, **about) * mirror, abs=1e-13
    )
    backwards = {**about, "director": -about["director"]}  # a dipole has no head
    assert ps.flow_field(points, **backwards) == pytest.approx(ps.flow_field(points, **about), abs=1e-14)


def test_wrong_arguments_are_one_sentence():
    about = swimmer(5.0, 2.0, 0.4)
    with pytest.raises(ValueError, match="inside the sphere of radius 5"):
        ps.flow_field([[1.0, 0, 0]], **about)
    with pytest.raises(ValueError, match="position: at 1"):
        ps.flow_field([[9.0, 0, 0]], **{**about, "position": [1.0, 0, 0]})
    with pytest.raises(ValueError, match="expected"):
        ps.flow_field([[9.0, 0]], **about)


def test_the_fluid_sticks_to_a_wall():
    (n, e), h = directions(2), 1.3
    along = 5.0 * directions(200)
    along -= np.outer(along @ n, n)
    flow = ps.flow_field(along, h * n, e, radius=np.inf, dipole_strength=0.8)
    assert np.abs(flow).max() < 1e-14 * 0.8 * 2.0 / h**2 * 10.0  # rounding of terms up to ten times the free flow


def test_the_image_in_a_wall_is_the_velocity_that_drift_gives():
    (n, e), h = directions(2), 1.3
    about = {"position": h * n, "director": e, "radius": np.inf, "dipole_strength": 0.8}
    step = 0.02 * np.eye(3)[:1]
    fine, coarse = image_near(about, step)[0], image_near(about, 2.0 * step)[0]
    velocity, _ = ps.drift([h * n], [e], radius=np.inf, dipole_strength=0.8)
    expected = velocity[0] - e
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


def test_the_flow_at_a_wall_is_the_limit_of_large_spheres():
    (n, e), h = directions(2), 1.3
    points = 3.0 * directions(100)
    points += np.outer(np.maximum(0.0, 0.1 - points @ n), n)
    points = points[np.linalg.norm(points - h * n, axis=1) > 0.3]
    wall = ps.flow_field(points, h * n, e, radius=np.inf, dipole_strength=0.8)

    def difference(A):
        sphere = ps.flow_field(points + A * n, (A + h) * n, e, radius=A, dipole_strength=0.8)
        return np.abs(sphere - wall).max()

    assert difference(1e4) == pytest.approx(0.1 * difference(1e3), rel=0.01)  # of first order in 1/A
    assert difference(1e4) < 1e-3


def test_behind_a_wall_there_is_no_flow():
    about = {"director": [1.0, 0, 0], "radius": np.inf, "dipole_strength": 0.8}
    with pytest.raises(ValueError, match="points: some are behind the wall"):
        ps.flow_field([[0, 0, -0.1]], [0, 0, 2.0], **about)
    with pytest.raises(ValueError, match="position: it is on the wall"):
        ps.flow_field([[0, 0, 1.0]], [0, 0, 0], **about)

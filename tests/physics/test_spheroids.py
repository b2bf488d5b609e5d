"""Contact of spheroids with spheres, against tabulated heights and the distance of points of their surface."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import porous_swim as ps
from porous_swim.engine.kernel.state import Int
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import field_of, hexagonal, make_engine, released

TABLE = json.loads((Path(__file__).parents[1] / "reference" / "contact.json").read_text(encoding="utf-8"))["values"]
OUTLINE = np.linspace(0.0, np.pi, 4001)  # of half the meridian; 4e-4 off in angle is 4e-8 off in distance


def distance_to_surface(distance, sine, gamma):
    """Least distance (n,) of a point at `distance` (n,) from the centre of a spheroid from its surface."""
    cosine = np.sqrt(1.0 - np.minimum(np.asarray(sine) ** 2, 1.0))
    x, y = np.asarray(distance) * sine, np.asarray(distance) * cosine
    return np.min(
        np.hypot(x[..., None] - np.cos(OUTLINE), y[..., None] - np.asarray(gamma)[..., None] * np.sin(OUTLINE)), axis=-1
    )


@pytest.mark.parametrize("case", TABLE)
def test_contact_heights_are_the_tabulated_ones(case):
    gamma, radius = (float(part.split("=")[1]) for part in case.split(","))
    heights = ps.contact_height(np.radians([float(d) for d in TABLE[case]]), radius=radius, aspect_ratio=gamma)
    assert heights == pytest.approx(np.array(list(TABLE[case].values())), rel=0, abs=1e-9)
    assert ps.contact_height([-0.4], radius=radius, aspect_ratio=gamma) == pytest.approx(
        ps.contact_height([0.4], radius=radius, aspect_ratio=gamma), rel=0, abs=1e-15
    )


@pytest.mark.parametrize("gamma", [0.01, 0.05, 0.15, 0.5, 0.95])
@pytest.mark.parametrize("radius", [0.05, 0.5, 3.0, 100.0])
def test_at_contact_the_nearest_point_of_the_surface_is_a_radius_away(gamma, radius):
    pitch = np.concatenate([np.linspace(-np.pi / 2, np.pi / 2, 61), [1e-6, np.pi / 2 - 1e-6]])
    height = ps.contact_height(pitch, radius=radius, aspect_ratio=gamma)
    nearest = distance_to_surface(radius + height, np.sin(pitch), np.full(len(pitch), gamma))
    # the outline's step times the extent across it, squared, over the distance: at most (4e-4)^2/0.05
    assert nearest == pytest.approx(np.full(len(pitch), radius), rel=0, abs=4e-6)


@pytest.mark.parametrize(
    ("dimensions", "precision", "integrator"),
    [
        *((d, precision, "euler") for d in (2, 3) for precision in ("f32", "f64")),
        pytest.param(2, "f32", "reflected", marks=pytest.mark.slow),
    ],
)
def test_a_turning_rod_never_enters_a_colloid(dimensions, precision, integrator):
    gamma = 0.2
    field = (
        hexagonal(radius=5.0, spacing=11.0) if dimensions == 2 else field_of([[5.4] * 3], 5.0, (10.8, 10.8, 10.8))
    )  # fmt: skip
    position, director = released(field, 100, seed=2)
    engine = make_engine(
        field, position, director, alpha=0.3, gamma=gamma, D=0.02, D_r=0.5, precision=precision, time_step=0.01,
        integrator=integrator,
    )  # fmt: skip
    n_near = 0
    for _ in range(150):
        engine.advance(1)
        now = engine.snapshot()
        point, colloid, offset = field.near(now.position, 1.0)
        distance = np.linalg.norm(offset, axis=1)
        sine = np.einsum("ij,ij->i", now.director[point], offset) / distance
        gap = distance_to_surface(distance, sine, np.full(len(point), gamma)) - field.radii[colloid]
        n_near += np.count_nonzero(gap < 1e-3)
        # 1e-6 is what the engine takes for rounding; to it the outline's step and, in f32, rounding of R = 6
        assert np.min(gap, initial=0.0) > -(1e-6 + 1e-7 + (1e-6 if precision == "f32" else 0.0))
    assert n_near > 100


def test_a_rod_is_bound_to_the_colloid_that_its_tip_strikes_not_to_the_nearest():
    # without flow the director stays; the centre is nearer to colloid 0, the tip comes to colloid 1
    turn = np.radians(119.5)
    ahead = np.array([np.sin(turn), -np.cos(turn), 0.0])
    field = field_of([[0.0, -5.6, 0.0], 6.0 * ahead], 5.0, dimensions=2)
    engine = make_engine(
        field, [-0.08 * ahead], [ahead], alpha=0.0, gamma=0.15, D=0.0, precision="f64", hydrodynamics=NoHydrodynamics
    )  # fmt: skip
    while not engine.snapshot().bound[0]:
        engine.advance(1)
        assert engine.step < 60
    state = engine._host()
    assert state.int[Int.COLLOID, 0] == 0
    rows = engine.encounters()
    assert rows["colloid"].tolist() == [1]
    assert rows["release_time"] == rows["start_time"] == engine.step * 0.005


def test_swimmers_held_by_both_walls_of_a_wedge_touch_to_the_end():
    field = field_of([[0.0, -5.5, 0.0], [0.0, 5.5, 0.0]], 5.0, dimensions=2)
    n = 40
    position = np.stack([np.full(n, -8.0), np.linspace(-1.5, 1.5, n), np.zeros(n)], axis=1)
    engine = make_engine(
        field, position, [[1.0, 0.0, 0.0]] * n, alpha=0.0, D=0.0, precision="f64", hydrodynamics=NoHydrodynamics
    )  # fmt: skip
    engine.advance(4000)
    now = engine.snapshot()
    heights = np.linalg.norm(now.position[:, None] - field.centers, axis=2) - 5.0
    both = np.all(heights < 1.0 + 1e-5, axis=1)
    assert np.count_nonzero(both) > 30
    rows = engine.encounters()
    held = both[rows["swimmer"]]
    assert rows["release_time"][held] == pytest.approx(np.full(held.sum(), 20.0), rel=0, abs=1e-9)


def test_a_rod_without_flow_slides_along_its_contact_curve_in_the_computed_time():
    """The director stays, so that the polar angle phi about it obeys dphi/dt = -sin(phi)/R(phi) while in contact."""
    gamma, A = 0.3, 4.0

    def distance(phi):
        return A + ps.contact_height([np.pi / 2 - phi], radius=A, aspect_ratio=gamma)[0]

    start, end = np.radians(160.0), np.radians(130.0)
    lasts = quad(lambda phi: distance(phi) / np.sin(phi), end, start, epsabs=1e-10, epsrel=1e-10)[0]
    steps = 37
    R = distance(start)
    engine = make_engine(
        field_of([0, 0, 0], A, dimensions=2), [[R * np.cos(start), R * np.sin(start), 0.0]], [[1.0, 0.0, 0.0]],
        alpha=0.0, gamma=gamma, D=0.0, precision="f64", time_step=lasts / steps, integrator="located",
        hydrodynamics=NoHydrodynamics,
    )  # fmt: skip
    engine.advance(steps)
    x, y, _ = engine.snapshot().position[0]
    assert np.arctan2(y, x) == pytest.approx(end, abs=1e-9)
    assert np.hypot(x, y) == pytest.approx(distance(end), abs=1e-10)


def test_a_located_rod_in_contact_follows_an_independent_integration():
    """Pitch and polar angle in contact from `ps.drift` and the tabulated kind of height, by SciPy's own integrator."""
    gamma, A, alpha = 0.5, 20.0, 0.3

    def rates(_, y):
        phi, theta = y
        R = A + ps.contact_height([theta], radius=A, aspect_ratio=gamma)[0]
        n, t = np.array([np.cos(phi), np.sin(phi), 0.0]), np.array([-np.sin(phi), np.cos(phi), 0.0])
        e = np.cos(theta) * t + np.sin(theta) * n
        velocity, turning = ps.drift([R * n], [e], radius=A, dipole_strength=alpha, aspect_ratio=gamma)
        turn = velocity[0] @ t / R
        # e turns by `turning` in the laboratory, the tangent by the polar angle
        return [turn, turning[0] @ (np.cos(theta) * n - np.sin(theta) * t) + turn]

    theta = -0.2
    R = A + ps.contact_height([theta], radius=A, aspect_ratio=gamma)[0]
    expected = solve_ivp(rates, (0.0, 2.0), [np.pi / 2, theta], rtol=1e-9, atol=1e-11).y[:, -1]
    engine = make_engine(
        field_of([0, 0, 0], A, dimensions=2), [[0.0, R, 0.0]], [[-np.cos(theta), np.sin(theta), 0.0]],
        alpha=alpha, gamma=gamma, D=0.0, precision="f64", time_step=0.1, integrator="located",
    )  # fmt: skip
    engine.advance(20)
    now = engine.snapshot()
    phi, pitch = np.arctan2(now.position[0, 1], now.position[0, 0]), np.arcsin(now.pitch_sine[0])
    assert [phi, pitch] == pytest.approx(expected, rel=0, abs=1e-8)
    assert now.height[0] == pytest.approx(ps.contact_height([pitch], radius=A, aspect_ratio=gamma)[0], abs=1e-11)

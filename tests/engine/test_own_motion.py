"""Flows and motilities that are no part of the package, with numbers of their own, against exact motion."""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.core.registry import forget
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import field_of, make_engine
from tests.support.motions import Paced, Swirl, Tumbling, tumble_of

A = 3.0
STRENGTH, POWER = np.array([0.5, -0.8, 0.3, 0.6]), np.array([2.0, 3.0, 2.0, 2.5])
SPEED = np.array([0.0, 0.0, 1.0, 1.0])
POSITION = np.array([[5.0, 0.0, 0.0], [0.0, 4.5, 0.0], [6.0, 1.0, 0.0], [-5.0, 7.0, 0.0]])
DIRECTOR = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8, 0.0], [-0.8, 0.6, 0.0]])


def swirling(**options):
    """Four swimmers about a colloid at the origin, in the plane: two that only drift, two that swim."""
    return make_engine(
        field_of([0, 0, 0], A, dimensions=2), POSITION, DIRECTOR, alpha=0.0, D=0.0, precision="f64",
        hydrodynamics=NoHydrodynamics, flows=(Swirl,), motility=Paced,
        own={"strength": STRENGTH, "power": POWER, "speed": SPEED}, set_of=np.arange(4, dtype=np.int32), **options,
    )  # fmt: skip


def stream(x):
    """(4,) of each swimmer, which its path keeps: its velocity is (d/dy, -d/dx) of it."""
    R = np.hypot(x[:, 0], x[:, 1])
    swum = SPEED * (DIRECTOR[:, 0] * x[:, 1] - DIRECTOR[:, 1] * x[:, 0])
    return swum - STRENGTH * A * (A / R) ** (POWER - 1.0) / (1.0 - POWER)


def test_a_swirl_of_its_own_numbers_carries_swimmers_on_exact_circles_and_along_stream_lines():
    engine = swirling(integrator="located", time_step=0.1)
    engine.advance(100)
    x = engine.snapshot().position
    R = np.hypot(*POSITION[:2, :2].T)
    angle = np.arctan2(POSITION[:2, 1], POSITION[:2, 0]) + STRENGTH[:2] * (A / R) ** POWER[:2] / R * 10.0
    # 1e-12 in each of some hundred steps
    np.testing.assert_allclose(x[:2, :2], R[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1), atol=1e-10)
    np.testing.assert_allclose(stream(x), stream(POSITION), atol=1e-9)
    assert np.linalg.norm(x[2:] - POSITION[2:], axis=1).min() > 5.0


def test_a_scene_file_names_a_flow_of_ones_own_with_its_numbers(tmp_path):
    file = tmp_path / "swirl.yaml"
    file.write_text("""
swimmers:
  count: 1
  dipole_strength: 0
  release: {kind: point, position: [6, 1], director: [0.6, 0.8]}
hydrodynamics: {kind: swirl, strength: 0.3, power: 2}
obstacles: {layout: single, radius: 3}
domain: {dimensions: 2}
run: {time_step: 0.1, duration: 10}
record: {every: 5, swimmers: 1, trails: 0}
""")
    ps.register(Swirl)
    try:
        path = ps.run(ps.load_scene(file)).trajectory
    finally:
        forget(Swirl)
    x = np.repeat([[path[name][-1].as_py() for name in ("x", "y")]], 4, axis=0)
    start = np.repeat(POSITION[2:3], 4, axis=0)
    np.testing.assert_allclose(stream(x)[2], stream(start)[2], atol=1e-5)  # positions are kept in single precision
    assert np.linalg.norm(x[2] - start[2, :2]) > 5.0


def test_in_lanes_it_is_the_sum_of_swimming_and_swirl():
    engine = swirling(time_step=0.01)
    engine.advance(500)
    x = POSITION[:, :2].copy()
    for _ in range(500):
        R = np.hypot(x[:, 0], x[:, 1])
        swirl = (STRENGTH * (A / R) ** POWER / R)[:, None] * np.stack([-x[:, 1], x[:, 0]], 1)
        x += 0.01 * (SPEED[:, None] * DIRECTOR[:, :2] + swirl)
    np.testing.assert_allclose(engine.snapshot().position[:, :2], x, atol=1e-10)  # 500 steps, rounded to 1e-15 each


def test_the_drift_of_a_flow_of_ones_own_is_what_it_says():
    flow = Swirl(strength=0.7, power=2.0)
    velocity, rate = ps.drift(
        [[4.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]], radius=A, dipole_strength=0.8, hydrodynamics=flow
    )  # fmt: skip
    assert velocity[0] == pytest.approx([0.0, 0.7 * (A / 4.0) ** 2, 1.0], abs=1e-15)
    assert rate[0] == pytest.approx([0.0, 0.0, 0.0])


def test_a_motility_of_ones_own_tumbles_as_often_as_it_says():
    rate, time_step, n = 0.5, 0.05, 20_000
    engine = make_engine(
        field_of([], 1.0, dimensions=2), np.zeros((n, 3)), np.tile([1.0, 0.0, 0.0], (n, 1)), alpha=0.0, D=0.0,
        time_step=time_step, motility=Tumbling, own={"tumble": tumble_of(rate, time_step)},
    )  # fmt: skip
    engine.advance(20)
    kept = engine.snapshot().director[:, 0]
    assert abs(kept.mean() - np.exp(-rate)) < 4.0 * kept.std() / np.sqrt(n)  # t = 1
    engine.advance(40)
    x = engine.snapshot().position[:, 0]
    expected = -np.expm1(-rate * 3.0) / -np.expm1(-rate * time_step) * time_step  # the sum of exp(-rate t) dt
    assert abs(x.mean() - expected) < 4.0 * x.std() / np.sqrt(n)

"""Reflecting walls and thresholds of a continuous path, against exact laws of Brownian motion with drift.

Without flow and without turns a swimmer that heads for a wall of large radius moves with a constant drift of 1 towards
it: each step then has the exact law, however long it is. Radii are so large that the wall is plane.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import field_of, make_engine, plane_wall

RADIUS = 1e5
COUNT = 20_000
STANDARD_ERRORS = 4.0


SPHERE = field_of([0, 0, 0], RADIUS, dimensions=2)
PLANE = plane_wall([0.0, RADIUS, 0.0], [0.0, 1.0, 0.0], 2)


def facing_a_wall(director, *, gap=0.0, field=SPHERE, **options):
    """Swimmers above a wall at y = RADIUS, without flow, in the plane."""
    position = np.tile([0.0, RADIUS + 1.0 + gap, 0.0], (COUNT, 1))
    return make_engine(
        field, position, np.tile(director, (COUNT, 1)), alpha=0.0, precision="f64", integrator="reflected",
        hydrodynamics=NoHydrodynamics, **options,
    )  # fmt: skip


def assert_mean(samples, expected):
    error = np.std(samples) / math.sqrt(len(samples))
    assert abs(np.mean(samples) - expected) < STANDARD_ERRORS * error, (np.mean(samples), error)


def test_pressed_to_a_wall_the_gap_has_the_exponential_law_at_any_step():
    D, time_step = 0.25, 0.1  # a kick of 0.22, as long as the mean gap D
    engine = facing_a_wall([0.0, -1.0, 0.0], D=D, D_r=0.0, time_step=time_step)
    engine.advance(100)  # ten relaxation times 4 D
    gap = np.linalg.norm(engine.snapshot().position, axis=1) - RADIUS - 1.0
    assert gap.min() > -1e-9
    for power in (1, 2, 3):
        assert_mean(gap**power, math.factorial(power) * D**power)
    for level in (0.1 * D, D, 3.0 * D):
        assert_mean(gap > level, math.exp(-level / D))
    # what the wall has pushed is what the swimmer swam, less the gap and the noise
    rows = engine.encounters()
    assert_mean(np.bincount(rows["swimmer"], rows["wall_push"], COUNT), 100 * time_step + D)


@pytest.mark.parametrize("field", [SPHERE, pytest.param(PLANE, marks=pytest.mark.slow)], ids=["sphere", "plane"])
def test_a_swimmer_leaves_a_wall_and_is_timed_as_a_continuous_path(field):
    D, level = 0.25, 0.5
    # from the wall to the level against a drift of 1: D (exp(level/D) - 1) - level
    exact = D * math.expm1(level / D) - level
    for time_step in (0.04, 0.02):  # kicks of 0.14 and 0.1
        engine = facing_a_wall([0.0, -1.0, 0.0], field=field, D=D, D_r=0.0, time_step=time_step)
        engine.advance(round(24.0 / time_step))
        rows = engine.encounters()
        first = rows["start_time"] == 0.0
        assert np.count_nonzero(first) == COUNT
        assert_mean((rows["end_time"] - rows["start_time"])[first], exact)
        # all of them end by the middle of a step; they began at the start of the run, at the wall
        ends = rows["end_time"][first & ~rows["end_censored"]] / time_step
        assert np.allclose(ends % 1.0, 0.5, rtol=0, atol=1e-6)
        assert np.all(rows["max_height"][first & ~rows["end_censored"]] >= 1.0 + level)
        assert np.allclose(rows["min_height"][~rows["start_censored"]], 1.0, rtol=0, atol=1e-9)


def test_first_contact_is_timed_as_a_continuous_path_and_lies_on_the_wall():
    D, gap, time_step = 0.25, 1.0, 0.05  # a kick of 0.16
    engine = facing_a_wall([0.0, -1.0, 0.0], gap=gap, D=D, D_r=0.0, time_step=time_step)
    engine.advance(400)
    rows = engine.encounters()
    order = np.lexsort((rows["start_time"], rows["swimmer"]))
    _, first = np.unique(rows["swimmer"][order], return_index=True)
    assert len(first) == COUNT
    start = rows["start_time"][order][first]
    # first passage over a distance at drift 1: inverse Gaussian with mean `gap` and variance 2 D gap
    assert_mean(start, gap)
    assert_mean((start - gap) ** 2, 2.0 * D * gap)
    assert np.allclose(np.hypot(rows["entry_x"], rows["entry_y"]) - RADIUS, 1.0, rtol=0, atol=1e-9)


def test_the_escape_pitch_is_passed_as_by_a_continuous_path():
    D_r, pitch, time_step, end = 0.5, 0.3, 0.01, 0.5  # turns by 0.1 in a step
    engine = facing_a_wall([1.0, 0.0, 0.0], D=1e-12, D_r=D_r, time_step=time_step, escape_sine=math.sin(pitch))
    engine.advance(round(end / time_step))
    rows = engine.encounters()
    passed = np.full(COUNT, np.inf)
    np.fmin.at(passed, rows["swimmer"], rows["escape_pitch_time"])
    for time in (0.1, 0.2, end):
        # a turn by diffusion passes the angle by then with this probability (reflection principle)
        assert_mean(passed < time - 0.25 * time_step, math.erfc(pitch / math.sqrt(4.0 * D_r * time)))

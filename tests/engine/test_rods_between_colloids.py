"""Rods among colloids so close that three are near at once: the nearest and contact, against a search on the host."""

from __future__ import annotations

import numpy as np
import pytest

from porous_swim.engine.probe import height_at_sine
from tests.support.engines import hexagonal, make_engine, released

GAMMA = 0.4
ROUNDING = 1e-5  # a, of offsets of some a in single precision, and the tolerance of contact, 1e-6
DEPTH = 5e-6


@pytest.fixture(scope="module")
def steps():
    """A field, and 600 steps of 400 rods in it."""
    field = hexagonal(radius=3.5, spacing=8.0)
    position, director = released(field, 400, seed=3)
    engine = make_engine(
        field, position, director, gamma=GAMMA, D=0.01, D_r=0.05, alpha=0.5, time_step=0.005, integrator="reflected",
        precision="f32",
    )  # fmt: skip
    engine.advance(1000)
    seen = []
    for _ in range(600):
        engine.advance(1)
        seen.append(engine.snapshot())
    return field, seen


def test_the_colloid_of_a_rod_is_the_nearest_one(steps):
    field, seen = steps
    for now in seen:
        _, _, height = field.nearest(now.position)
        center = field.centers[now.colloid] + now.image * field.box
        own = np.linalg.norm(now.position - center, axis=1) - field.radii[now.colloid]
        assert np.all(own <= height + ROUNDING)


def test_rods_reach_into_none_of_the_colloids_near(steps):
    field, seen = steps
    for now in seen:
        of, colloid, offset = field.near(now.position, 1.01)
        R = np.linalg.norm(offset, axis=1)
        sine = np.einsum("ij,ij->i", offset, now.director[of]) / R
        least = height_at_sine(sine, field.radii[colloid], aspect_ratio=GAMMA)
        assert np.all(R - field.radii[colloid] >= least - DEPTH)

"""Heights and times in contact are means over both ends of each step: against swimmers that go straight.

Without flow and noise a swimmer that presses on a disc with its pitch below 0 slides round at R = A + 1 until its pitch
is 0, and goes straight on along the tangent. All is known in closed form. Its starts lie anywhere in a step.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import field_of, make_engine

RADIUS, BAND, COUNT = 6.0, 0.05, 500
R = RADIUS + 1.0
TIME_STEP = 0.04


def straight(integrator: str, **noise) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Pitches at the start, from -0.6 to -0.2, and the encounters."""
    pitch = np.linspace(-0.6, -0.2, COUNT)
    director = np.stack([np.sin(pitch), np.cos(pitch), np.zeros(COUNT)], axis=1)
    engine = make_engine(
        field_of([0, 0, 0], RADIUS, dimensions=2), np.tile([R, 0.0, 0.0], (COUNT, 1)), director, alpha=0.0,
        hydrodynamics=NoHydrodynamics, precision="f64", time_step=TIME_STEP, integrator=integrator, **noise,
    )  # fmt: skip
    engine.advance(round(8.0 / TIME_STEP))
    return pitch, engine.encounters()


@pytest.mark.parametrize(
    ("integrator", "noise"),
    [("euler", {"D": 0.0}), ("reflected", {"D": 1e-10, "D_r": 0.0})],
    ids=["euler", "reflected"],
)
def test_contact_times_and_mean_heights_have_no_bias_of_half_a_step(integrator, noise):
    pitch, rows = straight(integrator, **noise)
    assert not np.any(rows["end_censored"])
    # d(pitch)/dt = cos(pitch)/R while it slides
    slide = R * 2.0 * np.arctanh(np.tan(-0.5 * pitch))
    contact = slide + math.sqrt((R + BAND) ** 2 - R**2)
    length = rows["end_time"] - rows["start_time"]
    rest = length - slide
    above = 0.5 * (rest * np.hypot(R, rest) + R**2 * np.arcsinh(rest / R)) - RADIUS * rest  # of sqrt(R^2 + t^2) - A
    # the edge of the band lies anywhere in a step: 4 standard errors of a uniform error, and what
    # is of second order (2 dt^2 is an upper estimate); by the ends of steps alone these are off by dt/2 and dt/4
    error = 4.0 * TIME_STEP / math.sqrt(12.0 * COUNT) + 2.0 * TIME_STEP**2
    assert np.mean(rows["contact_time"] - contact) == pytest.approx(0.0, abs=error)
    assert np.mean(rows["mean_height"] * length - (slide + above)) == pytest.approx(0.0, abs=error)


@pytest.mark.parametrize(
    ("integrator", "noise"),
    [("euler", {"D": 0.0}), ("reflected", {"D": 1e-10, "D_r": 0.0})],
    ids=["euler", "reflected"],
)
def test_a_swimmer_that_stays_is_in_contact_all_the_time(integrator, noise):
    engine = make_engine(
        field_of([0, 0, 0], RADIUS, dimensions=2), [[R + 0.31, 0.0, 0.0]], [[-1.0, 0.0, 0.0]], alpha=0.0,
        hydrodynamics=NoHydrodynamics, precision="f64", time_step=TIME_STEP, integrator=integrator, **noise,
    )  # fmt: skip
    engine.advance(125)
    rows = engine.encounters()
    assert rows["end_censored"].tolist() == [True]
    assert rows["contact_time"] == pytest.approx(rows["end_time"] - rows["start_time"], abs=1e-12)

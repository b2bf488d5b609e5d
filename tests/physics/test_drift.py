"""The drift and the contact height that the engine compiles, against independent values."""

import json
from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.engine.probe import drift_of

CASES = json.loads((Path(__file__).parents[1] / "reference" / "hydrodynamics.json").read_text())["cases"]
PUBLIC = [case for case in CASES if 0.0 <= case["Gamma"] < 1.0]
OTHERS = [case for case in CASES if not 0.0 <= case["Gamma"] < 1.0]
# the vectors' error over their norm: rounding of rho - A^2 for h << A in single precision
TOLERANCE = {"f64": 1e-12, "f32": 3e-5}


def geometry(case):
    """Offset and director in a frame turned at random, with the radial and the perpendicular unit vectors."""
    rng = np.random.default_rng(int(1e3 * case["A"]))
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    radial, across = frame[:, 0], frame[:, 1]
    director = np.sin(case["theta"]) * radial + np.cos(case["theta"]) * across
    return (case["A"] + case["h"]) * radial, director, radial, across


def assert_matches(case, velocity, rate, tolerance):
    _, director, radial, across = geometry(case)
    flow = case["u_r"] * radial + case["u_perp"] * across
    # Omega is the rate of the pitch: the director turns by Omega (radial cos - across sin)
    turning = case["Omega"] * (np.cos(case["theta"]) * radial - np.sin(case["theta"]) * across)
    assert np.linalg.norm(velocity - director - flow) <= tolerance * np.linalg.norm(flow)
    # by symmetry some do not turn: what rounding leaves is measured against the flow
    assert np.linalg.norm(rate - turning) <= tolerance * max(np.linalg.norm(turning), 0.01 * np.linalg.norm(flow))


def test_the_reference_has_the_cases_that_the_tests_count_on():
    assert (len(PUBLIC), len(OTHERS)) == (20, 8)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("case", PUBLIC)
def test_drift_is_that_of_the_oracle(case, precision):
    offset, director, _, _ = geometry(case)
    gamma = np.sqrt((1.0 - case["Gamma"]) / (1.0 + case["Gamma"]))
    velocity, rate = ps.drift(
        [offset], [director], radius=case["A"], dipole_strength=case["alpha"], aspect_ratio=gamma, precision=precision
    )
    assert_matches(case, velocity[0], rate[0], TOLERANCE[precision])


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("case", OTHERS)
def test_drift_is_that_of_the_oracle_for_any_bretherton_constant(case, precision):
    offset, director, _, _ = geometry(case)
    velocity, rate = drift_of(
        [offset], [director], case["A"], dipole_strength=case["alpha"], bretherton=case["Gamma"],
        hydrodynamics="image_dipole", precision=precision,
    )  # fmt: skip
    assert_matches(case, velocity[0], rate[0], TOLERANCE[precision])


def test_without_hydrodynamics_a_swimmer_goes_straight():
    velocity, rate = ps.drift([[0, 0, 6]], [[0, 0.6, 0.8]], radius=5.0, dipole_strength=4.0, hydrodynamics="none")
    assert velocity.tolist() == [[0.0, 0.6, 0.8]]
    assert rate.tolist() == [[0.0, 0.0, 0.0]]


def test_a_sphere_touches_at_height_one():
    assert ps.contact_height([-1.5, 0.0, 0.3], radius=20.0).tolist() == [1.0, 1.0, 1.0]


def test_a_rod_touches_a_plane_with_its_support_height():
    # sqrt(sin^2 + gamma^2 cos^2): gamma lying, 1 standing, sqrt((1 + gamma^2)/2) at 45 degrees
    heights = ps.contact_height([0.0, np.pi / 2, -np.pi / 4], radius=1e12, aspect_ratio=0.25)
    assert heights == pytest.approx([0.25, 1.0, np.sqrt((1 + 0.0625) / 2)], rel=1e-12)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (dict(hydrodynamics="images"), "expected one of none, image_dipole, near_wall, found 'images'"),
        (dict(precision="f16"), "expected f32 or f64, found 'f16'"),
    ],
)
def test_a_wrong_option_is_named(bad, message):
    with pytest.raises(ValueError, match=message):
        ps.drift([[0, 0, 6]], [[0, 0, 1]], radius=5.0, dipole_strength=1.0, **bad)


@pytest.mark.parametrize("aspect_ratio", [1.0, 0.4])
def test_near_wall_height_and_pitch_obey_the_reduced_equations_exactly(aspect_ratio):
    radius, alpha = 7.0, 0.6
    for pitch, height in ((0.3, 1.2), (-1.2, 0.8), (1.4, 2.0)):
        n, t = np.array([0.0, 0.6, 0.8]), np.array([0.0, 0.8, -0.6])
        e = np.cos(pitch) * t + np.sin(pitch) * n
        velocity, turning = ps.drift(
            [(radius + height) * n], [e], radius=radius, dipole_strength=alpha, aspect_ratio=aspect_ratio,
            hydrodynamics="near_wall",
        )  # fmt: skip
        turn = turning[0] @ (np.cos(pitch) * n - np.sin(pitch) * t) + velocity[0] @ t / (radius + height)
        expected = ps.theory.near_wall_rates(pitch, height, radius, alpha, aspect_ratio)
        assert (velocity[0] @ n, turn) == pytest.approx(expected, rel=1e-13)
        assert turning[0] @ e == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("aspect_ratio", [1.0, 0.4])
def test_near_wall_converges_to_the_full_drift_as_one_over_the_radius(aspect_ratio):
    def difference(radius):
        n, t = np.array([0.0, 0.6, 0.8]), np.array([0.0, 0.8, -0.6])
        e = np.cos(0.4) * t + np.sin(0.4) * n
        both = [
            ps.drift(
                [(radius + 1.3) * n], [e], radius=radius, dipole_strength=0.6, aspect_ratio=aspect_ratio,
                hydrodynamics=kind,
            ) for kind in ("near_wall", "image_dipole")
        ]  # fmt: skip
        return np.array([np.linalg.norm(near - full) for near, full in zip(*both, strict=True)])

    # the next order is h/A: 1.3e-4 of the drift at 1e4
    assert difference(1e4) == pytest.approx(0.1 * difference(1e3), rel=0.01)
    assert np.all(difference(1e4) < 1e-4)

"""Properties that the drift and the contact height must have at every place, by random examples.

EPS is the rounding of one operation in double precision. Of rho - A^2 rounding leaves EPS rho/(rho - A^2), relatively;
its third power is the largest that the drift has.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import porous_swim as ps

EPS = 2.3e-16
N = 64  # swimmers in each example
STRONG = 1e8  # a dipole beside whose flow the speed of swimming is lost: the flow is linear in it

checked = settings(max_examples=25, deadline=None, derandomize=True)
seeds = st.integers(0, 2**32 - 1)
radii = st.floats(0.05, 1e4)
heights = st.floats(0.1, 100.0)
strengths = st.floats(0.05, 20.0).flatmap(lambda size: st.sampled_from([size, -size]))
ratios = st.floats(0.01, 1.0)
factors = st.floats(-8.0, 8.0, allow_subnormal=False)  # Taichi flushes them to 0 in its process, numpy included


def unit_vectors(rng, n=N):
    vectors = rng.normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def directions(seed):
    """Normals and directors (N, 3), the sine (N, 1) of the pitch, and the generator."""
    rng = np.random.default_rng(seed)
    n, e = unit_vectors(rng), unit_vectors(rng)
    return n, e, np.sum(n * e, axis=1, keepdims=True), rng


def bretherton(gamma):
    return (1.0 - gamma**2) / (1.0 + gamma**2)


def sizes(radius, height, alpha):
    """What flow (but for a number of order 1) and turning are at most, and the relative rounding of rho - A^2."""
    distance = radius + height
    excess = height * (2.0 * radius + height)
    flow = 3.0 * abs(alpha) * radius * distance / excess**2
    # the rate is (3 alpha A rho/(2 H^3)) (b + Gamma P/4) s cos(theta) with b <= 2, |P| <= 12, s cos(theta) <= 1/2
    return flow, 1.25 * flow * distance / excess, EPS * distance**2 / excess


@checked
@given(seed=seeds, radius=radii, height=heights, alpha=strengths, gamma=ratios, mirrored=st.booleans())
def test_turned_or_mirrored_swimmers_move_and_turn_as_turned_or_mirrored(seed, radius, height, alpha, gamma, mirrored):
    n, e, _, rng = directions(seed)
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    Q *= (-1.0 if mirrored else 1.0) * np.linalg.det(Q)  # a rotation, or one with a mirror
    law = dict(radius=radius, dipole_strength=alpha, aspect_ratio=gamma)
    velocity, rate = ps.drift((radius + height) * n, e, **law)
    turned, turned_rate = ps.drift((radius + height) * n @ Q.T, e @ Q.T, **law)
    flow, turning, rounding = sizes(radius, height, alpha)
    # of the squared distance each frame leaves some ten roundings, of which the cube is taken
    assert np.max(np.abs(turned - velocity @ Q.T)) <= 60.0 * rounding * flow + 20.0 * EPS
    assert np.max(np.abs(turned_rate - rate @ Q.T)) <= 60.0 * rounding * turning


@checked
@given(seed=seeds, radius=radii, height=heights, alpha=strengths, gamma=ratios)
def test_the_sphere_drags_and_turns_a_swimmer_the_same_whether_it_faces_ahead_or_back(
    seed, radius, height, alpha, gamma
):
    # a dipole is its own image under e -> -e: each end of the axis turns as it did, to the bit
    n, e, _, _ = directions(seed)
    law = dict(radius=radius, dipole_strength=alpha, aspect_ratio=gamma)
    _, ahead = ps.drift((radius + height) * n, e, **law)
    _, back = ps.drift((radius + height) * n, -e, **law)
    assert np.array_equal(back, -ahead)
    assert np.max(np.abs(np.sum(ahead * e, axis=1))) <= 8.0 * EPS * sizes(radius, height, alpha)[1]


@checked
@given(seed=seeds, radius=radii, height=heights, alpha=strengths, gamma=ratios, factor=factors)
def test_flow_and_turning_are_proportional_to_the_dipole(seed, radius, height, alpha, gamma, factor):
    n, e, _, _ = directions(seed)
    places = ((radius + height) * n, e)
    velocity, rate = ps.drift(*places, radius=radius, dipole_strength=alpha, aspect_ratio=gamma)
    scaled, scaled_rate = ps.drift(*places, radius=radius, dipole_strength=factor * alpha, aspect_ratio=gamma)
    flow, turning, _ = sizes(radius, height, factor * alpha)
    # a factor in another place of a product of ten: no difference is taken behind it; velocities hold e as well
    assert np.max(np.abs(scaled - e - factor * (velocity - e))) <= 10.0 * EPS * (flow + 1.0 + abs(factor))
    assert np.max(np.abs(scaled_rate - factor * rate)) <= 10.0 * EPS * turning


@checked
@given(seed=seeds, radius=st.floats(0.05, 50.0), ratio=st.floats(0.001, 0.05), gamma=ratios)
def test_far_away_a_sphere_is_the_stokeslet_that_holds_it_in_the_flow_of_the_dipole(seed, radius, ratio, gamma):
    n, e, s, _ = directions(seed)
    R = radius / ratio
    velocity, rate = ps.drift(R * n, e, radius=radius, dipole_strength=STRONG, aspect_ratio=gamma)
    # the dipole's flow at the centre, -alpha (3 s^2 - 1)/R^2 n, times -6 pi mu A is the force of the held sphere
    stokeslet = 0.75 * radius * STRONG * (3.0 * s * s - 1.0) / R**2 * n  # over 8 pi mu
    # on the axis of a Stokeslet g n: u = 2 g n/R, rate of strain (g/R^2) (1 - 3 n n), no vorticity; Jeffery's equation
    flow, strained = 2.0 * stokeslet / R, np.sum(stokeslet * n, axis=1, keepdims=True) / R**2
    turning = -3.0 * bretherton(gamma) * strained * s * (n - s * e)
    # with a = (A/R)^2 the next order is a [6 q - 2 - 3 q] n + 3 a s e in the flow, at most 4, and in the rate
    # a [3 + (Gamma/4) (4 + 20 q)] s cos(theta), at most 4.5; to a = 0.0025 later orders stay below the half of it
    scale = 1.5 * STRONG * radius / R**3
    assert np.max(np.abs(velocity - e - flow)) <= 6.0 * ratio**2 * scale + 4.0 * EPS
    assert np.max(np.abs(rate - turning)) <= 6.75 * ratio**2 * scale / R


@checked
@given(seed=seeds, height=heights, flatness=st.floats(1e3, 1e6), alpha=strengths, gamma=ratios)
def test_a_large_sphere_is_a_plane_wall(seed, height, flatness, alpha, gamma):
    n, e, s, _ = directions(seed)
    velocity, rate = ps.drift(
        height * (1.0 + flatness) * n, e, radius=height * flatness, dipole_strength=alpha, aspect_ratio=gamma
    )
    # Blake's image of a force dipole at a no-slip plane
    k = 0.375 * alpha / height**2
    flow = k * ((3.0 * s * s - 1.0) * n + 2.0 * s * (e - s * n))
    turning = -k / height * (1.0 + 0.5 * bretherton(gamma) * (1.0 + s * s)) * s * (n - s * e)
    # next orders: 2 (h/A) s cos(theta) in the flow, (h/A) [1 - Gamma (2 s^2 - 1)]/2 s cos(theta) in the rate
    away = 1.1 / flatness + 60.0 * EPS * flatness
    assert np.max(np.abs(velocity - e - flow)) <= away * abs(k) + 4.0 * EPS
    assert np.max(np.abs(rate - turning)) <= away * abs(k) / height


@checked
@given(seed=seeds, height=heights, flatness=st.floats(100.0, 1e4), alpha=strengths, gamma=ratios)
def test_the_reduced_model_is_left_by_the_full_one_in_proportion_to_the_curvature(seed, height, flatness, alpha, gamma):
    n, e, _, _ = directions(seed)

    def difference(factor):
        radius = factor * flatness * height
        pair = [
            ps.drift((radius + height) * n, e, radius=radius, dipole_strength=alpha, aspect_ratio=gamma,
                     hydrodynamics=kind) for kind in ("image_dipole", "near_wall")
        ]  # fmt: skip
        return [full - near for full, near in zip(*pair, strict=True)]

    k = 0.375 * abs(alpha) / height**2
    for near, far, scale in zip(difference(1.0), difference(10.0), (k, k / height + 1.0 / height), strict=True):
        # in the rate comes 2 (h/A) s cos(theta) to the next order at a plane: the flow carries the swimmer round
        assert np.max(np.abs(near)) <= 1.6 / flatness * scale + 4.0 * EPS
        # c1/A + c2/A^2 + ...: ten times the difference at 10 A leaves 0.9 c2/A^2 of it
        bound = 3.0 / flatness**2 + 600.0 * EPS * flatness
        assert np.max(np.abs(10.0 * far - near)) <= bound * scale + 40.0 * EPS


@checked
@given(seed=seeds, radius=radii, height=heights, alpha=strengths, gamma=ratios, other=ratios)
def test_elongation_turns_a_swimmer_in_proportion_to_the_bretherton_constant(seed, radius, height, alpha, gamma, other):
    n, e, _, _ = directions(seed)
    rods, others, spheres = (
        ps.drift((radius + height) * n, e, radius=radius, dipole_strength=alpha, aspect_ratio=ratio)
        for ratio in (gamma, other, 1.0)
    )
    assert np.array_equal(rods[0], spheres[0])  # shape does not enter the velocity
    left = bretherton(other) * (rods[1] - spheres[1]) - bretherton(gamma) * (others[1] - spheres[1])
    assert np.max(np.abs(left)) <= 4.0 * EPS * sizes(radius, height, alpha)[1]


@checked
@given(seed=seeds, radius=st.floats(5.0, 1e4), share=st.floats(1e-3, 0.05), alpha=strengths, gamma=st.floats(0.01, 0.9))
def test_near_a_wall_a_spheroid_turns_faster_than_a_sphere_and_to_the_same_side(seed, radius, share, alpha, gamma):
    n, e, s, _ = directions(seed)
    rod, sphere = (
        ps.drift((1.0 + share) * radius * n, e, radius=radius, dipole_strength=alpha, aspect_ratio=ratio)[1]
        for ratio in (gamma, 1.0)
    )
    up, up_sphere = (np.sum(rate * n, axis=1) for rate in (rod, sphere))
    assert np.all(np.sign(up_sphere) == -np.sign(alpha * s[:, 0]))  # pushers lie down, pullers stand up
    # 1 + (Gamma/2) (1 + s^2) at a plane; the next order, (h/A) Gamma [(1 + s^2)/4 + s^2 - 1/2], is below h/A
    faster = 1.0 + 0.5 * bretherton(gamma) * (1.0 + s[:, 0] ** 2)
    assert np.all(up / up_sphere > 1.0)
    assert up / up_sphere == pytest.approx(faster, rel=1.1 * share)


@checked
@given(seed=seeds, radius=radii, gamma=ratios, larger=st.floats(1.0, 100.0))
def test_contact_heights_are_even_rise_with_the_pitch_and_with_the_radius(seed, radius, gamma, larger):
    pitch = np.sort(np.random.default_rng(seed).uniform(0.0, 0.5 * np.pi, N))
    height = ps.contact_height(pitch, radius=radius, aspect_ratio=gamma)
    assert np.array_equal(ps.contact_height(-pitch, radius=radius, aspect_ratio=gamma), height)
    # heights come from the sum of A and a length: rounding of a few EPS of 1
    assert np.all(np.diff(height) >= -10.0 * EPS)
    assert np.all((height >= gamma - 10.0 * EPS) & (height <= 1.0 + 10.0 * EPS))
    # a sphere that touches from inside a larger one leaves no less room
    wide = ps.contact_height(pitch, radius=larger * radius, aspect_ratio=gamma)
    assert np.all(wide >= height - 10.0 * EPS)

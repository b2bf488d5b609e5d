"""A plane wall: against the flow found from its boundary condition, large spheres, and motion that is known exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import porous_swim as ps
from porous_swim.engine.probe import drift_of
from porous_swim.obstacles.field import ObstacleField
from tests.support.engines import field_of, fingerprint, make_engine, plane_wall

POINT = np.array([3.0, -2.0, 0.0])  # of the wall
NORMALS = {2: np.array([0.6, -0.8, 0.0]), 3: np.array([2.0, -1.0, 2.0]) / 3.0}
TANGENTS = {2: np.array([0.8, 0.6, 0.0]), 3: np.array([1.0, 2.0, 0.0]) / math.sqrt(5.0)}


def wall(dimensions: int) -> ObstacleField:
    return plane_wall(POINT, NORMALS[dimensions], dimensions)


def directors(pitch, dimensions: int) -> np.ndarray:
    """Unit vectors (n, 3) at angles `pitch` (n,) above the wall, all to one side."""
    pitch = np.atleast_1d(pitch)[:, None]
    return np.sin(pitch) * NORMALS[dimensions] + np.cos(pitch) * TANGENTS[dimensions]


def at_height(height, n: int, dimensions: int) -> np.ndarray:
    """`n` places (n, 3) over the point of the wall."""
    return POINT + np.broadcast_to(height, n)[:, None] * NORMALS[dimensions]


# ---- the flow


def reflected(x, height, e, n_radial=60, n_around=64):
    """Velocity (3,) at x, possibly complex, of the flow that the wall z = 0 adds to a dipole of unit strength.

    It is the Stokes flow of the half-space that takes away the dipole's own flow at the wall: velocities v on the wall
    give 3 z/(2 pi) times the integral of r (r.v)/r^5 over it, r pointing from the wall to x.
    """
    nodes, weights = np.polynomial.legendre.leggauss(n_radial)
    angle, weights = 0.25 * np.pi * (nodes + 1.0), 0.25 * np.pi * weights
    around = 2.0 * np.pi * np.arange(n_around) / n_around
    distance = height * np.tan(angle)[:, None]
    area = (weights * height / np.cos(angle) ** 2)[:, None] * distance * (2.0 * np.pi / n_around)
    foot = np.stack([distance * np.cos(around), distance * np.sin(around), 0.0 * distance * around], axis=-1)
    d = foot - np.array([0.0, 0.0, height])
    size = np.linalg.norm(d, axis=-1, keepdims=True)
    own = d / size**3 * (3.0 * (d @ e)[..., None] ** 2 / size**2 - 1.0)
    r = x - foot
    square = np.sum(r * r, axis=-1, keepdims=True)
    kernel = r * np.sum(r * own, axis=-1, keepdims=True) / square**2.5
    return -1.5 * x[2] / np.pi * np.sum(kernel * area[..., None], axis=(0, 1))


def oracle(height, e, alpha, bretherton):
    """Velocity (3,) and director rate (3,) at a wall z = 0: the reflected flow, and Jeffery's equation in it."""
    x = np.array([0.0, 0.0, height], dtype=complex)
    flow = alpha * reflected(x, height, e).real
    gradient = np.stack([reflected(x + 1e-30j * axis, height, e).imag / 1e-30 for axis in np.eye(3)], axis=1) * alpha
    spin, strain = 0.5 * (gradient - gradient.T), 0.5 * (gradient + gradient.T)
    stretch = strain @ e
    return e + flow, spin @ e + bretherton * (stretch - e * (e @ stretch))


@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-13), ("f32", 5e-7)])
@pytest.mark.parametrize("hydrodynamics", ["image_dipole", "near_wall"])
def test_drift_is_that_of_the_boundary_condition(hydrodynamics, precision, tolerance):
    rng = np.random.default_rng(3)
    for height, bretherton, alpha in ((0.4, 0.9, 0.8), (1.0, 0.0, -1.5), (1.7, 0.4, 3.0), (6.0, 1.0, 0.5)):
        e = rng.normal(size=3)
        e /= np.linalg.norm(e)
        velocity, rate = oracle(height, e, alpha, bretherton)
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]  # a wall of any direction; frame[:, 2] is its normal
        ours = drift_of(
            [height * frame[:, 2]], [frame @ e], math.inf, dipole_strength=alpha, bretherton=bretherton,
            hydrodynamics=hydrodynamics, precision=precision,
        )  # fmt: skip
        size = abs(alpha) / height**2  # of the flow; rounding of its terms
        assert frame.T @ ours[0][0] == pytest.approx(velocity, rel=0, abs=tolerance * max(size, 1.0))
        assert frame.T @ ours[1][0] == pytest.approx(rate, rel=0, abs=tolerance * max(size / height, 1.0))


def test_walls_and_spheres_may_be_asked_for_together_and_without_flow_swimmers_go_straight():
    offset, e = np.array([[0.0, 1.2, 0.9], [0.0, 6.0, 8.0], [2.0, 0.0, 0.0]]), np.array([0.6, 0.0, 0.8])
    radius = np.array([math.inf, 5.0, math.inf])
    velocity, rate = ps.drift(offset, e, radius=radius, dipole_strength=0.8)
    for i in range(3):
        alone = ps.drift(offset[i], e, radius=radius[i], dipole_strength=0.8)
        assert (velocity[i].tolist(), rate[i].tolist()) == (alone[0][0].tolist(), alone[1][0].tolist())
    velocity, rate = ps.drift(offset, e, radius=math.inf, dipole_strength=0.8, hydrodynamics="none")
    assert velocity == pytest.approx(np.tile(e, (3, 1)), abs=1e-15)
    assert not rate.any()


@pytest.mark.parametrize("aspect_ratio", [1.0, 0.3])
def test_drift_and_contact_at_large_spheres_approach_those_at_the_wall_as_one_over_the_radius(aspect_ratio):
    n, pitch = NORMALS[3], 0.4
    e, radii = directors(pitch, 3), np.array([1e3, 1e4, 1e5, 1e6])
    numbers = dict(dipole_strength=0.8, aspect_ratio=aspect_ratio)
    spheres = ps.drift((radii[:, None] + 1.3) * n, np.tile(e, (4, 1)), radius=radii, **numbers)
    plane = ps.drift([1.3 * n], e, radius=math.inf, **numbers)
    heights = ps.contact_height(np.full(5, pitch), radius=np.append(radii, math.inf), aspect_ratio=aspect_ratio)
    differences = [np.linalg.norm(near - flat, axis=1) for near, flat in zip(spheres, plane, strict=True)]
    if aspect_ratio < 1.0:
        differences.append(np.abs(heights[:4] - heights[4]))
    for difference in differences:
        # next order: h/A of the difference, 2e-3 at 1e3; rounding of the sphere's drift: 1e-10 at 1e6, 1e-4 of it
        assert difference * radii == pytest.approx(np.full(4, difference[1] * radii[1]), rel=5e-3)


def test_a_spheroid_touches_with_its_lowest_point():
    outline = np.linspace(0.0, 2.0 * np.pi, 20_001)  # 3e-4 between points: 1e-8 of the height
    for gamma in (0.01, 0.3, 1.0):
        for pitch in (0.0, -0.2, 0.9, -1.5, 0.5 * math.pi):
            points = np.cos(outline) * math.sin(pitch) + gamma * np.sin(outline) * math.cos(pitch)
            height = ps.contact_height([pitch], radius=math.inf, aspect_ratio=gamma)
            assert height[0] == pytest.approx(-points.min(), abs=2e-7 * 0.3)


# ---- motion without noise


def located(field: ObstacleField, position, director, *, time_step=0.5, **options):
    return make_engine(
        field, position, director, D=0.0, precision="f64", integrator="located", time_step=time_step, **options
    )  # fmt: skip


def test_a_pusher_slides_straight_and_turns_parallel_as_its_equations_say():
    # in contact h = 1 and d(pitch)/dt = -k sin cos with k = 3 alpha/8, so that tan(pitch) decays exponentially; along
    # the wall it moves with cos (1 + 2 k sin), and the wall holds it off by -(sin + k (3 sin^2 - 1)), above 0 here
    k, first, duration = 0.375 * np.array([0.4, 0.8, 2.0]), np.array([-1.2, 0.1, -0.5]), 10.0
    engine = located(wall(3), at_height(1.0, 3, 3), directors(first, 3), alpha=k / 0.375, set_of=np.arange(3))
    engine.advance(20)
    now, rows = engine.snapshot(), engine.encounters()

    def pitch(t, k, first):
        return math.atan(math.tan(first) * math.exp(-k * t))

    def push(t, k, first):
        s = math.sin(pitch(t, k, first))
        return -s - k * (3.0 * s * s - 1.0)

    last = np.array([pitch(duration, *case) for case in zip(k, first, strict=True)])
    path = -np.log(np.tan(0.5 * np.abs(last)) / np.tan(0.5 * np.abs(first))) / k - 2.0 * (last - first)
    pushed = [quad(push, 0.0, duration, args=case, epsabs=1e-13)[0] for case in zip(k, first, strict=True)]
    # ten digits are what a located run promises
    assert np.arcsin(now.pitch_sine) == pytest.approx(last, rel=0, abs=1e-10)
    assert now.position == pytest.approx(at_height(1.0, 3, 3) + path[:, None] * TANGENTS[3], rel=0, abs=1e-10)
    assert rows["wall_push"][np.argsort(rows["swimmer"])] == pytest.approx(pushed, rel=0, abs=1e-10)
    assert rows["contact_time"] == pytest.approx(np.full(3, duration), abs=1e-12)
    assert rows["winding"].tolist() == [0.0] * 3


def test_a_wall_keeps_every_pusher_that_comes_to_it():
    alpha, pitch = (v.ravel() for v in np.meshgrid([0.05, 0.3, 0.8, 4.0], [-1.5, -0.9, -0.4]))
    n = len(alpha)
    engine = located(wall(3), at_height(4.0, n, 3), directors(pitch, 3), alpha=alpha, set_of=np.arange(n))
    engine.advance(800)
    rows, now = engine.encounters(), engine.snapshot()
    assert engine.counts() == (n, 0, 0, 0)
    assert rows["end_censored"].all()
    # from the steepest arrival a weak pusher turns by tan(pitch) exp(-(3 alpha/8) t), here exp(-7)
    assert np.all(np.abs(now.pitch_sine) < 14.2 * np.exp(-0.375 * alpha * 380.0) + 1e-12)
    assert now.height == pytest.approx(np.ones(n), rel=0, abs=1e-12)


def test_a_swimmer_lifts_off_the_wall_from_the_lift_off_pitch_on():
    # s + k (3 s^2 - 1) = 0 there, with k = 3 alpha/8; beyond it by d the swimmer rises with d (1 + 6 k s) cos(pitch),
    # until the flow, which turns it by -k s cos(pitch) in a unit of time, has taken d away
    k, excess = 0.3, 1e-3
    s = (math.sqrt(1.0 + 12.0 * k * k) - 1.0) / (6.0 * k)
    pitch = math.asin(s) + np.array([-excess, excess])
    engine = located(wall(3), at_height(1.0, 2, 3), directors(pitch, 3), time_step=1e-3, escape_sine=-2.0)
    engine.advance(60)
    rows = engine.encounters()
    order = np.argsort(rows["swimmer"])
    lifted = rows["max_height"][order] - 1.0
    assert abs(lifted[0]) < 1e-12
    # next order in the excess: a few of it over s, 1 %; the rise takes 14 steps, so that the top is seen to 0.2 %
    assert lifted[1] == pytest.approx(0.5 * excess**2 * (1.0 + 6.0 * k * s) / (k * s), rel=0.02)
    assert rows["escape_pitch_time"][order].tolist() == pytest.approx([math.nan, 0.0], nan_ok=True)


def test_a_rod_meets_large_spheres_as_it_meets_the_wall_with_a_difference_of_one_over_the_radius():
    columns = ("start_time", "entry_pitch", "wall_push", "exit_pitch", "mean_height")

    def encounter(field):
        engine = located(field, at_height(3.0, 1, 2), directors(-0.5, 2), alpha=0.8, gamma=0.4)
        engine.advance(30)
        rows = engine.encounters()
        return np.array([rows[name][0] for name in columns])

    flat = encounter(wall(2))
    radii = np.array([1e4, 1e5])
    scaled = [(encounter(field_of([POINT - A * NORMALS[2]], A, dimensions=2)) - flat) * A for A in radii]
    # next order: the path over the radius, 15/1e4; contact with a sphere is located to 1e-12 A, scaled 1e-2 at 1e5
    assert scaled[0] == pytest.approx(scaled[1], rel=5e-3, abs=2e-2)


# ---- motion with noise


def run_with_noise(dimensions, precision, *, n, director, time_step, duration, height=1.0, **options):
    engine = make_engine(
        wall(dimensions), at_height(height, n, dimensions), np.broadcast_to(director, (n, 3)), precision=precision,
        time_step=time_step, **options,
    )  # fmt: skip
    engine.advance(round(duration / time_step))
    return engine


CASES = pytest.mark.parametrize(("dimensions", "precision"), [(2, "f64"), (3, "f32")])


@CASES
def test_pitch_at_the_wall_has_its_equilibrium_distribution(dimensions, precision):
    # in contact the pitch drifts in the potential (3 alpha/16) sin^2 at temperature D_r; in space with the weight cos
    alpha, D_r, n = 0.8, 5e-4, 20_000
    engine = run_with_noise(
        dimensions, precision, n=n, director=directors(0.0, dimensions), time_step=0.02, duration=24.0, alpha=alpha,
        D=1e-12, D_r=D_r,
    )  # fmt: skip
    sine = engine.snapshot().pitch_sine

    def moment(power):
        def density(p):
            return math.sin(p) ** power * math.cos(p) ** (dimensions - 2) * math.exp(-k * math.sin(p) ** 2)

        k = 3.0 * alpha / (16.0 * D_r)
        return quad(density, -0.4, 0.4, epsabs=0.0, epsrel=1e-10, points=[0.0])[0]

    second, fourth = moment(2) / moment(0), moment(4) / moment(0)
    assert engine.counts() == (n, 0, 0, 0)  # lift-off is six deviations away
    assert abs(sine.mean()) < 4.0 * math.sqrt(second / n)
    # Euler widens the distribution by k dt/2 = 0.3 %
    assert np.mean(sine**2) == pytest.approx(second * 1.003, abs=4.0 * math.sqrt((fourth - second**2) / n))


@CASES
def test_a_swimmer_pressed_to_the_wall_has_the_barometric_height_distribution(dimensions, precision):
    # speed 1 towards the wall and diffusion D: heights above contact decay as exp(-z/D). A walk that is put back on the
    # wall after each step stands lower by 0.5826 of the step's deviation (Siegmund), and by O(dt)
    D, n, time_step = 0.5, 10_000, 0.005
    engine = run_with_noise(
        dimensions, precision, n=n, director=-NORMALS[dimensions], height=1.3, time_step=time_step, duration=20.0,
        alpha=0.0, D=D, D_r=0.0,
    )  # fmt: skip
    above = (engine.snapshot().position - POINT) @ NORMALS[dimensions] - 1.0
    assert above.min() > -2e-7
    expected = D - 0.5826 * math.sqrt(2.0 * D * time_step)
    assert above.mean() == pytest.approx(expected, abs=4.0 * D / math.sqrt(n) + time_step)


def test_one_lane_and_sixteen_give_the_same_bits():
    def run(lanes):
        engine = run_with_noise(
            3, "f32", n=50, director=directors(-0.5, 3), height=2.0, time_step=0.005, duration=40.0, alpha=0.8, D=0.02,
            lanes=lanes,
        )  # fmt: skip
        assert engine.counts()[1] > 10
        return fingerprint(engine)

    assert run(1) == run(None)


def test_heights_keep_their_digits_in_single_precision_however_far_swimmers_are_along_the_wall():
    # 1e5 from the wall's point single precision is 8e-3 coarse; steps are 5e-4 long
    far = POINT + 1e5 * TANGENTS[3] + NORMALS[3]
    engine = make_engine(wall(3), far[None], directors(0.0, 3), alpha=0.8, D=1e-14, D_r=0.0, time_step=5e-4)
    engine.advance(10_000)
    now, rows = engine.snapshot(), engine.encounters()
    assert rows["max_height"] == pytest.approx([1.0], abs=2e-7)
    assert rows["min_height"] == pytest.approx([1.0], abs=2e-7)
    # 1e-14 of diffusion for t = 5: 3e-7; rounding of 1e4 steps, each to 2^-24
    assert now.position - far == pytest.approx(5.0 * TANGENTS[3][None], rel=0, abs=2e-5)


def test_no_rod_ever_reaches_into_the_wall():
    gamma, n = 0.2, 200
    outline = np.linspace(0.0, 2.0 * np.pi, 4001)
    engine = make_engine(
        wall(3), at_height(1.2, n, 3), directors(np.linspace(-1.5, 1.5, n), 3), alpha=0.3, gamma=gamma, D=0.02, D_r=0.5,
        time_step=0.01,
    )  # fmt: skip
    near = 0
    for _ in range(60):
        engine.advance(5)
        now = engine.snapshot()
        height = (now.position - POINT) @ NORMALS[3]
        sine = np.clip(now.director @ NORMALS[3], -1.0, 1.0)[:, None]
        lowest = np.min(np.cos(outline) * sine + gamma * np.sin(outline) * np.sqrt(1.0 - sine**2), axis=1)
        # the outline's step squared, 1e-6; rounding of heights and directors in single precision
        assert np.min(height + lowest) > -(1e-6 + 3e-7)
        near += np.count_nonzero(height + lowest < 1e-3)
    assert near > 300

"""The exact escape pitch of spheres and rods in contact, from tabulated contact heights and the probed drift."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import json
import math
from pathlib import Path

import numpy as np
import pytest
import taichi as ti

import porous_swim as ps
from porous_swim.engine import backend
from porous_swim.engine.medium import on_device
from porous_swim.physics.contact import shape_of
from porous_swim.physics.lift_off import make_lift_off_sine
from porous_swim.physics.model import Model
from tests.support.engines import field_of, make_engine

TABLE = json.loads((Path(__file__).parents[1] / "reference" / "contact.json").read_text(encoding="utf-8"))["values"]
REALS = {"f32": (ti.f32, np.float32), "f64": (ti.f64, np.float64)}


def lift_offs():
    """(gamma, A, h, pitch, alpha): what dh/dt = 0 asks of alpha at tabulated pitches and contact heights."""
    found = []
    for case, heights in TABLE.items():
        gamma, radius = (float(part.split("=")[1]) for part in case.split(","))
        for degrees in (5, 10, 20, 30):
            pitch, height = math.radians(degrees), heights[str(degrees)]
            e = [[math.sin(pitch), math.cos(pitch), 0.0]]
            flow = ps.drift([[radius + height, 0, 0]], e, radius=radius, dipole_strength=1.0, aspect_ratio=gamma)
            outward = flow[0][0, 0] - e[0][0]  # per unit of alpha
            found.append((gamma, radius, height, pitch, -e[0][0] / outward))
    return found


def lift_off_sines(radius, alpha, gamma, *, precision="f64"):
    """Sines (n,) by the engine's function, of rods, needles or spheres as the least gamma and radius ask."""
    real, dtype = REALS[precision]
    shape = shape_of(float(np.min(gamma)), float(np.min(radius)))
    lift_off_sine = make_lift_off_sine(Model(real, shape=shape))
    Numbers = ti.types.ndarray(real, ndim=1)

    @ti.kernel
    def probe(A: Numbers, alpha: Numbers, gamma: Numbers, sine: Numbers):
        for i in range(A.shape[0]):
            sine[i] = lift_off_sine(A[i], alpha[i], gamma[i])

    backend.ensure_any()
    columns = [on_device(np.array(c, dtype)) for c in np.broadcast_arrays(radius, alpha, gamma)]
    sine = on_device(np.zeros(columns[0].shape, dtype))
    probe(*columns, sine)
    return sine.to_numpy()


def test_a_rod_passes_the_exact_escape_pitch_where_its_height_begins_to_grow():
    gamma, radius, height, pitch, alpha = np.array(lift_offs()).T
    # two swimmers for each, a little flatter and a little steeper, at colloids too far apart to be felt
    tilt = np.repeat(pitch, 2) + np.tile([-1e-9, 1e-9], len(pitch))
    center = np.arange(len(pitch))[:, None] * [[1000.0, 0.0, 0.0]]
    position = np.repeat(center + (radius + height)[:, None] * [[0.0, 1.0, 0.0]], 2, axis=0)
    director = np.stack([np.cos(tilt), np.sin(tilt), np.zeros(len(tilt))], axis=1)
    engine = make_engine(
        field_of(center, radius), position, director, alpha=alpha, gamma=gamma, D=0.0, precision="f64",
        escape_sine=-2.0, set_of=np.repeat(np.arange(len(pitch), dtype=np.int32), 2),
    )  # fmt: skip
    rows = engine.encounters()
    passed = np.full(len(tilt), np.nan)
    passed[rows["swimmer"]] = rows["escape_pitch_time"]
    assert len(rows["swimmer"]) == len(tilt)  # each touches its colloid
    # 1e-9: heights have 13 digits and the drift 12
    assert np.isnan(passed[0::2]).all()
    assert (passed[1::2] == 0.0).all()


@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-11), ("f32", 5e-6)])
def test_the_lift_off_of_rods_is_that_of_the_tabulated_contact(precision, tolerance):
    # the tolerances are those of the drift and of contact heights in either precision
    gamma, radius, _, pitch, alpha = np.array(lift_offs()).T
    sine = lift_off_sines(radius, alpha, gamma, precision=precision)
    assert sine == pytest.approx(np.sin(pitch), rel=0, abs=tolerance)


@pytest.mark.parametrize("gamma", [1.0, 0.3, 0.02])
def test_the_lift_off_is_the_escape_angle_of_theory(gamma):
    # whose contact heights and rates are written without the engine, and whose roots end at 1e-15
    radius, alpha = (grid.ravel() for grid in np.meshgrid([1.0, 3.0, 50.0, 1e4], [1e-6, 0.03, 0.4, 2.0, 10.0]))
    exact = [math.sin(ps.theory.escape_angle(a, A, gamma)) for A, a in zip(radius, alpha, strict=True)]
    assert lift_off_sines(radius, alpha, gamma) == pytest.approx(exact, rel=1e-9, abs=1e-14)


def test_a_neutral_rod_leaves_as_soon_as_it_points_outwards():
    assert lift_off_sines([5.0, 50.0], 0.0, 0.3) == pytest.approx([0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize(("alpha", "sine"), [(0.8, -2.0), (0.0, -2.0), (-0.8, 2.0)])
def test_a_scene_may_ask_rods_for_the_exact_escape_pitch(alpha, sine):
    scene = ps.load_scene("scenes/single_colloid.yaml").replace(
        {"swimmers.dipole_strength": alpha, "swimmers.aspect_ratio": 0.4, "encounter.escape_pitch": "exact"}
    )
    # -2: by the colloid's radius; a puller in contact is drawn in, never lifts off and has none
    assert scene.encounter.escape_sine(alpha, 0.4) == sine


def pitch_rates(pitch, radius, alpha, gamma):
    """dtheta/dt (n,) in contact, from the probed drift: the turn of the director and that of the normal."""
    distance = radius + ps.contact_height(pitch, radius=radius, aspect_ratio=gamma)
    s, c, zero = np.sin(pitch), np.cos(pitch), np.zeros_like(pitch)
    velocity, rate = ps.drift(
        distance[:, None] * [1.0, 0.0, 0.0], np.stack([s, c, zero], axis=1),
        radius=radius, dipole_strength=alpha, aspect_ratio=gamma,
    )  # fmt: skip
    return c * rate[:, 0] - s * rate[:, 1] + velocity[:, 1] / distance


@pytest.mark.parametrize(("alpha", "gamma"), [(0.8, 1.0), (0.4, 0.5), (0.1, 0.25)])
def test_at_the_critical_radius_the_lift_off_is_a_pitch_at_rest(alpha, gamma):
    radius = ps.theory.critical_radius(alpha, gamma)
    pitch = np.arcsin(lift_off_sines([radius], alpha, gamma))
    # the root's 1e-12 and rounding of rho - A^2, against a rate of 1/A for the swimmer without a dipole
    assert pitch_rates(pitch, radius, alpha, gamma) == pytest.approx([0.0], abs=1e-11 / radius)


@pytest.mark.parametrize(("share", "n_rests"), [(0.98, 0), (0.993, 2), (1.01, 1)])
def test_a_thin_rod_may_rest_below_lift_off_at_less_than_the_critical_radius(share, n_rests):
    # gamma 0.25, alpha 0.1: from 0.987 A_c on a stable pitch, and an unstable one that passes the lift-off at A_c
    alpha, gamma = 0.1, 0.25
    radius = share * ps.theory.critical_radius(alpha, gamma)
    pitch = np.linspace(1e-3, float(np.arcsin(lift_off_sines([radius], alpha, gamma))[0]), 2000)
    assert np.count_nonzero(np.diff(np.sign(pitch_rates(pitch, radius, alpha, gamma)))) == n_rests

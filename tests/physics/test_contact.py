"""Hard contact and exact bookkeeping: nobody penetrates, the nearest colloid is the nearest."""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import field_of, make_engine, packed, released

F32_ROUNDING = 2e-6  # a; one unit in the last place of an offset of 16 to 32
TIE = 1e-5  # a; two surfaces that differ by less count as equally near


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_the_nearest_colloid_is_the_nearest_in_a_polydisperse_packing(precision):
    field = packed(10_000)
    engine = make_engine(field, *released(field, 500), alpha=0.8, D=0.01, time_step=0.01, precision=precision)
    changes = 0
    for _ in range(20):
        before = engine.snapshot()
        engine.advance(200)
        now = engine.snapshot()
        changes += np.count_nonzero((now.colloid != before.colloid) | np.any(now.image != before.image, axis=1))
        held = now.position - field.centers[now.colloid] - now.image * field.box
        held = np.linalg.norm(held, axis=1) - field.radii[now.colloid]
        _, _, nearest = field.nearest(now.position)  # a k-d tree over centres for each class of radii
        assert np.all(np.abs(held - nearest) <= TIE)
        assert nearest.min() >= 1.0 - F32_ROUNDING
    assert changes > 2000  # hand-overs did happen


@pytest.mark.parametrize(
    ("dimensions", "precision", "integrator"),
    [*((d, precision, "euler") for d in (2, 3) for precision in ("f32", "f64")), (2, "f32", "reflected")],
)
def test_a_pusher_in_a_wedge_penetrates_neither_sphere_and_makes_no_false_hop(dimensions, precision, integrator):
    # two spheres of radius 5 with a gap of 1: a swimmer of radius 1 does not pass between them
    field = field_of([[-5.5, 0, 0], [5.5, 0, 0]], 5.0, dimensions=dimensions)
    start = [[0.0, np.sqrt(36.0 - 30.25) + 0.3, 0.0]] * 8
    tilt = np.linspace(-0.2, 0.2, 8)
    director = np.stack([np.sin(tilt), -np.cos(tilt), np.zeros(8)], axis=1)
    engine = make_engine(
        field, start, director, alpha=4.0, D=0.0, precision=precision, time_step=0.005, integrator=integrator
    )  # fmt: skip
    lowest = np.inf
    for _ in range(1000):
        engine.advance(100)
        position = engine.snapshot().position
        height = np.linalg.norm(position[:, None] - field.centers, axis=2) - 5.0
        lowest = min(lowest, height.min())
    assert lowest >= 1.0 - F32_ROUNDING
    rows = engine.encounters()
    hops = engine.counts()[2]
    # held in the wedge each swimmer has one encounter, never ended: the other sphere is touched, not hopped to
    in_wedge = np.abs(engine.snapshot().position[:, 0]) < 0.5
    assert np.all(in_wedge)
    assert hops == 0
    assert len(rows["swimmer"]) == 8
    assert np.all(rows["end_censored"])


def test_a_swimmer_slides_along_the_groove_between_two_spheres():
    # in space the wedge is a circle: a swimmer pressed into it and along it must move along it, not freeze
    field = field_of([[-5.5, 0, 0], [5.5, 0, 0]], 5.0)
    groove = np.sqrt(36.0 - 30.25)
    director = np.array([[0.0, -np.cos(0.6), np.sin(0.6)]])
    engine = make_engine(field, [[0.0, groove, 0.0]], director, alpha=0.0, D=0.0, precision="f64", time_step=0.005)
    engine.advance(100)
    position, angle = engine.snapshot().position[0], np.sin(0.6) * 0.5 / groove
    assert np.hypot(position[1], position[2]) == pytest.approx(groove, abs=1e-5)
    # the director keeps its direction (alpha = 0): the angle obeys d(phi)/dt = sin(0.6 + phi')/groove, bracketed here
    swept = np.arctan2(position[2], position[1])
    assert angle < swept < 1.3 * angle


@pytest.mark.parametrize("integrator", ["euler", "reflected"])
def test_a_touched_neighbour_takes_over_at_the_end_of_an_encounter(integrator):
    # the gap of 2.2 is wide enough to pass and narrower than twice the escape height
    field = field_of([[-6.1, 0, 0], [6.1, 0, 0]], 5.0, dimensions=2)
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, 400)
    director = np.stack([np.cos(angle), np.sin(angle), np.zeros(400)], axis=1)
    engine = make_engine(
        field, [[0.0, 3.5, 0.0]] * 400, director, alpha=2.0, D=0.02, time_step=0.002, integrator=integrator
    )
    engine.advance(20_000)
    rows = engine.encounters()
    order = np.lexsort((rows["start_time"], rows["swimmer"]))
    who, colloid, start, end = (rows[key][order] for key in ("swimmer", "colloid", "start_time", "end_time"))
    direct = (who[1:] == who[:-1]) & (start[1:] == end[:-1])
    assert np.count_nonzero(direct) > 20
    assert np.all(colloid[1:][direct] != colloid[:-1][direct])
    entry = np.stack([rows[f"entry_{axis}"][order] for axis in "xyz"], axis=1)[1:][direct]
    height = np.linalg.norm(entry - field.centers[colloid[1:][direct]], axis=1) - 5.0
    assert np.all(height <= 1.5)
    later = (who[1:] == who[:-1]) & ~direct
    assert np.all(start[1:][later] > end[:-1][later])


def test_a_swimmer_released_in_contact_starts_its_encounter_at_once():
    field = field_of([0, 0, 0], 20.0)
    heights = np.array([1.0, 1.0 + 5e-7, 1.0 + 1e-4])
    position = np.stack([np.zeros(3), 20.0 + heights, np.zeros(3)], axis=1)
    engine = make_engine(field, position, [[1.0, 0, 0]] * 3, D=0.0, precision="f64")
    assert engine.snapshot().bound.tolist() == [True, True, False]
    engine.advance(10)
    rows = engine.encounters()
    assert rows["start_time"][rows["swimmer"] < 2].tolist() == [0.0, 0.0]
    assert not rows["start_censored"].any()


@pytest.mark.parametrize("gamma", [0.15, 0.5])
def test_rods_keep_their_contact_height_above_every_colloid(gamma):
    field = packed(60, smallest=2.0, largest=4.0, fraction=0.3)
    position, director = released(field, 200)
    engine = make_engine(field, position, director, alpha=0.8, gamma=gamma, D=0.01, time_step=0.005)
    for _ in range(20):
        engine.advance(100)
        now = engine.snapshot()
        point, colloid, offset = field.near(now.position, 1.0)
        distance = np.linalg.norm(offset, axis=1)
        s = np.einsum("ij,ij->i", now.director[point], offset) / distance
        least = ps.contact_height(np.arcsin(s), radius=field.radii[colloid], aspect_ratio=gamma)
        assert np.min(distance - field.radii[colloid] - least, initial=0.0) >= -F32_ROUNDING


def test_the_wall_is_touched_by_swimmers_that_keep_their_plane_in_two_dimensions():
    field = field_of([[5.0, 5.0, 0.0]], 3.0, (12.0, 12.0, 0.0), 2)
    engine = make_engine(field, *released(field, 50), alpha=4.0, D=0.01)
    engine.advance(3000)
    now = engine.snapshot()
    assert not now.position[:, 2].any()
    assert not now.director[:, 2].any()
    assert np.linalg.norm(now.director, axis=1) == pytest.approx(np.ones(50), abs=3e-7)
    assert now.bound.any()
    assert np.isfinite(engine.encounters()["signed_winding"]).all()


def test_one_colloid_in_a_box_hops_to_its_own_images():
    field = field_of([[0.0, 0.0, 0.0]], 3.5, (10.0, 10.0 * np.sqrt(3.0), 0.0), 2)
    engine = make_engine(field, *released(field, 200), alpha=2.0, D=0.02)
    engine.advance(10_000)
    rows = engine.encounters()
    _, _, hops, _ = engine.counts()
    assert hops > 50
    assert np.all(rows["colloid"] == 0)
    center = np.stack([rows["image_x"] * 10.0, rows["image_y"] * 10.0 * np.sqrt(3.0)], axis=1)
    entry = np.stack([rows["entry_x"], rows["entry_y"]], axis=1)
    assert np.linalg.norm(entry - center, axis=1) == pytest.approx(np.full(len(center), 4.5), abs=1e-4)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_nose_on_puller_winds_no_more_than_it_moves(precision):
    # at rest its director points at the centre: the tangential direction is then a ratio of rounding errors
    field = field_of([0, 0, 0], 20.0)
    engine = make_engine(field, [[21.5, 0.5, 0]] * 20, [[-1.0, 0, 0]] * 20, alpha=-0.8, D=0.002, precision=precision)
    engine.advance(4000)
    rows = engine.encounters()
    lasted = rows["end_time"] - rows["start_time"]
    assert lasted.max() > 10.0
    # each step's winding is at most |dx|/(2 pi R): drift below 2 and a kick of 6 standard deviations, 0.005 long
    step = 2.0 * 0.005 + 6.0 * np.sqrt(2 * 0.002 * 0.005)
    assert np.all(np.abs(rows["winding"]) <= lasted / 0.005 * step / (2 * np.pi * 21.0))
    assert np.abs(rows["winding"]).max() < 1.0


def test_a_slow_slide_on_a_large_colloid_is_not_lost_in_single_precision():
    # steps of 5e-4 on a radius of 2e4, where numbers in single precision are 2e-3 apart: alpha = 0, pitch 0, and the
    # swimmer slides at speed 1 along the wall: 5 a in t = 5, less the 6e-4 that its lift off the curved wall costs
    field = field_of([0, 0, 0], 2e4)
    engine = make_engine(field, [[0, 2e4 + 1.0, 0]], [[1.0, 0, 0]], alpha=0.0, D=0.0, precision="f32", time_step=5e-4)
    engine.advance(10_000)
    assert engine.snapshot().position[0, 0] == pytest.approx(5.0, abs=2e-3)


def test_a_single_colloid_in_a_long_channel_is_indexed():
    field = field_of([0, 0, 0], 1.0, (400.0, 8.0, 0.0), 2)
    engine = make_engine(field, *released(field, 40), alpha=0.8, D=0.01)
    engine.advance(2000)
    now = engine.snapshot()
    held = np.linalg.norm(now.position - now.image * field.box, axis=1) - 1.0
    assert held == pytest.approx(field.nearest(now.position)[2], abs=TIE)


def test_a_swimmer_that_leaves_and_touches_in_one_step_is_with_the_colloid_it_touched_last():
    # along x past the first colloid (from contact at x = 0; height 1.5 above it at x = 1.5), it grazes the second
    # near x = 1 and strikes the third in the step to x = 1.6, still within reach of the second
    field = field_of([[0.0, -2.0, 0.0], [1.0, 1.999, 0.0], [3.55, 0.0, 0.0]], 1.0, dimensions=2)
    engine = make_engine(
        field, [[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0]], alpha=0.0, D=0.0, time_step=0.2, hydrodynamics=NoHydrodynamics,
        precision="f64", integrator="euler",
    )  # fmt: skip
    engine.advance(10)
    rows = engine.encounters()
    assert rows["colloid"].tolist() == [0, 2]
    assert rows["end_time"][0] == rows["start_time"][1] == pytest.approx(1.6)

"""Swimmers that two or more colloids touch at once: rods in necks, spheres in wedges, cages."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import field_of, fingerprint, make_engine, packed, released

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "rods_in_necks.json").read_text())
CASES = REFERENCE["cases"]
ROUNDING = 4e-6  # a; contact heights in single precision, at distances of 6
# Time that Euler steps add at walls, times the root of the step: docs/convergence.md. The reference makes them, too.
CLAMP = 0.41


def in_a_neck(case, *, integrator, n, time_step=0.005, **options):
    """Rods that swim into the neck of a case of the reference: engine and field."""
    half = REFERENCE["radius"] + 0.5 * case["gap"]
    field = field_of([[0, half, 0], [0, -half, 0]], REFERENCE["radius"], dimensions=case["dimensions"])
    start, director = [[-REFERENCE["start"], 0, 0]] * n, [[1.0, 0, 0]] * n
    engine = make_engine(
        field, start, director, alpha=0.0, gamma=case["gamma"], D=REFERENCE["D"], D_r=REFERENCE["D_r"],
        time_step=time_step, integrator=integrator, hydrodynamics=NoHydrodynamics, **options,
    )  # fmt: skip
    return engine, field


def overlap(now, field, gamma) -> float:
    """How deep a rod reaches into a sphere, by the contact height of the host."""
    point, colloid, offset = field.near(now.position, 1.0)
    distance = np.linalg.norm(offset, axis=1)
    s = np.einsum("ij,ij->i", now.director[point], offset) / distance
    least = ps.contact_height(np.arcsin(np.clip(s, -1, 1)), radius=field.radii[colloid], aspect_ratio=gamma)
    return float(np.max(field.radii[colloid] + least - distance, initial=0.0))


def check_stays(case, *, integrator, n, **options):
    engine, field = in_a_neck(case, integrator=integrator, n=n, **options)
    left, place, turns = np.full(n, np.inf), np.zeros(n), []
    look, time_step = REFERENCE["look"], 0.005
    before, inside, deepest = engine.snapshot().director, np.ones(n, bool), 0.0
    for k in range(1, round(REFERENCE["last"] / look) + 1):
        engine.advance(round(look / time_step))
        now = engine.snapshot()
        distance = np.linalg.norm(now.position, axis=1)
        turns.append(np.einsum("ij,ij->i", before, now.director)[inside])
        waiting = np.isinf(left)
        left[waiting & (distance > REFERENCE["far"])] = k * look
        place[waiting] = now.position[waiting, 0]
        before, inside = now.director, distance < REFERENCE["start"]
        deepest = max(deepest, overlap(now, field, case["gamma"]))
    assert deepest <= ROUNDING
    assert engine.jammed == 0
    # <e(t).e(0)> = exp(-(d - 1) D_r t) wherever a rod is at t = 0; 4 standard errors
    cosine = np.concatenate(turns)
    share = (1.0 - cosine) / (1.0 - np.exp(-(case["dimensions"] - 1) * REFERENCE["D_r"] * look))
    assert share.mean() == pytest.approx(1.0, abs=4.0 * share.std() / np.sqrt(len(share)))
    # 4 standard errors of both, and what the steps of both may be off
    stay, beyond = np.minimum(left, REFERENCE["last"]), place > 0.0
    bias = CLAMP * np.sqrt(max(time_step, REFERENCE["step"])) * case["stay"]
    error = 4.0 * np.hypot(case["stay_error"], stay.std() / np.sqrt(n))
    assert stay.mean() == pytest.approx(case["stay"], abs=error + bias)
    binomial = np.sqrt(max(beyond.mean() * (1.0 - beyond.mean()), 1.0 / n) / n)
    assert beyond.mean() == pytest.approx(case["beyond"], abs=4.0 * np.hypot(case["beyond_error"], binomial) + 0.02)


@pytest.mark.parametrize(("which", "integrator"), [(7, "reflected"), (0, "euler"), (21, "reflected")])
def test_rods_turn_freely_in_a_neck_and_leave_it_as_in_small_steps(which, integrator):
    check_stays(CASES[which], integrator=integrator, n=400)


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["reflected", "euler"])
@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c['dimensions']}d-{c['gamma']}-{c['gap']:.3g}")
def test_rods_of_all_kinds_leave_necks_of_all_widths_as_in_small_steps(case, integrator):
    check_stays(case, integrator=integrator, n=2000)


def test_rods_in_double_precision_leave_a_neck_as_in_small_steps():
    check_stays(CASES[6], integrator="reflected", n=200, precision="f64")


def test_lanes_and_launches_change_no_bit_of_a_rod_among_close_spheres():
    field = packed(60, smallest=2.0, largest=4.0, fraction=0.35)
    position, director = released(field, 150)
    prints = set()
    for lanes, cut in ((32, 600), (1, 600), (4, 50)):
        engine = make_engine(
            field, position, director, alpha=0.8, gamma=0.4, D=0.01, integrator="reflected", lanes=lanes
        )
        for _ in range(600 // cut):
            engine.advance(cut)
        prints.add(fingerprint(engine))
    assert len(prints) == 1


@pytest.mark.parametrize("integrator", ["reflected", "euler"])
def test_the_push_of_each_wall_of_a_wedge_is_booked(integrator):
    # Without rotation the density at rest is exp(-y/D), and each wall pushes at D times the density on it: 1.9503 by
    # quadrature over the wedge above y = sqrt(6^2 - 5.8^2). Steps of 0.02 are much longer than D: the forces balance
    # nevertheless, on walls that turn by a step over their radius, 0.3 %; 2 % leave room for that and 4 errors.
    D, half, contact = 0.002, 5.8, 6.0
    y0 = np.sqrt(contact**2 - half**2)
    y = y0 + np.concatenate([[0.0], np.geomspace(1e-9, 0.2, 100_000)])
    width, weight = half - np.sqrt(contact**2 - y**2), np.exp(-(y - y0) / D)
    exact = D * np.trapezoid(weight * contact / np.sqrt(contact**2 - y**2), y) / np.trapezoid(2.0 * width * weight, y)
    assert exact == pytest.approx(1.9503, abs=1e-4)
    field = field_of([[-half, 0, 0], [half, 0, 0]], 5.0, dimensions=2)
    engine = make_engine(
        field, [[0, 1.6, 0]] * 64, [[0, -1.0, 0]] * 64, alpha=0.0, D=D, D_r=0.0, time_step=0.02,
        integrator=integrator, hydrodynamics=NoHydrodynamics,
    )  # fmt: skip
    engine.advance(250)
    before = engine.encounters()["wall_push"]
    engine.advance(1000)
    rows = engine.encounters()
    assert len(rows["wall_push"]) == 64  # one encounter each
    assert ((rows["wall_push"] - before) / 20.0).mean() == pytest.approx(exact, rel=0.02)
    assert set(rows["colloid"]) == {0, 1}


def test_a_swimmer_at_rest_in_a_wedge_is_pushed_by_both_walls_where_events_are_located():
    # without noise each of two walls at an angle b to the way holds off 1/(2 sin b): forces along y balance
    field = field_of([[-5.8, 0, 0], [5.8, 0, 0]], 5.0, dimensions=2)
    engine = make_engine(
        field, [[0.001, 1.6, 0]], [[0, -1.0, 0]], alpha=0.0, D=0.0, time_step=0.02, precision="f64",
        integrator="located", hydrodynamics=NoHydrodynamics,
    )  # fmt: skip
    engine.advance(50)
    before = engine.encounters()["wall_push"][0]
    engine.advance(500)
    sine = np.sqrt(36.0 - 5.8**2) / 6.0
    assert engine.encounters()["wall_push"][0] - before == pytest.approx(10.0 / (2.0 * sine), rel=0.02)


def caged(tmp_path) -> ps.Scene:
    """Rods in the pore between three discs that touch: there is room for them along the pore's axes only."""
    table = tmp_path / "three.csv"
    corners = 7.5 / np.sqrt(3.0) * np.exp(1j * (np.pi / 2 + 2 * np.pi / 3 * np.arange(3)))
    table.write_text("x,y,radius\n" + "".join(f"{float(z.real)!r},{float(z.imag)!r},3.749\n" for z in corners))
    return ps.Scene.from_mapping({
        "swimmers": {"count": 50, "dipole_strength": 0.0, "aspect_ratio": 0.2,
                     "release": {"kind": "point", "position": [0, -0.424], "director": [0, 1]}},
        "hydrodynamics": {"kind": "none"},
        "noise": {"kind": "brownian", "translational_diffusion": 0.002, "rotational_diffusion": 0.1},
        "obstacles": {"layout": "file", "path": str(table)}, "domain": {"dimensions": 2, "boundary": "open"},
        "run": {"time_step": 0.005, "duration": 10, "seed": 1}, "record": {"every": 0.5, "swimmers": 50, "trails": 0},
    })  # fmt: skip


def test_rods_in_a_cage_turn_freely_and_are_counted(tmp_path):
    results = ps.run(caged(tmp_path))
    table = results.trajectory
    order = np.lexsort((table["time"].to_numpy(), table["swimmer"].to_numpy()))
    x, y, ex, ey = (table[name].to_numpy()[order].reshape(50, -1) for name in ("x", "y", "ex", "ey"))
    assert np.hypot(x, y).max() < 2.4  # in the pore: discs touch 2.31 from its middle
    turns = np.diff(np.unwrap(np.arctan2(ey, ex), axis=1), axis=1) ** 2 / (2.0 * 0.1 * 0.5)
    assert turns.mean() == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / turns.size))  # of a square of a normal variate
    assert results.summary["jammed_steps"] > 0
    assert any("left no room" in sentence for sentence in results.summary["warnings"])


def test_narrow_gaps_are_counted_once_each():
    # in the periodic box the second and the third are neighbours over the edge, too
    field = field_of([[0, 0, 0], [10.5, 0, 0], [20.2, 0, 0]], [5.0, 5.0, 4.0], (30.0, 40.0, 0.0), 2)
    assert field.narrow_gaps(2.0) == pytest.approx([0.5, 0.7, 0.8])
    assert field.narrow_gaps(0.6) == pytest.approx([0.5])
    rng = np.random.default_rng(3)
    radii, centers = rng.uniform(0.3, 6.0, 60), rng.uniform(0, 60, (60, 3))
    box = np.full(3, 60.0)
    delta = centers[:, None] - centers
    distance = np.linalg.norm(delta - np.rint(delta / box) * box, axis=2) - radii - radii[:, None]
    brute = np.sort(np.maximum(distance[np.triu_indices(60, 1)], 0.0))
    assert field_of(centers, radii, box).narrow_gaps(1.5) == pytest.approx(brute[brute < 1.5])


def test_a_scene_says_how_many_gaps_its_swimmers_cannot_pass(tmp_path):
    scene = caged(tmp_path)
    (sentence,) = (text for text in scene.warnings() if "too narrow" in text)
    assert sentence.startswith("3 gaps between colloids are too narrow for swimmers to pass (the narrowest is 0.002)")

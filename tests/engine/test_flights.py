"""Steps that grow far from every colloid: the same walk, the same colloids, the same bits however it is run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.core.errors import DeviceError
from porous_swim.engine.engine import LONGEST_LAUNCH
from porous_swim.engine.parameters import flight_height
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import fcc, field_of, fingerprint, make_engine, released

TICKS, STEP = 25, 0.02
DILUTE = """
name: dilute
swimmers: {count: 4096, dipole_strength: 0.8}
noise: {kind: brownian, translational_diffusion: 0.002}
obstacles: {layout: fcc, radius: 5.0, spacing: 24.0, cells: [2, 2, 2]}
domain: {dimensions: 3}
run: {time_step: 0.02, duration: 120, seed: 1, device: cpu}
record: {every: 2.0, swimmers: 0, trails: 0}
"""


def flying(n=300, *, field=None, **options):
    """An engine for a dilute lattice with flights of 0.5."""
    field = fcc(spacing=30.0) if field is None else field
    given = {"time_step": STEP, "integrator": "reflected", "flight_ticks": TICKS} | options
    return make_engine(field, *released(field, n), **given)


def scene_of(folder: Path, **changes: object) -> ps.Scene:
    (folder / "dilute.yaml").write_text(DILUTE)
    return ps.load_scene(folder / "dilute.yaml").replace(changes)


@pytest.mark.parametrize(
    ("options", "launches"),
    [
        ({"lanes": 1}, [1500]),
        ({"lanes": 8, "chunk": 16}, [25, 50, 1425]),
        ({"log_rows": 8}, [500, 500, 500]),
        ({"threads": 2}, [750, 750]),
    ],
)
def test_flights_do_not_depend_on_lanes_launches_threads_or_the_log(options, launches):
    whole = flying()
    whole.advance(sum(launches))
    expected = fingerprint(whole)
    other = flying(**options)  # another number of threads starts the device anew
    for n_steps in launches:
        other.advance(n_steps)
    assert fingerprint(other) == expected


def test_swimmers_fly_far_from_colloids_alone():
    near = field_of([[0.0, 0.0, 0.0]], 5.0)
    start = [[0.0, 6.0, 0.0], [0.0, 40.0, 0.0]]  # in contact; far away
    heading = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]
    engines = [
        make_engine(near, start, heading, time_step=STEP, integrator="reflected", flight_ticks=ticks)
        for ticks in (1, TICKS)
    ]
    for engine in engines:
        engine.advance(TICKS)
    plain, flown = (engine.snapshot().position for engine in engines)
    assert np.array_equal(plain[0], flown[0])
    assert not np.array_equal(plain[1], flown[1])
    # one kick of a flight in place of 25: the ways differ by some deviations of sqrt(2 D t) = 0.045, no more
    assert 1e-4 < np.abs(plain[1] - flown[1]).max() < 0.45


def test_no_swimmer_gets_into_a_colloid_and_contacts_begin_at_the_wall():
    engine = flying(500, alpha=4.0, D=0.05)
    for _ in range(40):
        engine.advance(5 * TICKS)
        assert engine.snapshot().height.min() > 1.0 - 1e-5
    rows = engine.encounters()
    entry = np.stack([rows[f"entry_{axis}"] for axis in "xyz"], axis=1)
    _, _, height = engine._field.nearest(entry)
    assert len(height) > 300
    np.testing.assert_allclose(height, 1.0, atol=1e-4)  # a touch is booked on the wall; single precision at 5 a


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_walk_of_flights_has_the_moments_of_a_persistent_walk(dimensions):
    n, D, D_r, t = 40000, 0.05, 0.03, 20.0
    field = field_of(np.zeros((0, 3)), 1.0, dimensions=dimensions)
    director = np.tile([1.0, 0.0, 0.0], (n, 1))
    engine = make_engine(
        field, np.tile([1e3, 0.0, 0.0], (n, 1)), director, alpha=0.0, D=D, D_r=D_r, time_step=STEP,
        integrator="reflected", flight_ticks=TICKS, hydrodynamics=NoHydrodynamics,
    )  # fmt: skip
    engine.advance(round(t / STEP))
    now = engine.snapshot()
    squared, overlap = np.sum((now.position - [1e3, 0.0, 0.0]) ** 2, axis=1), now.director[:, 0]
    decay = (dimensions - 1) * D_r
    expected = 2.0 * dimensions * D * t + 2.0 / decay**2 * (decay * t - 1.0 + np.exp(-decay * t))
    # 4 standard errors, and flights of 0.5 are of second order: (0.5 decay)^2 = 9e-4 at most
    assert abs(squared.mean() - expected) < 4.0 * squared.std() / np.sqrt(n) + 9e-4 * expected
    assert abs(overlap.mean() - np.exp(-decay * t)) < 4.0 * overlap.std() / np.sqrt(n) + 9e-4


def test_flights_change_no_statistic_of_a_dilute_lattice(tmp_path):
    plain = ps.run(scene_of(tmp_path)).summary
    flown = ps.run(scene_of(tmp_path, **{"run.flight_step": 0.5, "run.seed": 2})).summary
    pairs = [
        (found["residence"]["mean"], found["hops"]["rate"], found["hops"]["time"], found["fractions"]["bound"],
         found["msd"]["final"], found["winding"]["completed"])
        for found in (plain, flown)
    ]  # fmt: skip
    for one, other in zip(*pairs, strict=True):
        error = np.hypot(one["standard_error"], other["standard_error"])
        assert abs(one["value"] - other["value"]) < 4.0 * error, one


def test_flights_that_cannot_be_are_refused_in_one_sentence(tmp_path):
    for changes, sentence in (
        ({"run.flight_step": 0.49}, r"run.flight_step: 0.49 is not a whole number of steps of 0.02"),
        ({"run.flight_step": 0.7}, r"run.flight_step: expected a whole part of run.duration \(120\), found 0.7"),
        ({"run.flight_step": 0.5, "record.every": 0.8}, r"a whole part of record.every \(0.8\), found 0.5"),
        ({"run.flight_step": 20.0, "record.every": 20.0}, r"run.flight_step: expected at most 11.3"),
        ({"run.flight_step": 0.5, "run.integrator": "euler"}, r"for the integrator reflected.*found euler"),
    ):
        with pytest.raises(ps.SceneError, match=sentence):
            scene_of(tmp_path, **changes)
    assert scene_of(tmp_path, **{"run.flight_step": 0.5}).record_period % TICKS == 0
    with pytest.raises(ValueError, match="expected a multiple of the 25 steps of a flight, found 7"):
        flying(3).advance(7)


def test_a_device_that_takes_no_flights_says_so(monkeypatch):
    monkeypatch.setitem(LONGEST_LAUNCH, "cpu", 4)
    with pytest.raises(DeviceError, match=r"run.flight_step: on cpu a flight has at most 4 steps, found 25"):
        flying(3)


@pytest.mark.parametrize("hydrodynamics", ["image_dipole", "near_wall"])
@pytest.mark.parametrize(("alpha", "T"), [(0.8, 0.5), (4.0, 0.5), (4.0, 2.0), (-10.0, 2.0)])
def test_from_the_height_of_flights_on_the_flow_hardly_changes_and_contact_is_far(alpha, T, hydrodynamics):
    height = flight_height(alpha, 0.01, T)
    kicks = 5.4 * np.sqrt(3.0 * 2.0 * 0.01 * T)
    pitch = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 41)
    director = np.stack([np.cos(pitch), np.sin(pitch), 0.0 * pitch], axis=1)
    for radius in (3.0, 1e4, np.inf):
        base = 0.0 if np.isinf(radius) else radius

        def flow(h, radius=radius, base=base):
            place = np.tile([0.0, base + h, 0.0], (len(pitch), 1))
            given = {"radius": radius, "dipole_strength": alpha, "hydrodynamics": hydrodynamics}
            return ps.drift(place, director, **given)[0] - director

        fastest = np.linalg.norm(flow(2.0), axis=1).max()
        assert height - T * (1.0 + fastest) - kicks > 1.0  # whatever its way, it touches nothing
        lowest = height - kicks - T * (1.0 + np.linalg.norm(flow(height - kicks), axis=1).max())
        change = np.linalg.norm(flow(lowest) - flow(lowest + T), axis=1)
        assert change.max() < 0.033  # 0.03, and what the flow adds to the way


def test_swimmers_that_await_their_escape_pitch_do_not_fly():
    engines = [
        flying(400, field=fcc(spacing=30.0, cells=1), alpha=0.8, D=0.02, escape_sine=0.9, flight_ticks=ticks)
        for ticks in (1, TICKS)
    ]
    late = []
    for engine in engines:
        engine.advance(200 * TICKS)
        rows = engine.encounters()
        passed = rows["escape_pitch_time"]
        late.append((passed - rows["end_time"])[(passed > rows["end_time"]) & ~rows["end_censored"]])
    assert min(len(times) for times in late) > 100
    for times in late:  # middles of single steps, not of flights
        assert np.all(np.abs(times / STEP - np.round(times / STEP)) < 1e-3)
    error = np.hypot(*(times.std() / np.sqrt(len(times)) for times in late))
    assert abs(late[0].mean() - late[1].mean()) < 4.0 * error


def test_a_flight_too_long_for_the_device_costs_no_old_run(tmp_path):
    small = {"swimmers.count": 20, "run.duration": 4.0, "record.every": 2.0}
    out = tmp_path / "run"
    ps.run(scene_of(tmp_path, **small), out=out)
    before = {path.name for path in out.iterdir()}
    with pytest.raises(ps.SceneError, match=r"run.flight_step: expected at most 0.104858, 1,048,576 steps of 1e-07"):
        ps.run(
            scene_of(tmp_path, **small).replace({"run.time_step": 1e-7, "run.flight_step": 0.5}), out=out,
            overwrite=True,
        )  # fmt: skip
    assert {path.name for path in out.iterdir()} == before

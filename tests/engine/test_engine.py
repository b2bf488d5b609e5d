"""What must not change a result: launches, chunks, lanes, threads, the log's size, the place in space."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from porous_swim.core.errors import DeviceError, RunError
from porous_swim.engine import backend
from porous_swim.engine.encounter_log import Records
from porous_swim.engine.kernel.state import Event, Int
from porous_swim.engine.kernel.swimmers import HALF_RANGE
from porous_swim.engine.medium import on_device
from porous_swim.obstacles.cells import MOST_IMAGES
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from tests.support.engines import fcc, field_of, fingerprint, hexagonal, make_engine, released

FIELDS = {"hexagonal": (hexagonal(), dict(alpha=4.0, D=0.006)), "fcc": (fcc(), dict(alpha=0.8, D=0.002))}
N_STEPS = 1500


def crystal(name: str, n: int = 203, **options):
    """An engine in a crystal with the first `n` of 203 swimmers, who fill no block of lanes."""
    field, law = FIELDS[name]
    position, director = released(field, 203)
    return make_engine(field, position[:n], director[:n], escape_sine=0.3, **law, **options)


def advanced(engine, pieces=(N_STEPS,)) -> str:
    for piece in pieces:
        engine.advance(piece)
    return fingerprint(engine)


@pytest.fixture(scope="module")
def reference() -> dict[str, str]:
    return {name: advanced(crystal(name, threads=1)) for name in FIELDS}


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize(
    "pieces", [(7, 13, 980, 500), (1,) * 40 + (N_STEPS - 40,)], ids=["four launches", "forty launches of one step"]
)
def test_launches_do_not_change_a_bit(reference, name, pieces):
    assert advanced(crystal(name), pieces) == reference[name]


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize(
    "options",
    [dict(chunk=1), dict(chunk=16), dict(lanes=16), dict(lanes=1), dict(threads=2), dict(log_rows=8)],
    ids=["chunks of 1", "chunks of 16", "16 lanes", "1 lane", "two threads", "a log of 8 rows"],
)
def test_the_machinery_does_not_change_a_bit(reference, name, options):
    assert advanced(crystal(name, **options)) == reference[name]


def test_between_reflecting_walls_nothing_of_this_changes_a_bit():
    cuts = (7, 13, 980, 500)
    runs = [((N_STEPS,), {}), (cuts, {}), (cuts, dict(chunk=1)), (cuts, dict(lanes=1)), (cuts, dict(log_rows=8))]
    assert len({advanced(crystal("hexagonal", integrator="reflected", **how), pieces) for pieces, how in runs}) == 1


def test_a_restart_frees_the_arrays_of_engines_that_are_gone():
    # Taichi frees an array by its address: later, that may be the address of another array, on the new device
    gc.disable()
    try:
        backend.ensure("cpu", threads=1)
        ring: list = [on_device(np.zeros((2, 2)))]
        ring.append(ring)  # only the collector can free it, as it does an engine
        array = weakref.ref(ring[0])
        del ring
        backend.ensure("cpu", threads=2)
        assert array() is None
    finally:
        gc.enable()


def test_a_log_of_8_rows_is_filled_many_times_and_loses_nothing():
    engine = crystal("fcc", log_rows=8)
    engine.advance(4 * N_STEPS)
    _, escapes, _, _ = engine.counts()
    rows = engine.encounters()
    assert escapes > 10 * 8
    assert np.count_nonzero(~rows["end_censored"]) == escapes


@pytest.mark.parametrize(("name", "integrator"), [("hexagonal", "euler"), ("fcc", "euler"), ("hexagonal", "reflected")])
def test_counts_are_those_of_the_encounter_table(name, integrator):
    engine = crystal(name, integrator=integrator)
    engine.advance(4 * N_STEPS)
    captures, escapes, hops, returns = engine.counts()
    rows = engine.encounters()
    order = np.lexsort((rows["start_time"], rows["swimmer"]))
    host = np.stack([rows[key][order] for key in ("swimmer", "colloid", "image_x", "image_y", "image_z")], axis=1)
    later = host[1:, 0] == host[:-1, 0]
    same = np.all(host[1:] == host[:-1], axis=1)
    assert captures == len(host) > 200
    assert escapes == np.count_nonzero(~rows["end_censored"])
    assert (hops, returns) == (np.count_nonzero(later & ~same), np.count_nonzero(later & same))


@pytest.mark.parametrize("name", FIELDS)
def test_a_swimmer_does_not_feel_who_else_is_there(name):
    many, few = crystal(name), crystal(name, n=3)
    many.advance(N_STEPS)
    few.advance(N_STEPS)
    assert np.array_equal(many.snapshot().position[:3], few.snapshot().position)


def test_another_seed_is_another_run(reference):
    assert advanced(crystal("hexagonal", seed=2)) != reference["hexagonal"]


def test_parameter_sets_are_rows_of_one_launch():
    field = hexagonal()
    position, director = released(field, 40)
    laws = dict(D=0.002, time_step=0.005)
    both = make_engine(field, position, director, alpha=[0.8, 4.0], set_of=np.arange(40) % 2, **laws)
    both.advance(400)
    for row, alpha in enumerate((0.8, 4.0)):
        alone = make_engine(field, position, director, alpha=alpha, **laws)
        alone.advance(400)
        assert np.array_equal(both.snapshot().position[row::2], alone.snapshot().position[row::2])


ORBIT = dict(alpha=0.8, D=0.0, precision="f64", time_step=0.005)
START, AHEAD = np.array([[-40.0, 0.1, 0.0]]), np.array([[1.0, 0.0, 0.0]])


def orbit_around(field, center) -> np.ndarray:
    """The path of a swimmer that is captured by one colloid, from its centre, (n, 3)."""
    engine = make_engine(field, START + center, AHEAD, **ORBIT)
    path = []
    for _ in range(40):
        engine.advance(1000)
        path.append(engine.snapshot().position[0] - center)
    return np.array(path)


def test_an_orbit_across_the_faces_of_the_box_is_that_in_open_space():
    lone = orbit_around(field_of([0, 0, 0], 20.0), np.zeros(3))
    # a box in which no image is ever nearer: the arithmetic on offsets is the same, and so are the bits, up to the
    # last additions that make absolute positions of them (box 200: 3e-14)
    boxed = orbit_around(field_of([0, 0, 0], 20.0, (200.0,) * 3), np.zeros(3))
    assert np.ptp(np.arctan2(lone[:, 1], lone[:, 0])) > 5.0  # it goes around, through all faces at the corner
    assert np.abs(boxed - lone).max() < 1e-13


def test_an_orbit_far_from_the_origin_is_that_at_the_origin():
    lone = orbit_around(field_of([0, 0, 0], 20.0), np.zeros(3))
    far = np.full(3, 1e6)
    # 1e6 rounds the start by 6e-11 and each printed position by 1e-10; the orbit is stable: errors do not grow
    assert np.abs(orbit_around(field_of([far], 20.0), far) - lone).max() < 1e-8


def test_positions_do_not_lose_digits_in_a_large_box_in_single_precision():
    cells = hexagonal(cells=(2, 1))
    large = hexagonal(cells=(1000, 2))
    position, director = released(cells, 64)
    law = dict(alpha=4.0, D=0.006)
    shift = np.array([9980.0, 0.0, 0.0])  # 998 lattice constants: exact in the numbers that hold positions
    small_run = make_engine(cells, position, director, **law)
    large_run = make_engine(large, position + shift, director, **law)
    small_run.advance(400)
    large_run.advance(400)
    # offsets round to the same f32 unless they stand on a tie; centres of the large box to 2e4 * 2^-53
    difference = np.abs(large_run.snapshot().position - shift - small_run.snapshot().position).max()
    assert difference < 1e-4  # 400 steps amplify a last bit (5e-7) by less than 200; f32 at 1e4 would be 1e-3 a step


def test_a_free_swimmer_loses_no_step_far_away_in_single_precision():
    field = field_of(np.zeros((0, 3)), 0.0)
    engine = make_engine(
        field, [[1e5, 0.0, 0.0]], [[0.6, 0.8, 0.0]], alpha=0.0, D=0.0, hydrodynamics=NoHydrodynamics, time_step=0.001
    )
    engine.advance(100_000)
    # steps of 6e-4 against a spacing of 8e-3 between numbers: without compensation it would not move at all
    assert engine.snapshot().position[0] == pytest.approx([1e5 + 60.0, 80.0, 0.0], abs=1e-3)


def test_a_swimmer_that_cannot_go_on_is_named_with_time_and_place():
    engine = make_engine(field_of([0, 0, 0], 5.0), [[8.0, 0, 0], [7.0, 0, 0]], [[0, 1.0, 0]] * 2, D=0.0)
    state = engine._swimmers.real.to_numpy()
    state[0, 1] = np.inf
    engine._swimmers.real.from_numpy(state)
    with pytest.raises(
        RunError, match=r"swimmer 1 stopped at step 0 \(time 0\) near \(inf, 0, 0\): .*not a finite number"
    ):
        engine.advance(10)


def test_an_image_beyond_the_counter_stops_the_run():
    field = hexagonal()
    engine = make_engine(field, *released(field, 5), alpha=4.0, D=0.006)
    ints = engine._swimmers.int.to_numpy()
    ints[Int.IMAGE, 2] = 2**30 + 1
    engine._swimmers.int.from_numpy(ints)
    with pytest.raises(RunError, match=r"swimmer 2 .* range of periodic images"):
        engine.advance(2000)
    assert np.count_nonzero(engine._swimmers.int.to_numpy()[Int.EVENT] & int(Event.HALT)) == 1


def test_steps_count_beyond_32_bits():
    field = hexagonal()
    runs = []
    for first in (0, 2**32 - 100):
        engine = make_engine(field, *released(field, 50), alpha=4.0, D=0.006, escape_sine=0.3)
        engine.step = first
        engine.advance(200)
        runs.append(engine)
    times = runs[1].encounters()["end_time"] / 0.005
    assert times.max() == 2**32 + 100  # those under way
    # the noise goes on: the counter's low word wraps into its high word, so the steps differ from the first 200
    assert not np.array_equal(runs[0].snapshot().position, runs[1].snapshot().position)


def test_a_late_escape_pitch_reaches_its_row():
    field, law = FIELDS["fcc"]
    engine = make_engine(field, *released(field, 203), escape_sine=0.6, **law)
    engine.advance(6 * N_STEPS)
    rows = engine.encounters()
    passed, ended = rows["escape_pitch_time"], ~rows["end_censored"]
    late = ended & (passed > rows["end_time"])
    assert np.count_nonzero(late) > 0
    assert np.all(passed[~np.isnan(passed)] >= rows["start_time"][~np.isnan(passed)])
    order = np.lexsort((rows["start_time"], rows["swimmer"]))
    who, start, when = (rows[key][order] for key in ("swimmer", "start_time", "escape_pitch_time"))
    followed = np.r_[who[1:] == who[:-1], False]
    next_start = np.where(followed, np.r_[start[1:], 0.0], np.inf)
    assert np.all(np.isnan(when) | (when <= next_start))


def test_rows_of_the_log_may_come_in_any_order():
    field = hexagonal()
    rng = np.random.default_rng(3)
    engine = make_engine(field, *released(field, 100), alpha=4.0, D=0.006, time_step=0.005)
    engine.advance(4000)
    engine._drain()
    raw = np.concatenate(engine._records._store._waiting)
    raw, nobody = [raw[name] for name in ("real", "int", "long")], [raw[name][:0] for name in ("real", "int", "long")]
    assert len(raw[0]) > 20
    tables = []
    for order in (np.arange(len(raw[0])), rng.permutation(len(raw[0]))):
        records = Records(field, 0.005, 100)
        for part in np.array_split(order, 3):
            records.add(*(array[part] for array in raw))
        (table,) = records.parts(*nobody)
        tables.append(table)
    assert all(np.array_equal(tables[0][key], tables[1][key], equal_nan=True) for key in tables[0])


def test_a_device_that_makes_no_progress_is_named_and_not_waited_for():
    engine = crystal("hexagonal", n=3)
    engine._advance = lambda *arguments: None  # as a software driver does that stops long loops
    with pytest.raises(DeviceError, match="cpu makes no progress"):
        engine.advance(1)


@pytest.mark.parametrize("integrator", ["euler", "reflected"])
def test_a_lane_that_takes_one_swimmer_after_the_other_gives_the_bits_of_one_lane(integrator):
    field, law = FIELDS["fcc"]
    prints = set()
    for options in ({}, {"lanes": 1}, {"log_rows": 16}):
        engine = make_engine(
            field, *released(field, 1037), **law, threads=1, integrator=integrator, escape_sine=0.3, **options
        )  # fmt: skip
        assert engine._share > engine.lanes  # there is a next one
        engine.advance(N_STEPS)
        prints.add(fingerprint(engine))
    assert len(prints) == 1


def test_colloids_touched_in_an_encounter_are_within_the_range_of_packed_images():
    assert 4 * MOST_IMAGES < HALF_RANGE

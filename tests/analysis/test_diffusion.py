"""Effective diffusivities, travel times and densities of walks whose statistics are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest
from scipy import stats

from porous_swim.analysis.density import cell_density, height_pitch_density
from porous_swim.analysis.transport.diffusion import EffectiveDiffusivity, effective_diffusivity
from porous_swim.analysis.transport.travel import travel_times
from porous_swim.core.errors import ResultsError
from porous_swim.results.tables import TableInfo
from tests.support import synthetic, walks


def covered(n: int, *, repeats: int) -> bool:
    """Whether n of so many intervals of 95 % is within four binomial standard errors."""
    return abs(n / repeats - 0.95) <= 4.0 * math.sqrt(0.95 * 0.05 / repeats)


@pytest.mark.parametrize("n_swimmers", [25, 100])
def test_intervals_of_the_diffusivity_cover_that_of_a_brownian_walk(n_swimmers: int) -> None:
    rng = np.random.default_rng(1)
    inside, inside_fixed, accepted = 0, 0, 0
    for _ in range(500):
        table = walks.brownian(rng, n_swimmers=n_swimmers, n_frames=41, dimensions=2, diffusivity=0.4)
        found = effective_diffusivity(table)
        inside += found.interval[0] <= 0.4 <= found.interval[1]
        accepted += found.window[0] == 2.0
        fixed = effective_diffusivity(table, window=(2.0, 20.0))
        inside_fixed += fixed.interval[0] <= 0.4 <= fixed.interval[1]
    assert covered(inside, repeats=500)
    assert covered(inside_fixed, repeats=500)
    # The first window is right, as is that from twice as late; each is refused with a probability of 0.01.
    assert accepted / 500 >= 0.98 - 4.0 * math.sqrt(0.98 * 0.02 / 500)


def test_a_brownian_walk_is_known_as_well_as_its_steps_tell() -> None:
    table = walks.brownian(np.random.default_rng(2), n_swimmers=400, n_frames=201, dimensions=3, diffusivity=0.4)
    found = effective_diffusivity(table, window=(1.0, 100.0))
    assert found.linear
    assert abs(found.value - 0.4) < 4.0 * found.standard_error
    # The best estimate, from the steps alone, has the relative error sqrt(2/(3 x 400 x 200)); with a free offset
    # half of what the steps tell goes into it.
    best = 0.4 * math.sqrt(2.0 / (3 * 400 * 200))
    assert best < found.standard_error < 2.0 * best
    assert abs(found.offset) < 0.1


def test_the_window_of_a_persistent_walk_starts_where_it_has_turned_and_the_interval_holds() -> None:
    rng = np.random.default_rng(3)
    c = math.exp(-0.18)
    exact = 0.2 + 0.25 * (1.0 + c) / (1.0 - c)
    inside, linear, starts = 0, 0, []
    for _ in range(100):
        found = effective_diffusivity(walks.persistent(rng, n_swimmers=200, n_frames=301, turning=0.6, diffusivity=0.2))
        linear += found.linear
        inside += found.interval[0] <= exact <= found.interval[1]
        starts.append(found.window[0])
    assert linear >= 94  # each right window is refused once in a hundred: 4 binomial errors
    assert np.median(starts) >= 5.0 / 0.18  # persistence times: what is left of the start is less than one per cent
    assert covered(inside, repeats=100)


def test_a_ballistic_run_is_not_linear_and_swimmers_that_are_alike_have_no_diffusivity() -> None:
    rng = np.random.default_rng(4)
    found = effective_diffusivity(walks.persistent(rng, n_swimmers=200, n_frames=21, turning=0.1))
    assert not found.linear
    assert math.isnan(found.value)
    assert found.reason == (
        "There is no effective diffusivity: swimmers keep their directors for longer than 10 a/U, about half of the "
        "run."
    )
    alike = effective_diffusivity(walks.persistent(rng, n_swimmers=200, n_frames=21, turning=0.0))
    assert alike.estimate().as_dict()["value"] is None
    still = walks.brownian(rng, n_swimmers=40, n_frames=21, dimensions=2, diffusivity=0.0)
    assert effective_diffusivity(still).estimate().as_dict()["value"] is None
    few = effective_diffusivity(walks.brownian(rng, n_swimmers=19, n_frames=41, dimensions=2, diffusivity=0.4))
    assert math.isnan(few.value)
    assert not few.linear
    assert "needs 20 swimmers whose trajectories differ, of 19 here" in few.reason


def test_a_window_that_was_given_and_is_not_straight_has_the_slope_from_end_to_end_and_a_reason() -> None:
    table = walks.persistent(np.random.default_rng(9), n_swimmers=400, n_frames=41, turning=0.2, diffusivity=0.1)
    found = effective_diffusivity(table, window=(5.0, 20.0))
    low, high = walks.persistent_msd(np.array([5.0, 20.0]), turning=0.2, diffusivity=0.1)
    assert not found.linear
    assert abs(found.value - (high - low) / 15.0 / 4.0) < 4.0 * found.standard_error
    assert found.standard_error < 0.05 * found.value
    assert (found.window, found.n_lags) == ((5.0, 20.0), 8)
    assert found.reason.startswith("No straight line fits the mean squared displacement from 5 to 20 a/U")
    assert found.reason.endswith("the value is the mean slope from end to end, and no diffusivity.")


def test_a_run_among_colloids_has_no_diffusivity_before_swimmers_have_passed_them() -> None:
    table = walks.brownian(np.random.default_rng(10), n_swimmers=400, n_frames=201, dimensions=2, diffusivity=0.5)

    def among(spacing: float | None) -> EffectiveDiffusivity:
        return effective_diffusivity(replace(TableInfo.of(table), spacing=spacing).attach(table))

    # With x = (2 pi/spacing)^2 D lag, at spacing 10 of 0.197 lag, exp(-x) is 0.25 sqrt(lag/(400 x 200)) at x = 5.4;
    # the next lag is up to a fifth later, and the distances walked are known to a few per cent.
    assert among(None).window[0] == 2.0
    assert 5.0 < 0.197 * among(10.0).window[0] < 6.5
    none = among(40.0)
    assert math.isnan(none.value)
    assert "within 50 a/U, a quarter of the run, swimmers go too short a way" in none.reason
    assert none.reason.endswith("among colloids 40 a apart.")


def test_straight_swimmers_travel_at_their_speed_and_slow_ones_are_cut_off() -> None:
    time = np.arange(0.0, 5.0, 0.5)
    position = np.zeros((10, 4, 3))
    position[..., 1] = 7.0 + np.outer(time, [1.0, 2.0, 0.5, -3.0])
    table = synthetic.trajectory(synthetic.info(last_time=4.5), time, position, np.ones((10, 4, 3)))
    found = travel_times(table, distance=3.3, direction=(0.0, 2.0, 0.0))
    assert found.length == pytest.approx([3.3, 1.65, 4.5, 4.5], rel=1e-12)
    assert found.ended.tolist() == [True, True, False, False]
    assert set(found.limit) == {4.5}
    assert found.summary().n_censored == 2
    assert found.survival().probability.tolist() == [0.75, 0.5]
    back = travel_times(table, distance=3.3, direction=(0.0, -1.0, 0.0))
    assert back.length[back.ended] == pytest.approx([1.1], rel=1e-12)


def test_breakthrough_of_a_drifting_brownian_walk_is_the_inverse_gaussian() -> None:
    rng = np.random.default_rng(5)
    table = walks.brownian(rng, n_swimmers=4000, n_frames=200, dimensions=2, diffusivity=0.5, drift=0.5)
    found = travel_times(table, distance=40.0, direction=(1.0, 0.0, 0.0))
    # Seen in frames the walk passes 0.5826 sqrt(2 D) beyond the distance (Broadie, Glasserman and Kou 1997), and
    # the straight way between two frames takes part of that back: between the two shifts all must lie.
    curve = found.survival()
    for at in (60.0, 80.0, 120.0):
        probability = curve.probability[np.searchsorted(curve.time, at, side="right") - 1]
        low, high = (first_passage(distance, 0.5, 0.5).sf(at) for distance in (40.0, 40.6))
        error = math.sqrt(probability * (1.0 - probability) / 4000)
        assert low - 4.0 * error < probability < high + 4.0 * error
        assert high - low < 0.03


def first_passage(distance: float, drift: float, diffusivity: float) -> stats.rv_continuous:
    mean, shape = distance / drift, distance**2 / (2.0 * diffusivity)
    return stats.invgauss(mean / shape, scale=shape)


def test_a_distance_of_nothing_is_refused() -> None:
    table = walks.brownian(np.random.default_rng(6), n_swimmers=2, n_frames=3, dimensions=2, diffusivity=0.5)
    with pytest.raises(ValueError, match="both must differ from 0"):
        travel_times(table, distance=0.0, direction=(1.0, 0.0, 0.0))


def place(position: np.ndarray, director: np.ndarray, **columns: np.ndarray) -> pa.Table:
    """One frame of swimmers at positions (n, 3), in a box of 8 by 6."""
    n = len(position)
    about = synthetic.info(n_swimmers=n, dimensions=2, box=(8.0, 6.0, 0.0))
    table = synthetic.trajectory(about, np.zeros(1), position[None], director[None])
    for name, values in columns.items():
        index = table.schema.get_field_index(name)
        table = table.set_column(index, table.schema.field(name), pa.array(values, table.schema.field(name).type))
    return table


def test_the_cell_density_of_folded_positions_is_the_one_they_were_drawn_from() -> None:
    rng = np.random.default_rng(7)
    n = 40_000
    x = 2.0 * np.sqrt(rng.uniform(size=n))  # density x/2 on a cell 2 wide
    y = rng.uniform(0.0, 3.0, n)
    position = np.stack([x + 2.0 * rng.integers(-9, 9, n), y + 3.0 * rng.integers(-9, 9, n), np.zeros(n)], axis=1)
    found = cell_density(place(position, np.ones((n, 3))), cell=(2.0, 3.0), n_bins=8)
    assert (found.n, found.n_outside) == (n, 0)
    middle = 0.5 * (found.x_edges[1:] + found.x_edges[:-1])
    exact = np.repeat(middle[:, None] / 2.0 / 3.0, 8, axis=1)
    # One sample for each swimmer: binomial errors, 64 bins.
    assert np.max(np.abs(found.density - exact) / found.standard_error) < 4.5
    share = exact * 2.0 * 3.0 / 64
    assert found.standard_error * 6.0 / 64 == pytest.approx(np.sqrt(share * (1.0 - share) / n), rel=0.3)
    assert cell_density(place(position, np.ones((n, 3)))).x_edges[-1] == 8.0
    with pytest.raises(ValueError, match="found 0 by 3"):
        cell_density(place(position, np.ones((n, 3))), cell=(0.0, 3.0))


def test_heights_and_pitches_about_images_are_those_the_swimmers_were_placed_with() -> None:
    rng = np.random.default_rng(8)
    n, radius = 500, 1.5
    height, pitch, around = rng.uniform(0.5, 1.0, n), rng.uniform(-1.5, 1.5, n), rng.uniform(0.0, 6.3, n)
    centers = np.array([[1.0, 2.0, 0.0], [5.0, 5.0, 0.0]])
    colloid, image = rng.integers(0, 2, n), rng.integers(-3, 4, (n, 2))
    outward = np.stack([np.cos(around), np.sin(around), np.zeros(n)], axis=1)
    along = np.stack([-np.sin(around), np.cos(around), np.zeros(n)], axis=1)
    shift = np.pad(image * np.array([8.0, 6.0]), ((0, 0), (0, 1)))
    position = centers[colloid] + shift + (radius + height)[:, None] * outward
    director = np.sin(pitch)[:, None] * outward + np.cos(pitch)[:, None] * along
    table = place(position, director, colloid=colloid, image_x=image[:, 0], image_y=image[:, 1])
    colloids = synthetic.colloids(synthetic.info(), centers, radius=radius)
    edges = np.linspace(0.5, 0.9, 5)
    found = height_pitch_density(table, colloids, heights=edges, n_pitches=10)
    exact, _, _ = np.histogram2d(pitch, height, (np.linspace(-0.5 * math.pi, 0.5 * math.pi, 11), edges))
    assert found.count.tolist() == exact.tolist()
    assert found.n_outside == n - exact.sum()
    with pytest.raises(ResultsError, match="a field without any"):
        height_pitch_density(place(position, director, colloid=-np.ones(n)), colloids, heights=edges)

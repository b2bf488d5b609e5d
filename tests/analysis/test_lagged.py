"""Averages against lag on random walks whose statistics are known."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest
from scipy import stats

from porous_swim.analysis.transport.displacements import displacement_histogram, msd_exponent, non_gaussian_parameter
from porous_swim.analysis.transport.lagged import straightness, time_averaged_director_correlation, time_averaged_msd
from porous_swim.analysis.transport.persistence import persistence
from porous_swim.analysis.transport.transport import tracks
from porous_swim.core.errors import ResultsError
from tests.support import synthetic, walks


def test_averages_over_starts_are_those_of_two_loops() -> None:
    table = walks.persistent(np.random.default_rng(1), n_swimmers=3, n_frames=12, turning=0.5, diffusivity=0.1)
    recorded = tracks(table)
    squares = time_averaged_msd(table, lags=np.array([1.0, 4.0, 11.0]))
    directors = time_averaged_director_correlation(table, lags=np.array([1.0, 4.0, 11.0]))
    for i, n in enumerate((1, 4, 11)):
        for swimmer in range(3):
            position, director = recorded.position[:, swimmer], recorded.director[:, swimmer]
            pairs = [(start, start + n) for start in range(12 - n)]
            moved = [sum((position[b] - position[a]) ** 2) for a, b in pairs]
            turned = [sum(director[b] * director[a]) for a, b in pairs]
            assert squares.each[i, swimmer] == pytest.approx(np.mean(moved), rel=1e-12)
            assert directors.each[i, swimmer] == pytest.approx(np.mean(turned), rel=1e-12)
    error = np.std(squares.each[1], ddof=1) / math.sqrt(3)
    assert (squares.n, squares.standard_error[1]) == (3, pytest.approx(error, rel=1e-12))


def test_time_averages_are_those_of_the_exact_walk_and_more_precise_than_from_the_start() -> None:
    table = walks.persistent(np.random.default_rng(2), n_swimmers=400, n_frames=300, turning=0.6, diffusivity=0.2)
    found = time_averaged_msd(table)
    assert found.lag[0] == 1.0
    assert found.lag[-1] == 149.0  # half of the run
    exact = walks.persistent_msd(found.lag, turning=0.6, diffusivity=0.2)
    # Some 25 lags, most of them dependent: 4 standard errors each.
    assert np.all(np.abs(found.value - exact) < 4.0 * found.standard_error)
    assert np.all(found.standard_error[found.lag < 10] < 0.01 * exact[found.lag < 10])
    correlation = time_averaged_director_correlation(table)
    assert np.all(np.abs(correlation.value - np.exp(-0.18 * correlation.lag)) < 4.0 * correlation.standard_error)


def test_errors_of_time_averages_are_the_spread_over_repeats() -> None:
    rng = np.random.default_rng(3)
    lags = np.array([1.0, 10.0])
    repeats = [
        time_averaged_msd(walks.persistent(rng, n_swimmers=30, n_frames=60, turning=0.5), lags=lags) for _ in range(200)
    ]
    spread = np.std([found.value for found in repeats], axis=0)
    # The spread of 200 repeats is known to 5 %: 4 of those.
    assert np.mean([found.standard_error for found in repeats], axis=0) == pytest.approx(spread, rel=0.2)


def test_the_exponent_is_two_for_straight_swimmers_and_one_for_diffusing_ones() -> None:
    time = np.arange(9.0)
    position = np.zeros((9, 2, 3))
    position[..., 1] = time[:, None] * np.array([1.0, 3.0])
    straight = synthetic.trajectory(synthetic.info(last_time=8.0), time, position, np.ones((9, 2, 3)))
    found = msd_exponent(time_averaged_msd(straight, lags=np.array([1.0, 2.0, 4.0])))
    assert found.value == pytest.approx([2.0, 2.0], rel=1e-12)
    assert found.standard_error == pytest.approx([0.0, 0.0], abs=1e-12)
    assert found.lag == pytest.approx(np.sqrt([2.0, 8.0]))
    table = walks.brownian(np.random.default_rng(4), n_swimmers=500, n_frames=200, dimensions=3, diffusivity=0.3)
    found = msd_exponent(time_averaged_msd(table, lags=np.array([1.0, 3.0, 10.0, 30.0])))
    assert np.all(np.abs(found.value - 1.0) < 4.0 * found.standard_error)
    assert np.all(found.standard_error < 0.02)


def test_errors_of_the_exponent_and_the_non_gaussian_parameter_are_the_spread_over_repeats() -> None:
    rng = np.random.default_rng(5)
    lags = np.array([2.0, 8.0])
    exponents, parameters = [], []
    for _ in range(200):
        table = walks.persistent(rng, n_swimmers=60, n_frames=40, turning=0.5, diffusivity=0.1)
        exponents.append(msd_exponent(time_averaged_msd(table, lags=lags)))
        parameters.append(non_gaussian_parameter(table, lags=lags))
    for repeats in (exponents, parameters):
        spread = np.std([found.value for found in repeats], axis=0)
        # 5 % from 200 repeats, 4 of those; and 1/60 from the linear error of a ratio.
        assert np.mean([found.standard_error for found in repeats], axis=0) == pytest.approx(spread, rel=0.22)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_non_gaussian_parameter_vanishes_for_gaussians_and_is_known_for_a_mixture(dimensions: int) -> None:
    rng = np.random.default_rng(6)
    lags = np.array([1.0, 5.0])
    args = {"n_swimmers": 2000, "n_frames": 60, "dimensions": dimensions}
    plain = walks.brownian(rng, diffusivity=0.5, **args)  # type: ignore[arg-type]
    found = non_gaussian_parameter(plain, lags=lags)
    assert np.all(np.abs(found.value) < 4.0 * found.standard_error)
    assert np.all(found.standard_error < 0.01)
    # Half of the swimmers diffuse three times as fast: 2 (1 + 9)/(1 + 3)^2 - 1 = 1/4.
    scale = np.where(column_of(plain, "swimmer") % 2 == 0, math.sqrt(3.0), 1.0)
    mixed = plain
    for axis in "xyz":
        place = mixed.schema.get_field_index(axis)
        mixed = mixed.set_column(place, mixed.schema.field(axis), pa.array(scale * column_of(plain, axis)))
    found = non_gaussian_parameter(mixed, lags=lags)
    assert np.all(np.abs(found.value - 0.25) < 4.0 * found.standard_error)
    assert np.all(found.standard_error < 0.02)


def column_of(table: pa.Table, name: str) -> np.ndarray:
    return np.asarray(table.column(name).to_numpy())


def test_displacements_of_a_brownian_walk_are_normal() -> None:
    table = walks.brownian(np.random.default_rng(7), n_swimmers=2000, n_frames=21, dimensions=2, diffusivity=0.5)
    found = displacement_histogram(table, lag=4.0)
    assert found.n == 2000 * 17 * 2
    share = np.diff(stats.norm.cdf(found.edges / 2.0))  # 2 D lag = 4
    filled = found.count > 200
    deviation = (found.density * np.diff(found.edges) - share)[filled] / (found.standard_error * np.diff(found.edges))[
        filled
    ]
    assert np.max(np.abs(deviation)) < 4.5  # some 60 bins: one false alarm in 2000
    assert found.n_outside < 20  # five standard deviations


def test_the_persistence_length_is_that_of_the_exact_walk() -> None:
    table = walks.persistent(np.random.default_rng(8), n_swimmers=800, n_frames=200, turning=0.6, diffusivity=0.2)
    found = persistence(table)
    c = math.exp(-0.18)
    exact = (1.0 - c**found.projection.lag) / (1.0 - c)
    assert np.all(np.abs(found.projection.value - exact) < 4.0 * found.projection.standard_error)
    assert found.reached
    assert abs(found.length.value - 1.0 / (1.0 - c)) < 4.0 * found.length.standard_error
    assert found.length.standard_error < 0.03 / (1.0 - c)
    short = persistence(table.filter(pc.less(table["time"], 6.0)))
    assert not short.reached
    assert found.reason is None
    assert short.reason == (
        "Directors are remembered for longer than 2 a/U, half of the run: the persistence length is longer than what "
        "was seen of it."
    )
    assert short.length.value < 0.6 / (1.0 - c)


def test_straightness_is_one_on_straight_ways_and_known_for_a_brownian_walk() -> None:
    straight = walks.persistent(np.random.default_rng(9), n_swimmers=4, n_frames=20, turning=0.0)
    assert straightness(straight).value == pytest.approx(np.ones(len(straightness(straight).lag)), rel=1e-12)
    table = walks.brownian(np.random.default_rng(10), n_swimmers=800, n_frames=60, dimensions=3, diffusivity=0.5)
    found = straightness(table, lags=np.array([1.0, 4.0, 16.0]))
    exact = math.sqrt(8.0 / math.pi) / np.sqrt(found.lag)  # mean length of three normals of variance lag
    assert np.all(np.abs(found.value - exact) < 4.0 * found.standard_error)


def test_frames_at_unequal_intervals_are_refused_but_for_a_last_one_that_comes_early() -> None:
    position, director = np.zeros((4, 2, 3)), np.ones((4, 2, 3))
    about = synthetic.info(last_time=3.0)
    early = synthetic.trajectory(about, np.array([0.0, 1.0, 2.0, 2.5]), position, director)
    assert time_averaged_msd(early).lag.tolist() == [1.0]
    uneven = synthetic.trajectory(about, np.array([0.0, 1.0, 2.5, 3.5]), position, director)
    with pytest.raises(ResultsError, match="lags need equal intervals"):
        time_averaged_msd(uneven)


@pytest.mark.parametrize("lag", [0.0, 1.5, 4.0])
def test_a_lag_that_is_no_number_of_frames_is_refused(lag: float) -> None:
    table = walks.brownian(np.random.default_rng(11), n_swimmers=2, n_frames=4, dimensions=2, diffusivity=0.1)
    with pytest.raises(ResultsError, match=f"found {lag:g} a/U, allowed are multiples of 1 up to 3"):
        time_averaged_msd(table, lags=np.array([1.0, lag]))


def test_an_empty_trajectory_has_no_lags() -> None:
    nothing = synthetic.trajectory(synthetic.info(), np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0, 3)))
    assert len(time_averaged_msd(nothing).value) == 0
    assert persistence(nothing).length.as_dict()["value"] is None

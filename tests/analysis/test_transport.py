"""Displacements and directors against the exact persistent random walk."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from porous_swim.analysis.transport.transport import diffusivity, director_correlation, msd, tracks
from porous_swim.core.errors import ResultsError
from tests.support import synthetic

# A walk in the plane: time steps of DT, director turned after the move.
D, D_R, DT = 0.3, 0.7, 0.05


def planar_walk(
    rng: np.random.Generator, *, n_swimmers: int, n_steps: int, every: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (n,), positions and directors (n, n_swimmers, 3) of free swimmers, kept each `every` steps."""
    angle = rng.uniform(0.0, 2.0 * np.pi, n_swimmers)
    position = rng.uniform(-50.0, 50.0, (n_swimmers, 2))
    positions, directors = [], []
    for step in range(n_steps + 1):
        director = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if step % every == 0:
            positions.append(np.pad(position, ((0, 0), (0, 1))))
            directors.append(np.pad(director, ((0, 0), (0, 1))))
        position = position + DT * director + np.sqrt(2.0 * D * DT) * rng.normal(size=(n_swimmers, 2))
        angle = angle + np.sqrt(2.0 * D_R * DT) * rng.normal(size=n_swimmers)
    return np.arange(0, n_steps + 1, every) * DT, np.stack(positions), np.stack(directors)


def table_of_walk(seed: int, *, n_swimmers: int, n_steps: int, every: int) -> pa.Table:
    rng = np.random.default_rng(seed)
    time, position, director = planar_walk(rng, n_swimmers=n_swimmers, n_steps=n_steps, every=every)
    about = synthetic.info(n_swimmers=n_swimmers, last_time=time[-1], dimensions=2)
    return synthetic.trajectory(about, time, position, director)


def test_msd_and_director_correlation_are_those_of_the_exact_walk() -> None:
    table = table_of_walk(1, n_swimmers=3000, n_steps=200, every=20)
    # Exact for n Euler steps in two dimensions: the director decays by c = exp(-D_r dt) each step.
    n, c = np.arange(0, 201, 20), np.exp(-D_R * DT)
    exact = 4.0 * D * n * DT + DT**2 * (n * (1 + c) / (1 - c) - 2 * c * (1 - c**n) / (1 - c) ** 2)
    found = msd(table)
    assert found.lag == pytest.approx(n * DT, abs=1e-12)
    assert found.value[0] == 0.0
    assert np.all(np.abs(found.value - exact)[1:] < 4.0 * found.standard_error[1:])
    assert np.all(found.standard_error[1:] < 0.03 * exact[1:])
    correlation = director_correlation(table)
    assert correlation.value[0] == pytest.approx(1.0, rel=1e-12)
    assert np.all(np.abs(correlation.value - c**n)[1:] < 4.0 * correlation.standard_error[1:])
    assert np.all(correlation.standard_error < 0.02)


def test_effective_diffusivity_of_the_walk_is_the_exact_one() -> None:
    table = table_of_walk(2, n_swimmers=600, n_steps=1000, every=10)  # 35 persistence times
    found = diffusivity(table, persistence_time=1.0 / D_R)
    c = np.exp(-D_R * DT)
    exact = D + DT * (1 + c) / (1 - c) / 4.0  # late slope of the sum above over 4
    assert abs(found.value - exact) < 4.0 * found.standard_error
    assert found.standard_error < 0.1 * exact
    assert found.window == pytest.approx((25.0, 50.0))
    assert found.reliable


def test_error_of_the_diffusivity_is_the_spread_over_repeats() -> None:
    repeats = [
        diffusivity(table_of_walk(seed, n_swimmers=50, n_steps=100, every=10), persistence_time=1.0 / D_R)
        for seed in range(100)
    ]
    spread = np.std([found.value for found in repeats])
    # The spread of 100 repeats is known to 1/sqrt(200) = 7 %: 4 of those.
    assert np.mean([found.standard_error for found in repeats]) == pytest.approx(spread, rel=0.28)


def test_a_run_of_few_persistence_times_is_flagged() -> None:
    table = table_of_walk(3, n_swimmers=5, n_steps=200, every=20)  # 10 a/U
    assert diffusivity(table, persistence_time=1.0).reliable
    assert diffusivity(table, persistence_time=1.0).reason is None
    assert not diffusivity(table, persistence_time=1.01).reliable
    assert diffusivity(table, persistence_time=1.01).reason == (
        "The run of 10 a/U is shorter than 10 persistence times (1.01 a/U each): the value is the slope from 5 a/U on, "
        "no diffusivity yet."
    )
    assert not diffusivity(table, persistence_time=np.inf).reliable


def test_the_slope_of_a_straight_swimmer_is_that_of_its_parabola() -> None:
    time = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    position = np.zeros((5, 1, 3))
    position[:, 0, 0] = 7.0 + time
    about = synthetic.info(last_time=4.0, dimensions=3)
    found = diffusivity(synthetic.trajectory(about, time, position, np.ones((5, 1, 3))), persistence_time=1.0)
    assert found.value == pytest.approx((16.0 - 4.0) / 2.0 / 6.0, rel=1e-14)  # slope of 4, 9, 16 over 2 d
    assert np.isnan(found.standard_error)


def test_rows_may_come_in_any_order() -> None:
    table = table_of_walk(4, n_swimmers=7, n_steps=40, every=10)
    mixed = table.take(pa.array(np.random.default_rng(0).permutation(len(table))))
    assert np.array_equal(tracks(mixed).position, tracks(table).position)


def test_a_trajectory_with_doubled_rows_is_refused() -> None:
    table = table_of_walk(5, n_swimmers=3, n_steps=20, every=10)
    with pytest.raises(ResultsError, match=r"found swimmer 1 twice at time 0\.5"):
        tracks(pa.concat_tables([table, table.slice(4, 1)]))


def test_an_empty_trajectory_has_no_diffusivity() -> None:
    nothing = synthetic.trajectory(synthetic.info(), np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0, 3)))
    found = diffusivity(nothing, persistence_time=1.0)
    assert found.estimate().as_dict()["value"] is None
    assert len(msd(nothing).value) == 0

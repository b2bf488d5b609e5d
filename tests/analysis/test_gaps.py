"""Tracks of one's own: without directors, with frames missing, with swimmers that come and go."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa
import pytest

import porous_swim as ps
from porous_swim.core.errors import ResultsError
from tests.support import synthetic

an = ps.analysis
N_FRAMES, N_SWIMMERS, DT = 24, 30, 0.25


def walk(seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions and directors (n_frames, n_swimmers, 3), and who is there in which frame."""
    rng = np.random.default_rng(seed)
    place = np.cumsum(rng.normal(size=(N_FRAMES, N_SWIMMERS, 3)), axis=0)
    to = rng.normal(size=place.shape)
    to /= np.linalg.norm(to, axis=2, keepdims=True)
    there = rng.uniform(size=place.shape[:2]) > 0.3
    there[7] = False  # a frame that nobody is in
    there[:, 3] = False
    there[[2, 3], 3] = True  # one that is there twice
    there[:2, 4] = there[20:, 5] = False  # one that comes late, and one that leaves early
    there[0, 0] = there[-1, 0] = True
    return place, to, there


def table(place: np.ndarray, to: np.ndarray, there: np.ndarray) -> pa.Table:
    about = synthetic.info(n_swimmers=N_SWIMMERS, last_time=DT * (N_FRAMES - 1))
    every = synthetic.trajectory(about, DT * np.arange(N_FRAMES), place, to)
    return every.filter(pa.array(there.ravel()))


def pairs(values: np.ndarray, there: np.ndarray, lag: int) -> np.ndarray:
    """Mean over starts of values (n_frames - lag, n_swimmers) of which both frames are there, by swimmer, in loops."""
    each = np.full(N_SWIMMERS, math.nan)
    for swimmer in range(N_SWIMMERS):
        known = [values[k, swimmer] for k in range(N_FRAMES - lag) if there[k, swimmer] and there[k + lag, swimmer]]
        if known:
            each[swimmer] = sum(known) / len(known)
    return each


@pytest.mark.parametrize("lag", [1, 2, 5, 11])
def test_time_averages_are_over_the_pairs_of_frames_that_are_there(lag: int) -> None:
    place, to, there = walk()
    seen, lags = table(place, to, there), np.array([lag * DT])
    square = np.sum((place[lag:] - place[:-lag]) ** 2, axis=2)
    overlap = np.sum(to[lag:] * to[:-lag], axis=2)
    for found, values in (
        (an.time_averaged_msd(seen, lags=lags), square),
        (an.time_averaged_director_correlation(seen, lags=lags), overlap),
        (an.straightness(seen, lags=lags), np.sqrt(square) / (lag * DT)),
    ):
        each = pairs(values, there, lag)
        known = each[~np.isnan(each)]
        assert found.each[0] == pytest.approx(each, rel=1e-12, nan_ok=True)
        assert found.value[0] == pytest.approx(known.mean(), rel=1e-12)
        assert found.standard_error[0] == pytest.approx(np.std(known, ddof=1) / math.sqrt(len(known)), rel=1e-12)


def test_msd_and_correlation_from_the_start_are_those_of_the_swimmers_that_are_there_then_and_now() -> None:
    place, to, there = walk()
    seen = table(place, to, there)
    msd, memory = an.msd(seen), an.director_correlation(seen)
    frames = [k for k in range(N_FRAMES) if there[k].any()]
    assert msd.lag == pytest.approx(DT * np.array(frames))
    for row, k in enumerate(frames):
        both = there[0] & there[k]
        square = np.sum((place[k] - place[0])[both] ** 2, axis=1)
        assert msd.value[row] == pytest.approx(square.mean(), rel=1e-12)
        assert msd.standard_error[row] == pytest.approx(np.std(square, ddof=1) / math.sqrt(both.sum()), rel=1e-12)
        assert memory.value[row] == pytest.approx(np.sum(to[k] * to[0], axis=1)[both].mean(), rel=1e-12)
    assert msd.n == there[0].sum()


def test_nothing_is_put_into_gaps() -> None:
    """To and fro: after an odd number of frames 4, after an even one 0; a place between would be in the middle."""
    place = np.zeros((N_FRAMES, N_SWIMMERS, 3))
    place[::2, :, 0] = 2.0
    _, to, there = walk()
    found = an.time_averaged_msd(table(place, to, there), lags=DT * np.arange(1.0, 7.0))
    assert found.value.tolist() == [4.0, 0.0, 4.0, 0.0, 4.0, 0.0]


def test_own_tracks_need_no_directors_and_no_metadata_for_a_mean_squared_displacement() -> None:
    place, to, there = walk()
    whole = table(place, to, there)
    own = pa.table({name: whole[name].to_numpy() for name in ("time", "swimmer", "x", "y", "z")})
    assert an.msd(own).value == pytest.approx(an.msd(whole).value, rel=1e-14)
    averages = an.time_averaged_msd(own)
    assert averages.value == pytest.approx(an.time_averaged_msd(whole).value, rel=1e-14)
    assert len(an.msd_exponent(averages).lag) == len(averages.lag) - 1
    with pytest.raises(ResultsError, match=r"^persistence: trajectory: the table lacks ex, ey, ez; needed are"):
        an.persistence(own)


def test_the_diffusivity_of_brownian_tracks_with_gaps_is_theirs() -> None:
    rng = np.random.default_rng(3)
    n, frames = 400, 81
    place = np.cumsum(rng.normal(size=(frames, n, 3)), axis=0)  # steps of variance 1 in a time of 1: D = 1/2
    about = synthetic.info(n_swimmers=n, last_time=frames - 1.0)
    every = synthetic.trajectory(about, np.arange(float(frames)), place, place)
    seen = every.filter(pa.array(rng.uniform(size=len(every)) > 0.1))
    found = an.effective_diffusivity(seen, window=(1.0, 20.0))
    assert abs(found.value - 0.5) < 4.0 * found.standard_error < 0.1


def test_travel_starts_where_a_swimmer_is_first_seen_and_is_cut_off_where_it_is_last_seen() -> None:
    time = np.arange(10.0)
    place = np.zeros((10, 3, 3))
    place[:, :, 0] = time[:, None] * [1.0, 1.0, 0.1]
    there = np.ones((10, 3), bool)
    there[:4, 0] = False  # comes at 4
    there[3:6, 1] = False  # is away while it passes 4.5
    there[8:, 2] = False  # leaves at 7, too early
    every = synthetic.trajectory(synthetic.info(n_swimmers=3, last_time=9.0), time, place, place)
    found = an.travel_times(every.filter(pa.array(there.ravel())), distance=4.5, direction=(1.0, 0.0, 0.0))
    assert found.length == pytest.approx([4.5, 4.5, 7.0])
    assert found.ended.tolist() == [True, True, False]
    assert found.limit == pytest.approx([5.0, 9.0, 7.0])


def test_frames_at_odd_intervals_and_swimmers_with_no_time_in_common_are_refused() -> None:
    def own(time: np.ndarray, swimmer: np.ndarray) -> pa.Table:
        return pa.table({"time": time, "swimmer": swimmer, **dict.fromkeys("xyz", time)})

    time = np.array([0.0, 1.0, 2.3, 3.0, 4.0])
    with pytest.raises(ResultsError, match=r"found frames 0\.7 to 1\.3 a/U apart"):
        an.time_averaged_msd(own(time, np.zeros(5, int)))
    with pytest.raises(ResultsError, match="half and more may not be missing"):
        an.time_averaged_msd(own(np.array([0.0, 1.0, 90.0, 180.0]), np.zeros(4, int)))
    with pytest.raises(ResultsError, match="found 3000 rows for 3000 times and 3000 swimmers"):
        an.msd(own(np.arange(3000.0), np.arange(3000)))

"""Confidence bands and one-sample tests of survival curves against published and independent values."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.log_rank import one_sample_log_rank
from porous_swim.analysis.lifetimes.residence import escape_pitch_lifetimes, escape_pitch_times, residence_lifetimes
from porous_swim.analysis.lifetimes.survival import survival_curve
from porous_swim.analysis.lifetimes.survival_band import survival_at, survival_band
from tests.support import synthetic
from tests.support.remission import REMISSION

MEAN = 5.0


def lifetimes(length: np.ndarray, ended: np.ndarray, swimmer: np.ndarray) -> Lifetimes:
    return Lifetimes(length, ended, np.ones(len(length), bool), np.full(len(length), np.inf), swimmer)


def test_the_leukaemia_remissions_have_their_published_survival() -> None:
    curve = REMISSION.survival()
    assert curve.time.tolist() == [6, 7, 10, 13, 16, 22, 23]
    # As printed in the textbooks, to three decimals.
    assert curve.probability == pytest.approx([0.857, 0.807, 0.753, 0.690, 0.627, 0.538, 0.448], abs=5e-4)


@pytest.mark.parametrize("level", [0.5, 0.95])
def test_the_band_is_that_of_scipy_on_random_data_with_ties(level: float) -> None:
    rng = np.random.default_rng(1)
    length, ended = rng.integers(1, 30, 400).astype(float), rng.uniform(size=400) < 0.6
    curve = survival_curve(length, ended=ended)
    band = survival_band(curve, level=level)
    theirs = stats.ecdf(stats.CensoredData.right_censored(length, ~ended)).sf
    limits = theirs.confidence_interval(level, method="log-log")
    at = np.searchsorted(theirs.quantiles, curve.time)
    assert band.lower == pytest.approx(limits.low.probabilities[at], rel=1e-10, nan_ok=True)
    assert band.upper == pytest.approx(limits.high.probabilities[at], rel=1e-10, nan_ok=True)


def test_nothing_is_sure_where_the_curve_has_reached_zero() -> None:
    band = survival_band(survival_curve(np.array([1.0, 2.0]), ended=np.array([True, True])))
    assert np.isnan([band.lower[1], band.upper[1], band.standard_error[1]]).all()
    assert not np.isnan(band.lower[0])


def test_beyond_the_longest_time_seen_survival_is_not_a_number() -> None:
    """200 exponential stays of mean 50, all cut off at 10."""
    life = np.random.default_rng(0).exponential(50.0, 200)
    stays = lifetimes(np.minimum(life, 10.0), life < 10.0, np.arange(200))
    at = np.array([5.0, 10.0, np.nextafter(10.0, 11.0), 20.0, 1000.0])
    for found in (*survival_at(stays, at), stays.survival().at(at)):
        assert np.isnan(found).tolist() == [False, False, True, True, True]
    # binomial, as nothing was cut off before 10: three of its standard errors
    assert abs(stays.survival().at(np.array([10.0]))[0] - math.exp(-0.2)) < 3.0 * math.sqrt(0.82 * 0.18 / 200)
    assert survival_band(stays.survival()).longest == 10.0


def test_where_the_last_one_ended_survival_stays_zero() -> None:
    seen = lifetimes(np.array([1.0, 2.0, 3.0]), np.array([True, False, True]), np.arange(3))
    assert survival_at(seen, np.array([3.0, 99.0]))[0].tolist() == [0.0, 0.0]
    assert np.isnan(lifetimes(np.zeros(0), np.zeros(0, bool), np.zeros(0, int)).survival().at(np.array([1.0]))).all()


def test_the_band_of_cut_exponentials_covers_their_survival_19_times_in_20() -> None:
    rng = np.random.default_rng(2)
    inside = 0
    for _ in range(500):
        length = rng.exponential(MEAN, 200)
        cut = rng.uniform(0.0, 3.0 * MEAN, 200)
        curve = survival_curve(np.minimum(length, cut), ended=length < cut)
        band = survival_band(curve)
        at = np.searchsorted(curve.time, 0.7 * MEAN) - 1
        inside += band.lower[at] <= math.exp(-0.7) <= band.upper[at]
    # Binomial standard deviation of 500 at 0.95: 4.9. Four of them.
    assert abs(inside - 475) <= 4.0 * math.sqrt(500 * 0.95 * 0.05)


def test_survival_errors_over_swimmers_are_greenwoods_for_single_samples_and_the_spread_for_alike_ones() -> None:
    rng = np.random.default_rng(3)
    length, cut = rng.exponential(MEAN, 3000), rng.exponential(2.0 * MEAN, 3000)
    single = lifetimes(np.minimum(length, cut), length < cut, np.arange(3000))
    curve = single.survival()
    probability, error = survival_at(single, np.array([0.5, 1.0]) * MEAN)
    at = np.searchsorted(curve.time, np.array([0.5, 1.0]) * MEAN, side="right") - 1
    assert probability == pytest.approx(curve.probability[at], rel=1e-14)
    # Both estimate one variance; they differ by sampling of relative order 1/sqrt(3000).
    assert error == pytest.approx(survival_band(curve).standard_error[at], rel=0.05)
    found, errors = [], []
    for _ in range(400):
        rate = np.repeat(rng.gamma(2.0, 0.5, 100), 10)  # each of 100 swimmers has ends at a rate of its own
        length, cut = rng.exponential(MEAN / rate), rng.exponential(2.0 * MEAN, 1000)
        alike = lifetimes(np.minimum(length, cut), length < cut, np.arange(1000) // 10)
        probability, error = survival_at(alike, np.array([MEAN]))
        found.append(probability[0])
        errors.append(error[0])
    # The spread of 400 repeats is known to 1/sqrt(800) = 3.5 %: 4 of those.
    assert np.mean(errors) == pytest.approx(np.std(found), rel=0.14)


def test_the_log_rank_ratio_of_cut_exponentials_is_one_for_their_law_and_their_rate_for_another() -> None:
    rng = np.random.default_rng(4)
    table = synthetic.exponential_encounters(rng, n_swimmers=2000, mean=MEAN, last_time=2.0 * MEAN)
    watched = residence_lifetimes(table)
    right = one_sample_log_rank(watched, lambda time: np.exp(-time / MEAN))
    assert right.expected == pytest.approx(np.sum(watched.length) / MEAN, rel=1e-12)
    assert abs(right.ratio.value - 1.0) < 4.0 * right.ratio.standard_error
    assert right.ratio.standard_error < 0.02
    wrong = one_sample_log_rank(watched, lambda time: np.exp(-1.2 * time / MEAN))
    assert abs(wrong.ratio.value - 1.0 / 1.2) < 4.0 * wrong.ratio.standard_error
    assert wrong.p_value < 1e-6


def test_the_log_rank_p_value_is_uniform_under_the_law() -> None:
    rng = np.random.default_rng(5)
    values = []
    for _ in range(300):
        table = synthetic.exponential_encounters(rng, n_swimmers=100, mean=MEAN, last_time=MEAN)
        values.append(one_sample_log_rank(residence_lifetimes(table), lambda time: np.exp(-time / MEAN)).p_value)
    assert stats.kstest(values, "uniform").pvalue > 1e-4  # one false alarm in 10^4


def test_escape_pitch_lifetimes_keep_the_rows_of_the_table_so_that_groups_keep_their_next_encounters() -> None:
    table = synthetic.encounters(
        synthetic.info(last_time=20.0),
        swimmer=[1, 0, 0], start_time=[2.0, 8.0, 1.0], end_time=[4.0, 9.0, 3.0],
        escape_pitch_time=[5.0, np.nan, np.nan],
    )  # fmt: skip
    every = escape_pitch_lifetimes(table)
    # The second row waits until the end of the run, the third until the swimmer's next encounter at 8.
    assert every.length.tolist() == [3.0, 12.0, 7.0]
    assert every.ended.tolist() == [True, False, False]
    assert every.limit.tolist() == [18.0, 12.0, 7.0]
    assert every.select(np.array([False, False, True])).summary().n_censored == 1
    assert escape_pitch_times(table).mean == 22.0

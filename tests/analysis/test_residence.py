"""Residence times, survival curves and their errors on tables with known answers."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from porous_swim.analysis.estimates import Swimmers, ratio_of_sums
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.residence import (
    bound_fraction,
    bound_fraction_at,
    contact_fraction,
    contact_fraction_of_encounters,
    escape_pitch_times,
    residence_survival,
    residence_times,
)
from porous_swim.analysis.lifetimes.survival import survival_curve, waiting_times
from porous_swim.analysis.winding import winding
from tests.support import synthetic

MEAN = 5.0


def test_exponential_residence_cut_at_one_mean_is_recovered_where_completed_ones_mislead() -> None:
    rng = np.random.default_rng(1)
    table = synthetic.exponential_encounters(rng, n_swimmers=4000, mean=MEAN, last_time=MEAN)
    found = residence_times(table)
    assert found.n_censored == 4000  # every swimmer is bound when the run ends
    assert abs(found.mean - MEAN) < 4.0 * found.standard_error
    assert found.standard_error < 0.02 * MEAN * 1.5  # about MEAN/sqrt(n), n = 4000 ends
    # A completed one started at u in (0, MEAN) and ended before MEAN: far shorter than MEAN on average.
    assert found.mean_completed < 0.5 * MEAN


def test_restricted_mean_of_the_exponential_is_that_of_its_survival() -> None:
    rng = np.random.default_rng(2)
    table = synthetic.exponential_encounters(rng, n_swimmers=4000, mean=MEAN, last_time=2.0 * MEAN)
    found = residence_times(table, horizon=MEAN)
    exact = MEAN * (1.0 - math.exp(-1.0))  # integral of exp(-t/MEAN) to MEAN
    assert abs(found.restricted_mean - exact) < 4.0 * found.restricted_standard_error
    assert found.restricted_standard_error < 0.01 * exact  # so that the line above can fail


def test_survival_of_the_exponential_under_censoring_is_exponential() -> None:
    rng = np.random.default_rng(3)
    table = synthetic.exponential_encounters(rng, n_swimmers=4000, mean=MEAN, last_time=MEAN)
    curve = residence_survival(table)
    at = np.searchsorted(curve.time, [0.2 * MEAN, 0.5 * MEAN, 0.8 * MEAN]) - 1
    # Greenwood's error, spelt out for the three times.
    terms = curve.n_ended / (curve.n_at_risk * (curve.n_at_risk - curve.n_ended))
    error = curve.probability[at] * np.sqrt(np.cumsum(terms)[at])
    assert np.all(np.abs(curve.probability[at] - np.exp([-0.2, -0.5, -0.8])) < 4.0 * error)


def test_survival_of_six_samples_is_the_one_worked_by_hand() -> None:
    # Ends at 1, 3, 3, 6; censored at 3 (at risk there) and 4.
    length = np.array([3.0, 1.0, 4.0, 3.0, 6.0, 3.0])
    ended = np.array([True, True, False, True, True, False])
    curve = survival_curve(length, ended=ended)
    assert curve.time.tolist() == [1.0, 3.0, 6.0]
    assert curve.n_at_risk.tolist() == [6, 5, 1]
    assert curve.n_ended.tolist() == [1, 2, 1]
    assert curve.probability == pytest.approx([5.0 / 6.0, 5.0 / 6.0 * 3.0 / 5.0, 0.0], abs=1e-15)
    found = waiting_times(length, ended=ended, swimmer=np.arange(6), horizon=5.0)
    assert found.restricted_mean == pytest.approx(1.0 + 2.0 * 5.0 / 6.0 + 2.0 * 0.5, rel=1e-14)
    assert found.mean == pytest.approx(20.0 / 4.0, rel=1e-14)
    assert found.mean_completed == pytest.approx(13.0 / 4.0, rel=1e-14)


def test_restricted_error_is_close_to_leaving_out_each_swimmer_in_turn() -> None:
    rng = np.random.default_rng(4)
    n = 600
    swimmer, length = rng.integers(0, 200, n), rng.exponential(1.0, n)
    ended = length < rng.exponential(2.0, n)
    full = waiting_times(length, ended=ended, swimmer=swimmer, horizon=1.5)
    left_out = []
    for k in np.unique(swimmer):
        rest = swimmer != k
        part = waiting_times(length[rest], ended=ended[rest], swimmer=swimmer[rest], horizon=1.5)
        left_out.append(part.restricted_mean)
    m = len(left_out)
    # The two jackknives differ by terms of relative order 1/m.
    assert full.restricted_standard_error == pytest.approx(math.sqrt((m - 1) * np.var(left_out)), rel=0.02)


def test_errors_are_the_spread_over_repeats_when_encounters_of_a_swimmer_are_alike() -> None:
    rng = np.random.default_rng(5)
    means, errors, areas, area_errors = [], [], [], []
    for _ in range(400):
        swimmer = np.repeat(np.arange(100), 5)
        length = rng.exponential(1.0, 500) * rng.gamma(4.0, 0.25, 100)[swimmer]  # slow and fast swimmers
        found = waiting_times(np.minimum(length, 2.0), ended=length < 2.0, swimmer=swimmer, horizon=1.5)
        means.append(found.mean)
        errors.append(found.standard_error)
        areas.append(found.restricted_mean)
        area_errors.append(found.restricted_standard_error)
    # The spread of 400 repeats is known to 1/sqrt(800) = 3.5 %: 4 of those, and 2 % for bias.
    assert np.mean(errors) == pytest.approx(np.std(means), rel=0.16)
    assert np.mean(area_errors) == pytest.approx(np.std(areas), rel=0.16)


def watched(length: np.ndarray, limit: np.ndarray) -> Lifetimes:
    """One lifetime for each swimmer, cut off at `limit`."""
    n = len(length)
    return Lifetimes(np.minimum(length, limit), length < limit, np.ones(n, bool), limit, np.arange(n))


def test_a_mean_of_which_much_is_cut_off_ends_where_a_quarter_could_be_followed_however_long_they_lasted() -> None:
    rng = np.random.default_rng(6)
    limit = rng.uniform(0.0, 100.0, 400)  # entered all through a run of 100: a quarter could be followed for 75
    for mean in (200.0, 800.0):
        assert watched(rng.exponential(mean, 400), limit).summary().horizon == 50.0
    together = np.full(400, 73.0)
    assert watched(rng.exponential(200.0, 400), together).summary().horizon == 73.0


def test_a_mean_of_which_next_to_nothing_is_cut_off_ends_at_the_longest() -> None:
    rng = np.random.default_rng(7)
    found = watched(rng.exponential(1.0, 400), rng.uniform(8.0, 10.0, 400)).summary()
    assert found.n_censored <= 2
    assert found.horizon < 10.0
    assert found.restricted_warning is None
    assert abs(found.restricted_mean - 1.0) < 4.0 * found.restricted_standard_error


def test_a_horizon_that_the_data_chose_where_many_outlast_it_has_no_error() -> None:
    seen = watched(np.array([1.0, 2.0, 5.0, 9.0, 9.0]), np.full(5, 6.0))
    length, rest = seen.length, {"ended": seen.ended, "swimmer": seen.swimmer}
    chosen = waiting_times(length, **rest)
    assert (chosen.horizon, math.isnan(chosen.restricted_standard_error)) == (6.0, True)
    assert "40 % reach" in chosen.restricted_estimate().as_dict()["warning"]
    given = waiting_times(length, horizon=6.0, **rest)
    assert given.restricted_mean == chosen.restricted_mean
    assert given.restricted_mean == pytest.approx((1.0 + 2.0 + 5.0 + 6.0 + 6.0) / 5.0, rel=1e-14)
    assert given.restricted_standard_error > 0.0
    assert "warning" not in given.restricted_estimate().as_dict()


def test_without_an_end_up_to_the_horizon_the_restricted_mean_is_marked_as_the_horizon() -> None:
    found = watched(np.full(5, 9.0), np.full(5, 6.0)).summary()
    assert (found.restricted_mean, found.horizon, math.isnan(found.restricted_standard_error)) == (6.0, 6.0, True)
    assert found.restricted_estimate().warning == (
        "No end was seen up to 6 a/U: the value is that limit itself, a lower bound of the mean."
    )


def test_a_horizon_beyond_what_was_seen_is_cut_back_unless_all_ended() -> None:
    length, swimmer = np.array([1.0, 2.0]), np.arange(2)
    assert waiting_times(length, ended=np.array([True, False]), swimmer=swimmer, horizon=9.0).horizon == 2.0
    all_ended = waiting_times(length, ended=np.array([True, True]), swimmer=swimmer, horizon=9.0)
    assert (all_ended.horizon, all_ended.restricted_mean) == (9.0, 1.5)


def test_an_encounter_cut_at_its_start_adds_time_and_stays_out_of_survival() -> None:
    table = synthetic.encounters(
        synthetic.info(n_swimmers=2),
        swimmer=[0, 1],
        start_time=[0.0, 10.0],
        end_time=[6.0, 14.0],
        start_censored=[True, False],
    )
    found = residence_times(table)
    assert (found.mean, found.mean_completed, found.restricted_mean) == (5.0, 4.0, 4.0)
    assert residence_survival(table).n_at_risk.tolist() == [1]


def test_without_any_end_there_is_no_value() -> None:
    table = synthetic.encounters(synthetic.info(), swimmer=[0], start_time=[1.0], end_time=[100.0], end_censored=[True])
    found = residence_times(table).estimate().as_dict()
    assert found == {"value": None, "standard_error": None, "n": 0, "n_censored": 1, "unit": "a/U"}
    empty = residence_times(synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)))
    assert math.isnan(empty.mean)
    assert math.isnan(empty.restricted_mean)


def test_the_escape_pitch_is_waited_for_until_the_next_encounter_or_the_end() -> None:
    table = synthetic.encounters(
        synthetic.info(n_swimmers=2, last_time=50.0),
        swimmer=[1, 0, 0],
        start_time=[40.0, 20.0, 5.0],
        end_time=[45.0, 24.0, 9.0],
        escape_pitch_time=[np.nan, 23.0, np.nan],
    )
    found = escape_pitch_times(table)
    # Waited: 5 to 20 in vain, 20 to 23, 40 to 50 in vain.
    assert (found.n, found.n_censored) == (1, 2)
    assert found.mean == pytest.approx(15.0 + 3.0 + 10.0, rel=1e-14)
    assert found.mean_completed == 3.0


def test_fractions_of_time_count_swimmers_that_met_nothing() -> None:
    table = synthetic.encounters(
        synthetic.info(n_swimmers=4, last_time=10.0),
        swimmer=[0, 0, 2],
        start_time=[0.0, 5.0, 6.0],
        end_time=[2.0, 8.0, 10.0],
        end_censored=[False, False, True],
        contact_time=[1.0, 1.0, 4.0],
    )
    bound, contact = bound_fraction(table), contact_fraction(table)
    assert bound.value == pytest.approx((0.5 + 0.0 + 0.4 + 0.0) / 4.0, rel=1e-14)
    assert bound.standard_error == pytest.approx(np.std([0.5, 0.0, 0.4, 0.0], ddof=1) / 2.0, rel=1e-12)
    assert contact.value == pytest.approx((0.2 + 0.4) / 4.0, rel=1e-14)
    assert contact_fraction_of_encounters(table).value == pytest.approx(6.0 / 9.0, rel=1e-14)
    fraction, error = bound_fraction_at(table, np.array([0.0, 2.0, 6.5, 10.0]))
    assert fraction.tolist() == [0.25, 0.0, 0.5, 0.25]
    assert error[2] == pytest.approx(math.sqrt(0.25 / 3.0), rel=1e-14)


def test_winding_gives_completed_means_and_an_unbiased_rate() -> None:
    table = synthetic.encounters(
        synthetic.info(n_swimmers=3, last_time=20.0),
        swimmer=[0, 1, 2],
        start_time=[0.0, 0.0, 0.0],
        end_time=[4.0, 6.0, 20.0],
        end_censored=[False, False, True],
        winding=[0.5, 1.5, 8.0],
        signed_winding=[-0.4, 1.2, 7.0],
    )
    found = winding(table)
    assert (found.completed.value, found.completed.n, found.completed.n_censored) == (1.0, 2, 1)
    assert found.net.value == pytest.approx(0.8, rel=1e-14)
    assert found.rate.value == pytest.approx(10.0 / 30.0, rel=1e-14)
    assert found.above_one_turn.value == 0.5


def test_winding_has_no_net_value_in_three_dimensions() -> None:
    table = synthetic.encounters(synthetic.info(), swimmer=[0], start_time=[0.0], end_time=[4.0], winding=[0.5])
    assert winding(table).net.as_dict()["value"] is None


def test_jackknife_of_equal_groups_is_the_error_of_the_mean() -> None:
    values = np.random.default_rng(6).normal(3.0, 1.0, 50)
    value, error = ratio_of_sums(values, np.ones(50))
    assert value == pytest.approx(values.mean(), rel=1e-14)
    assert error == pytest.approx(values.std(ddof=1) / math.sqrt(50), rel=1e-10)


def test_one_group_with_all_of_the_denominator_has_no_error() -> None:
    value, error = ratio_of_sums(np.array([1.0, 2.0]), np.array([1.0, 0.0]))
    assert value == 3.0
    assert math.isnan(error)


def test_swimmers_are_numbered_without_gaps() -> None:
    swimmers = Swimmers.of(np.array([7, 3, 7, 900]))
    assert swimmers.n == 3
    assert swimmers.sums(np.array([1.0, 2.0, 4.0, 8.0])).tolist() == [2.0, 5.0, 8.0]


def test_a_million_encounters_take_seconds() -> None:
    rng = np.random.default_rng(7)
    table = synthetic.exponential_encounters(rng, n_swimmers=200_000, mean=MEAN, last_time=4.0 * MEAN)
    assert len(table) > 900_000
    start = time.perf_counter()
    residence_times(table)
    escape_pitch_times(table)
    winding(table)
    assert time.perf_counter() - start < 10.0  # some 2 s on one core; a loop over swimmers takes minutes

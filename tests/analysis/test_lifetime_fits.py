"""Maximum-likelihood fits of laws to lengths that are cut off, against closed forms, scipy and coverage."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from porous_swim import theory
from porous_swim.analysis.lifetimes.goodness_of_fit import goodness_of_fit
from porous_swim.analysis.lifetimes.lifetime_fits import fit_lifetimes
from porous_swim.analysis.lifetimes.lifetime_laws import LAWS
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.residence import residence_lifetimes, residence_times
from tests.support import synthetic
from tests.support.remission import REMISSION

WITHIN_500 = 4.0 * math.sqrt(0.95 * 0.05 / 500)  # four binomial standard errors of a coverage of 95 % in 500 repeats


def cut(length: np.ndarray, limit: np.ndarray, *, per_swimmer: int = 1) -> Lifetimes:
    n = len(length)
    swimmer = np.arange(n) // per_swimmer
    return Lifetimes(np.minimum(length, limit), length < limit, np.ones(n, bool), limit, swimmer)


def drawn(law: str, rng: np.random.Generator, n: int) -> Lifetimes:
    """A third or so of the lengths cut off."""
    if law == "exponential":
        return cut(rng.exponential(5.0, n), rng.uniform(0.0, 20.0, n))
    if law == "inverse_gaussian":
        return cut(rng.wald(5.0, 8.0, n), rng.uniform(1.0, 15.0, n))
    return cut(2.0 * (1.0 - rng.uniform(size=n)) ** (-1.0 / 1.5), 2.0 * rng.uniform(1.0, 5.0, n))


TRUE = {
    "exponential": {"mean": 5.0},
    "inverse_gaussian": {"mean": 5.0, "shape": 8.0},
    "power_law": {"exponent": 2.5},
}


def test_the_exponential_mean_of_the_leukaemia_remissions_is_their_time_over_their_ends() -> None:
    assert fit_lifetimes(REMISSION, "exponential").parameters["mean"].value == pytest.approx(359.0 / 9.0, rel=1e-14)


@pytest.mark.parametrize(("mean", "shape"), [(5.0, 8.0), (5.0, 0.1), (5.0, 500.0), (40.0, 137.0)])
def test_the_inverse_gaussian_is_that_of_scipy(mean: float, shape: float) -> None:
    x = mean * np.array([0.01, 0.3, 0.999, 1.0, 1.001, 3.0, 30.0])
    ours, coordinates = LAWS["inverse_gaussian"], np.log([mean, shape])
    frozen = theory.inverse_gaussian(mean, math.sqrt(mean**3 / shape))
    # Logarithms of up to some 1e4 in size, to rounding.
    assert ours.log_density(x, coordinates, 0.0) == pytest.approx(frozen.logpdf(x), rel=1e-11, abs=1e-12)
    assert ours.log_survival(x, coordinates, 0.0) == pytest.approx(frozen.logsf(x), rel=1e-9, abs=1e-12)


def test_the_inverse_gaussian_fit_of_cut_lengths_is_that_of_scipy_and_recovers_the_law() -> None:
    sample = drawn("inverse_gaussian", np.random.default_rng(1), 4000)
    fit = fit_lifetimes(sample, "inverse_gaussian")
    data = stats.CensoredData.right_censored(sample.length, ~sample.ended)
    ratio, _, shape = stats.invgauss.fit(data, floc=0.0)
    # Both are searches that stop where the likelihood is flat: 1e-4 of a parameter changes it by less than 1e-4.
    assert fit.parameters["mean"].value == pytest.approx(ratio * shape, rel=1e-4)
    assert fit.parameters["shape"].value == pytest.approx(shape, rel=1e-4)
    law = stats.invgauss(
        fit.parameters["mean"].value / fit.parameters["shape"].value, scale=fit.parameters["shape"].value
    )
    likelihood = np.sum(np.where(sample.ended, law.logpdf(sample.length), law.logsf(sample.length)))
    assert fit.log_likelihood == pytest.approx(likelihood, rel=1e-10)
    assert (fit.n, fit.n_censored, fit.n_below) == (sample.ended.sum(), (~sample.ended).sum(), 0)
    for name, true in TRUE["inverse_gaussian"].items():
        assert abs(fit.parameters[name].value - true) < 4.0 * fit.parameters[name].standard_error
        assert fit.parameters[name].standard_error < 0.04 * true


def test_without_censoring_the_inverse_gaussian_fit_is_the_closed_one() -> None:
    length = np.random.default_rng(2).wald(3.0, 2.0, 500)
    fit = fit_lifetimes(cut(length, np.full(500, np.inf)), "inverse_gaussian")
    # Tweedie (1957): the mean, and the inverse of the mean of 1/length - 1/mean. Found by search to 1e-8.
    assert fit.parameters["mean"].value == pytest.approx(length.mean(), rel=1e-6)
    assert fit.parameters["shape"].value == pytest.approx(1.0 / np.mean(1.0 / length - 1.0 / length.mean()), rel=1e-6)
    # Information n/(2 shape^2), in the logarithm n/2.
    assert fit.parameters["shape"].model_error == pytest.approx(
        fit.parameters["shape"].value * math.sqrt(2 / 500), rel=1e-4
    )


@pytest.mark.parametrize("law", list(LAWS))
def test_intervals_cover_the_truth_19_times_in_20(law: str) -> None:
    rng = np.random.default_rng(3)
    cutoff = 2.0 if law == "power_law" else 0.0
    inside = dict.fromkeys(TRUE[law], 0)
    for _ in range(500):
        fit = fit_lifetimes(drawn(law, rng, 200), law, cutoff=cutoff)  # type: ignore[arg-type]
        for name, true in TRUE[law].items():
            low, high = fit.parameters[name].interval
            inside[name] += low <= true <= high
    for n in inside.values():
        assert abs(n / 500 - 0.95) <= WITHIN_500


def test_a_law_is_the_same_above_any_cutoff_and_lengths_below_are_counted() -> None:
    rng = np.random.default_rng(4)
    for law, cutoff in (("exponential", 3.0), ("inverse_gaussian", 2.5), ("power_law", 3.0)):
        fit = fit_lifetimes(drawn(law, rng, 20000), law, cutoff=cutoff)  # type: ignore[arg-type]
        assert fit.n + fit.n_censored + fit.n_below == 20000
        assert fit.n_below > 3000
        for name, true in TRUE[law].items():
            assert abs(fit.parameters[name].value - true) < 4.0 * fit.parameters[name].standard_error
            assert fit.parameters[name].standard_error < 0.1 * true
        assert fit.survival(np.array([0.0, cutoff])).tolist() == [1.0, 1.0]
        assert np.all(fit.draw(rng, 1000) > cutoff)


def test_draws_of_a_fit_follow_its_survival() -> None:
    rng = np.random.default_rng(5)
    for law, cutoff in (("exponential", 0.0), ("inverse_gaussian", 2.5), ("power_law", 2.0)):
        fit = fit_lifetimes(drawn(law, rng, 500), law, cutoff=cutoff)  # type: ignore[arg-type]
        found = stats.kstest(fit.draw(rng, 5000), lambda time, fit=fit: 1.0 - fit.survival(time))
        assert found.pvalue > 1e-4  # one false alarm in 10^4


def test_errors_over_swimmers_are_the_spread_where_those_of_the_model_are_too_small() -> None:
    rng = np.random.default_rng(6)
    means, robust, model = [], [], []
    for _ in range(400):
        own = np.repeat(rng.gamma(4.0, 0.25, 80), 10)  # a mean of its own for each of 80 swimmers
        sample = cut(5.0 * own * rng.exponential(1.0, 800), np.full(800, 12.0), per_swimmer=10)
        mean = fit_lifetimes(sample, "exponential").parameters["mean"]
        means.append(mean.value)
        robust.append(mean.standard_error)
        model.append(mean.model_error)
    # The spread of 400 repeats is known to 1/sqrt(800) = 3.5 %: 4 of those.
    assert np.mean(robust) == pytest.approx(np.std(means), rel=0.14)
    assert np.mean(model) < 0.75 * np.std(means)


def test_the_exponential_fit_of_a_run_is_its_mean_residence_and_its_jackknife() -> None:
    table = synthetic.exponential_encounters(np.random.default_rng(7), n_swimmers=500, mean=5.0, last_time=5.0)
    fit, times = fit_lifetimes(residence_lifetimes(table), "exponential"), residence_times(table)
    assert fit.parameters["mean"].value == pytest.approx(times.mean, rel=1e-13)
    # The infinitesimal and the delete-one jackknife differ by terms of relative order 1/500.
    assert fit.parameters["mean"].standard_error == pytest.approx(times.standard_error, rel=0.01)


def test_akaike_and_the_bootstrap_tell_the_right_law_from_a_wrong_one() -> None:
    sample = drawn("inverse_gaussian", np.random.default_rng(8), 1000)
    right, wrong = fit_lifetimes(sample, "inverse_gaussian"), fit_lifetimes(sample, "exponential")
    assert right.aic < wrong.aic - 100.0
    assert goodness_of_fit(sample, right, n_repeats=99).p_value > 0.01
    assert goodness_of_fit(sample, wrong, n_repeats=99).p_value == 0.01


def test_p_values_of_the_bootstrap_are_uniform_for_the_right_law() -> None:
    rng = np.random.default_rng(9)
    found = []
    for seed in range(200):
        sample = drawn("exponential", rng, 60)
        found.append(goodness_of_fit(sample, fit_lifetimes(sample, "exponential"), n_repeats=99, seed=seed).p_value)
    # They are multiples of 1/100: shifted into the middle of each, as far as a test of 200 can tell from uniform.
    assert stats.kstest(np.array(found) - 0.005, "uniform").pvalue > 1e-4


def test_without_an_end_there_is_no_fit() -> None:
    fit = fit_lifetimes(cut(np.full(3, 9.0), np.full(3, 2.0)), "inverse_gaussian")
    assert (fit.n, fit.n_censored) == (0, 3)
    assert math.isnan(fit.parameters["mean"].value)
    assert math.isnan(goodness_of_fit(cut(np.full(3, 9.0), np.full(3, 2.0)), fit).p_value)


def test_wrong_arguments_are_named() -> None:
    sample = drawn("exponential", np.random.default_rng(10), 5)
    with pytest.raises(ValueError, match="power_law takes > 0"):
        fit_lifetimes(sample, "power_law")
    with pytest.raises(ValueError, match="allowed are exponential, inverse_gaussian, power_law"):
        fit_lifetimes(sample, "weibull")  # type: ignore[arg-type]


def test_equal_lengths_and_hardly_any_ends_have_no_inverse_gaussian() -> None:
    equal = fit_lifetimes(cut(np.full(9, 3.0), np.full(9, 5.0)), "inverse_gaussian")
    lengths = np.append([0.006, 0.009], np.full(500, 1.0))
    hardly = fit_lifetimes(cut(lengths, np.full(502, 0.01)), "inverse_gaussian")
    for fit in (equal, hardly):
        assert math.isnan(fit.parameters["mean"].value)
        assert math.isnan(fit.aic)
        assert np.isnan(fit.parameters["shape"].interval).all()

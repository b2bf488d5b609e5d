"""Survival curves, fits and mean squared displacements against lifelines and freud, which share no code with us."""

from __future__ import annotations

import autograd.numpy as anp
import freud
import numpy as np
import pytest
from autograd.scipy.stats import norm
from lifelines import ExponentialFitter, KaplanMeierFitter
from lifelines.fitters import ParametricUnivariateFitter
from lifelines.statistics import logrank_test
from lifelines.utils import restricted_mean_survival_time

import porous_swim as ps
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.transport.transport import tracks
from tests.support import walks
from tests.support.remission import REMISSION

an = ps.analysis


def lifetimes(length: np.ndarray, ended: np.ndarray) -> Lifetimes:
    """One for each swimmer."""
    n = len(length)
    return Lifetimes(length, ended, np.ones(n, bool), np.full(n, np.inf), np.arange(n))


def tied(n: int = 400) -> Lifetimes:
    rng = np.random.default_rng(1)
    return lifetimes(rng.integers(1, 30, n).astype(float), rng.uniform(size=n) < 0.6)


def inverse_gaussian(n: int = 2000) -> Lifetimes:
    rng = np.random.default_rng(2)
    length, cut = rng.wald(5.0, 8.0, n), rng.uniform(1.0, 15.0, n)
    return lifetimes(np.minimum(length, cut), length < cut)


class InverseGaussianFitter(ParametricUnivariateFitter):
    """The law as its survival function alone; density and errors by their automatic differentiation."""

    _fitted_parameter_names = ("mean_", "shape_")

    def _cumulative_hazard(self, params, times):
        mean, shape = params
        root = anp.sqrt(shape / times)
        beyond = norm.cdf(root * (1.0 - times / mean)) - anp.exp(2.0 * shape / mean) * norm.cdf(
            -root * (1.0 + times / mean)
        )
        return -anp.log(beyond)


class PowerLawFitter(ParametricUnivariateFitter):
    """Survival (length/2)^(1 - exponent) above 2."""

    _fitted_parameter_names = ("exponent_",)
    _bounds = ((1.0, None),)

    def _cumulative_hazard(self, params, times):
        return (params[0] - 1.0) * anp.log(times / 2.0)


@pytest.mark.parametrize("sample", [REMISSION, tied()], ids=["remission", "ties"])
@pytest.mark.parametrize("level", [0.5, 0.95])
def test_kaplan_meier_and_its_band_are_those_of_lifelines(sample: Lifetimes, level: float) -> None:
    theirs = KaplanMeierFitter(alpha=1.0 - level).fit(sample.length, sample.ended)
    curve = sample.survival()
    band = an.survival_band(curve, level=level)
    assert curve.probability == pytest.approx(theirs.survival_function_at_times(curve.time).to_numpy(), rel=1e-12)
    limits = theirs.confidence_interval_.loc[curve.time].to_numpy()
    known = curve.probability > 0.0
    assert np.stack([band.lower, band.upper], axis=1)[known] == pytest.approx(limits[known], rel=1e-9)
    mean = sample.summary(horizon=20.0).restricted_mean
    assert mean == pytest.approx(restricted_mean_survival_time(theirs, t=20.0), rel=1e-9)


@pytest.mark.parametrize("sample", [REMISSION, tied()], ids=["remission", "ties"])
def test_the_exponential_fit_is_that_of_lifelines(sample: Lifetimes) -> None:
    ours, theirs = an.fit_lifetimes(sample, "exponential"), ExponentialFitter().fit(sample.length, sample.ended)
    # Theirs is a search; our errors are finite differences of 1e-3, off by 1e-6 of themselves.
    assert ours.parameters["mean"].value == pytest.approx(theirs.lambda_, rel=1e-5)
    assert ours.parameters["mean"].model_error == pytest.approx(theirs.summary["se(coef)"].iloc[0], rel=1e-4)
    assert ours.log_likelihood == pytest.approx(theirs.log_likelihood_, abs=1e-6)
    assert ours.aic == pytest.approx(theirs.AIC_, abs=1e-5)


def test_fits_of_the_inverse_gaussian_and_of_the_power_law_are_those_of_lifelines() -> None:
    sample = inverse_gaussian()
    ours, theirs = an.fit_lifetimes(sample, "inverse_gaussian"), InverseGaussianFitter()
    require_same(ours, theirs.fit(sample.length, sample.ended, initial_point=np.array([4.0, 4.0])))
    above = sample.select(sample.length > 2.0)
    require_same(an.fit_lifetimes(sample, "power_law", cutoff=2.0), PowerLawFitter().fit(above.length, above.ended))


def require_same(ours: an.LifetimeFit, theirs: ParametricUnivariateFitter) -> None:
    assert ours.log_likelihood == pytest.approx(theirs.log_likelihood_, abs=1e-5)
    for name, found in ours.parameters.items():
        their = theirs.summary.loc[f"{name}_"]
        # Both are searches that stop where the likelihood is flat: 1e-4 of a parameter changes it by less than 1e-4.
        assert found.value == pytest.approx(their["coef"], rel=1e-4)
        assert found.model_error == pytest.approx(their["se(coef)"], rel=1e-3)


def test_the_log_rank_test_against_a_law_is_that_of_lifelines_against_a_large_sample_of_it() -> None:
    rng = np.random.default_rng(3)
    length, cut = rng.exponential(5.0, 1000), rng.uniform(0.0, 20.0, 1000)
    sample = lifetimes(np.minimum(length, cut), length < cut)
    ours = an.one_sample_log_rank(sample, lambda time: np.exp(-1.2 * time / 5.0))
    law = -5.0 / 1.2 * np.log1p(-(np.arange(1_000_000) + 0.5) / 1_000_000)  # its quantiles
    theirs = logrank_test(sample.length, law, sample.ended)
    # Beside so large a sample the variance is the number of ends expected, but for 1000 in 1 000 000.
    assert (ours.observed - ours.expected) ** 2 / ours.expected == pytest.approx(theirs.test_statistic, rel=5e-3)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_mean_squared_displacements_are_those_of_freud(dimensions: int) -> None:
    table = walks.brownian(
        np.random.default_rng(4), n_swimmers=30, n_frames=101, dimensions=dimensions, diffusivity=0.4, drift=0.1
    )
    position = tracks(table).position
    lag = np.arange(1, 101)
    # freud takes differences of sums of squares over all starts, in single precision: some roundings of those sums.
    squares = np.sum(position**2, axis=(0, 2)).max()
    rounding = 8.0 * np.finfo(np.float32).eps * squares / (101 - lag)
    windowed, ours = freud.msd.MSD(mode="window").compute(position), an.time_averaged_msd(table, lags=lag)
    assert np.all(np.abs(ours.each - windowed.particle_msd[1:]) < rounding[:, None])
    assert np.all(np.abs(ours.value - windowed.msd[1:]) < rounding)
    assert np.all(rounding < 1e-3 * ours.value)
    direct = freud.msd.MSD(mode="direct").compute(position)
    assert an.msd(table).value == pytest.approx(direct.msd, rel=1e-5)

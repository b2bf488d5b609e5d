"""Errors over swimmers are such that Student's intervals of 95 % cover what is true of crowds and walks.

In 500 repeats errors that are too small by a seventh are found out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import norm

import porous_swim as ps
from tests.support import walks
from tests.support.coverage import Experiment, Statistic, within
from tests.support.crowd import Crowd, Kind
from tests.support.crowd_statistics import HORIZON, of_encounters, waiting

an = ps.analysis

SLOW = Kind(escape=0.05, capture=0.5, passage=0.2, turns=2.0, contact=0.2, bonds=(0.2, 0.3, 0.2, 0.2, 0.1))
FAST = Kind(escape=0.2, capture=0.3, passage=0.5, turns=0.5, contact=0.4, bonds=(0.4, 0.1, 0.3, 0.1, 0.1))
LAST_TIME = 20.0  # a/U, one mean stay of the slow ones: half of theirs are cut off
REPEATS = 500
NETWORKS = ("hop_network", "hop_counts")


def at(found, *places: int) -> tuple:
    """Values and errors at some of the lags."""
    return found.value[list(places)], found.standard_error[list(places)]


c = np.exp(-0.18)
LAGS = np.array([2.0, 10.0])
EXACT = walks.persistent_msd(LAGS, turning=0.6, diffusivity=0.2)
PERSISTENT = {
    "msd": Statistic(lambda d: at(an.msd(d), 2, 10), EXACT),
    "time_averaged_msd": Statistic(lambda d: an.time_averaged_msd(d, lags=LAGS), EXACT),
    "director_correlation": Statistic(lambda d: at(an.director_correlation(d), 2, 10), c**LAGS),
    "time_averaged_director_correlation": Statistic(
        lambda d: an.time_averaged_director_correlation(d, lags=LAGS), c**LAGS),
    "msd_exponent": Statistic(
        lambda d: an.msd_exponent(an.time_averaged_msd(d, lags=LAGS)), np.diff(np.log(EXACT)) / np.log(5.0)),
    "persistence": Statistic(lambda d: [an.persistence(d).length], [1.0 / (1.0 - c)]),
    "persistence.projection": Statistic(
        lambda d: an.persistence(d, lags=LAGS).projection, (1.0 - c**LAGS) / (1.0 - c)),
}  # fmt: skip
BIN = np.array([-2.0, 3.0])
BROWNIAN = {  # steps of variance 1 along each axis
    "diffusivity": Statistic(lambda d: [an.diffusivity(d, persistence_time=1.0)], [0.5]),
    "straightness": Statistic(lambda d: an.straightness(d, lags=LAGS), np.sqrt(0.5 * np.pi / LAGS)),
    # 100 swimmers rarely have their share of long ways, on which fourth powers rest.
    "non_gaussian_parameter": Statistic(lambda d: an.non_gaussian_parameter(d, lags=LAGS), [0.0, 0.0], rate=0.925),
    "displacement_histogram": Statistic(
        lambda d: an.displacement_histogram(d, lag=4.0, edges=BIN), np.diff(norm.cdf(BIN / 2.0)) / np.diff(BIN)),
}  # fmt: skip
MIXED = {
    "non_gaussian_parameter": Statistic(lambda d: an.non_gaussian_parameter(d, lags=LAGS), [0.25, 0.25], rate=0.925),
}
LINGERING = {
    "height_pitch_density": Statistic(
        lambda d: an.height_pitch_density(*d, heights=np.array([0.5, 1.0, 1.5]), n_pitches=2), np.full(4, 1.0 / np.pi)),
    "cell_density": Statistic(lambda d: an.cell_density(d[0], cell=(1.0, 1.0), n_bins=2), np.full(4, 1.0)),
}  # fmt: skip
TRAVELLING = {  # exponential times of mean 20, cut off after one mean
    "travel_times": Statistic(
        lambda d: waiting(an.travel_times(d, distance=1.0, direction=(1.0, 0.0, 0.0)).summary(horizon=HORIZON)),
        [20.0, 20.0 * (1.0 - np.exp(-HORIZON / 20.0)), 20.0 * (1.0 - 1.0 / np.expm1(1.0))]),
}  # fmt: skip


def crowd(*kinds: Kind) -> Experiment:
    many = Crowd(kinds, LAST_TIME, n_swimmers=200)
    return Experiment(many.draw, many.n_swimmers, of_encounters(many))


def few(*kinds: Kind) -> Experiment:
    """25 swimmers with some 65 encounters and 25 hops: too few for shares of links, of which some do not occur."""
    some = Crowd(kinds, LAST_TIME, n_swimmers=25)
    known = {name: replace(each, rate=0.93) for name, each in of_encounters(some).items() if name not in NETWORKS}
    return Experiment(some.draw, some.n_swimmers, known)


def rarely_passing() -> Experiment:
    """Escape pitches passed in 7 of 100 encounters: the mean is taken up to a horizon that it has to find."""
    kinds = (Kind(escape=0.1, capture=0.5, passage=passage, turns=1.0, contact=0.2, bonds=(0.2,) * 5)
             for passage in (0.005, 0.01))  # fmt: skip
    many = Crowd(tuple(kinds), 5.0 * LAST_TIME, n_swimmers=200)
    true = many.expected.at_risk("waiting")

    def excess(data: tuple) -> tuple[np.ndarray, np.ndarray]:
        found = an.escape_pitch_times(data[0])
        difference = found.restricted_mean - true.restricted_mean(found.horizon)
        return np.array([difference]), np.array([found.restricted_standard_error])

    return Experiment(many.draw, many.n_swimmers, {"escape_pitch_times": Statistic(excess, [0.0])})


def walk(draw: Callable, statistics: dict[str, Statistic], **numbers: float) -> Experiment:
    return Experiment(lambda rng: draw(rng, n_swimmers=100, **numbers), 100, statistics)


EXPERIMENTS = {
    "one-kind": crowd(FAST, FAST),
    "two-kinds": crowd(SLOW, FAST),
    "few": few(SLOW, FAST),
    "rarely-passing": rarely_passing(),
    "persistent": walk(walks.persistent, PERSISTENT, n_frames=41, turning=0.6, diffusivity=0.2),
    "brownian": walk(walks.brownian, BROWNIAN, n_frames=41, dimensions=2, diffusivity=0.5),
    "mixed": walk(walks.of_two_diffusivities, MIXED, n_frames=41),
    "lingering": walk(walks.lingering, LINGERING, n_frames=21),
    "travelling": walk(walks.travellers, TRAVELLING, n_frames=21, mean=20.0),
}


@cache
def coverage(experiment: str) -> dict[str, np.ndarray]:
    """Of all statistics of an experiment at once, as they share its draws."""
    return EXPERIMENTS[experiment].coverage(repeats=REPEATS)


@pytest.mark.parametrize(
    ("experiment", "statistic"),
    [(name, statistic) for name, experiment in EXPERIMENTS.items() for statistic in experiment.statistics],
)
def test_intervals_of_95_percent_cover_the_truth_at_their_rate(experiment: str, statistic: str) -> None:
    share, rate = coverage(experiment)[statistic], EXPERIMENTS[experiment].statistics[statistic].rate
    assert within(share, rate, repeats=REPEATS).all(), share

"""Whether lifetimes agree with a law that was not fitted to them, such as a prediction of `theory`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from porous_swim.analysis.estimates import Estimate, Swimmers, ratio_of_sums
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes


@dataclass(frozen=True)
class LogRank:
    """Ends seen against ends that the law expects of the same samples, watched for as long as they were."""

    observed: int
    expected: float
    ratio: Estimate
    """observed/expected: above 1 where ends come sooner than by the law. Error: jackknife over swimmers."""
    p_value: float
    """Two-sided, for a ratio of 1; normal in the error over swimmers."""


def one_sample_log_rank(lifetimes: Lifetimes, survival: Callable[[np.ndarray], np.ndarray]) -> LogRank:
    """Compare with `survival`, which gives the law's probability to outlast each of times (n,), in a/U.

    The law expects -log S(length) ends of a sample, censored or not. Only samples whose start was seen count.
    Source: Breslow, Int. Stat. Rev. 43, 45 (1975).
    """
    seen = lifetimes.select(lifetimes.start_seen)
    with np.errstate(divide="ignore"):  # a sample outlasted the law: infinitely many ends expected
        expected = -np.log(survival(seen.length))
    swimmers = Swimmers.of(seen.swimmer)
    per_swimmer, expected_per_swimmer = swimmers.sums(seen.ended), swimmers.sums(expected)
    ratio, error = ratio_of_sums(per_swimmer, expected_per_swimmer)
    # Under the law observed - expected has mean 0 for each swimmer, whatever cut it off (a martingale).
    spread = math.sqrt(float(np.sum((per_swimmer - expected_per_swimmer) ** 2)))
    difference = float(np.sum(per_swimmer) - np.sum(expected_per_swimmer))
    p_value = 2.0 * float(ndtr(-abs(difference) / spread)) if spread > 0.0 else math.nan
    n = int(np.count_nonzero(seen.ended))
    return LogRank(n, float(np.sum(expected)), Estimate(ratio, error, n, len(seen) - n, ""), p_value)

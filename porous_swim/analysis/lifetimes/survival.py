"""How long until something ends, when some ends were not seen. Times in a/U."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from porous_swim.analysis.estimates import Estimate, Swimmers, ratio_of_sums

_NEAR_ZERO = 0.02  # survival at an end that the data chose: below, the error of the area is right to 5 %


@dataclass(frozen=True)
class SurvivalCurve:
    """The Kaplan-Meier estimate of the probability to last longer than a time: a step function from 1.

    Source: Kaplan and Meier, J. Am. Stat. Assoc. 53, 457 (1958).
    """

    time: np.ndarray  # (n_times,) a/U, where ends were seen, increasing
    probability: np.ndarray  # (n_times,) from `time` on, up to the next
    n_at_risk: np.ndarray  # (n_times,) samples that lasted to `time`
    n_ended: np.ndarray  # (n_times,) samples that ended at `time`
    longest: float
    """The longest time seen, a/U: unless all had ended by then nothing is known beyond. NaN without samples."""

    def at(self, time: np.ndarray) -> np.ndarray:
        """The probability to last longer than each of the times (n,), a/U; NaN beyond what was seen."""
        found = np.append(1.0, self.probability)[np.searchsorted(self.time, time, side="right")]
        return np.where(self.known(time), found, math.nan)

    def known(self, time: np.ndarray | float) -> np.ndarray:
        """Whether the probability at each of the times (n,), a/U, is known, (n,) bool."""
        all_ended = len(self.probability) > 0 and self.probability[-1] == 0.0
        return (np.asarray(time) <= self.longest) | all_ended


@dataclass(frozen=True)
class WaitingTimes:
    """Summary of waiting times, some of them censored (their end was not seen). Times in a/U."""

    mean: float
    """Total time waited / ends seen: the maximum-likelihood mean for a constant rate of ending."""
    standard_error: float
    """Of `mean`: jackknife over swimmers."""
    n: int
    """Ends seen."""
    n_censored: int
    """Samples whose end was not seen."""
    restricted_mean: float
    """Mean of min(time, horizon), free of assumptions: the area under the survival curve up to `horizon`."""
    restricted_standard_error: float
    """Of `restricted_mean`: infinitesimal jackknife over swimmers. NaN where no end was seen, and where the data chose
    the horizon and more than 2 % last that long: another run would have another horizon."""
    horizon: float
    """Where the survival curve is cut."""
    mean_completed: float
    """Mean of the completed ones alone: biased towards short ones; for comparison."""
    completed_standard_error: float
    """Of `mean_completed`: jackknife over swimmers."""
    restricted_warning: str | None = None
    """Why `restricted_mean` is not to be trusted."""

    def estimate(self) -> Estimate:
        """`mean` with its error and counts."""
        return Estimate(self.mean, self.standard_error, self.n, self.n_censored, "a/U")

    def completed_estimate(self) -> Estimate:
        """`mean_completed` with its error and counts."""
        counts = self.n, self.n_censored
        return Estimate(self.mean_completed, self.completed_standard_error, *counts, "a/U")

    def restricted_estimate(self) -> Estimate:
        """`restricted_mean` with its error and counts."""
        counts = self.n, self.n_censored
        return Estimate(
            self.restricted_mean, self.restricted_standard_error, *counts, "a/U", warning=self.restricted_warning
        )


def survival_curve(length: np.ndarray, *, ended: np.ndarray) -> SurvivalCurve:
    """Kaplan-Meier curve of lengths (n,), where `ended` (n,) says whether the end was seen."""
    time, n_ended = np.unique(length[ended], return_counts=True)
    ended_before = np.cumsum(n_ended) - n_ended
    cut_before = np.searchsorted(np.sort(length[~ended]), time, side="left")
    n_at_risk = len(length) - ended_before - cut_before
    longest = float(np.max(length)) if len(length) else math.nan
    return SurvivalCurve(time, np.cumprod(1.0 - n_ended / n_at_risk), n_at_risk, n_ended, longest)


def waiting_times(
    length: np.ndarray,
    *,
    ended: np.ndarray,
    swimmer: np.ndarray,
    start_seen: np.ndarray | None = None,
    horizon: float | None = None,
    follow_up: float | None = None,
) -> WaitingTimes:
    """Summarise lengths (n,), of which `ended` and `start_seen` (n,) say what was seen.

    Lengths without a seen start count in `mean` and stay out of the survival curve and `mean_completed`.
    `horizon` defaults to the longest length seen where at most 2 % last that long, else to `follow_up`, to which
    samples could be followed however long they last. A later one than the longest length is cut back to that, beyond
    which nothing is known, unless the curve has reached zero. Where the horizon is the longest length and more than
    2 % last that long, there is no error: the data chose it.
    """
    swimmers = Swimmers.of(swimmer)
    mean, standard_error = ratio_of_sums(swimmers.sums(length), swimmers.sums(ended))
    whole = np.ones(len(length), bool) if start_seen is None else start_seen
    completed = ended & whole
    mean_completed, completed_error = ratio_of_sums(
        swimmers.sums(np.where(completed, length, 0.0)), swimmers.sums(completed)
    )
    del swimmers  # there may be 10^8 rows
    known = (length, ended, swimmer) if whole.all() else (length[whole], ended[whole], swimmer[whole])
    restricted, restricted_error, horizon, warning = _restricted_mean(*known, horizon=horizon, follow_up=follow_up)
    return WaitingTimes(
        mean=mean,
        standard_error=standard_error,
        n=int(np.count_nonzero(ended)),
        n_censored=int(np.count_nonzero(~ended)),
        restricted_mean=restricted,
        restricted_standard_error=restricted_error,
        horizon=horizon,
        mean_completed=mean_completed,
        completed_standard_error=completed_error,
        restricted_warning=warning,
    )


def _end_of_mean(curve: SurvivalCurve, *, horizon: float | None, follow_up: float | None) -> tuple[float, str | None]:
    """Where the area under the curve ends, and why there is no error of it."""
    left = _share_left(curve)
    wanted = follow_up if horizon is None and left > _NEAR_ZERO else horizon
    end = curve.longest if wanted is None or not curve.known(wanted) else wanted
    if len(curve.time) == 0 or curve.time[0] > end:
        return end, f"No end was seen up to {end:.4g} a/U: the value is that limit itself, a lower bound of the mean."
    if end == wanted or left <= _NEAR_ZERO:
        return end, None
    return end, (
        f"The mean goes up to the longest time seen, {end:.4g} a/U, which {100.0 * left:.2g} % reach: another run "
        "would have another limit, so there is no error."
    )


def _share_left(curve: SurvivalCurve) -> float:
    """Probability to last as long as the longest, 0 where nothing was cut off: whether that one ended is chance."""
    n_ended, n = int(np.sum(curve.n_ended)), int(curve.n_at_risk[0]) if len(curve.n_at_risk) else 0
    if n_ended == n > 0:
        return 0.0
    before = len(curve.time) - int(n > 0 and curve.time[-1] == curve.longest)  # ends before the longest time
    return float(curve.probability[before - 1]) if before else 1.0


def _restricted_mean(
    length: np.ndarray, ended: np.ndarray, swimmer: np.ndarray, *, horizon: float | None, follow_up: float | None
) -> tuple[float, float, float, str | None]:
    """Area under the survival curve up to the horizon, its error over swimmers, the horizon, and a warning."""
    if len(length) == 0:
        return math.nan, math.nan, math.nan if horizon is None else horizon, None
    curve = survival_curve(length, ended=ended)
    horizon, warning = _end_of_mean(curve, horizon=horizon, follow_up=follow_up)
    n_used = int(np.searchsorted(curve.time, horizon, side="left"))
    time, n_ended, n_at_risk = (values[:n_used] for values in (curve.time, curve.n_ended, curve.n_at_risk))
    steps = np.diff(np.concatenate([[0.0], time, [horizon]]))
    steps *= np.concatenate([[1.0], curve.probability[:n_used]])
    mean = float(np.sum(steps))

    # Influence of each sample: derivative of the area by the sample's weight. With M_j the area beyond
    # time j, d log S = -(ended - at_risk n_j/r_j)/(r_j - n_j); summed per swimmer it is an infinitesimal
    # jackknife (Jaeckel 1972) for groups, since all samples of one swimmer change weight together.
    weight = mean - np.cumsum(steps)[:-1]  # the area beyond
    left = n_at_risk - n_ended
    np.divide(weight, left, out=weight, where=left > 0)
    weight[left == 0] = 0.0  # none left: no area beyond
    del steps, left  # there may be 10^8 of each
    last = np.searchsorted(time, length, side="right")  # ends at or before each length
    exposure = np.concatenate([[0.0], np.cumsum(weight * n_ended / n_at_risk)])[last]
    last = np.maximum(last - 1, 0)
    exposure -= np.where(ended & (length < horizon), np.append(weight, 0.0)[last], 0.0)
    del last
    swimmers = Swimmers.of(swimmer)
    influence = swimmers.sums(exposure)
    if swimmers.n < 2 or warning is not None:
        return mean, math.nan, horizon, warning
    return mean, math.sqrt(swimmers.n / (swimmers.n - 1) * float(np.sum(influence**2))), horizon, None

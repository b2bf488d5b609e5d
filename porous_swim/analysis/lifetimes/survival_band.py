"""How sure a survival curve is. Times in the unit of the curve."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from porous_swim.analysis.estimates import Swimmers
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.survival import SurvivalCurve


@dataclass(frozen=True, eq=False)
class SurvivalBand:
    """Pointwise confidence limits of a survival curve; NaN where the curve has reached 0.

    Each holds from its time on, up to the next, and the last up to `longest`: nothing is known beyond.
    """

    time: np.ndarray  # (n_times,) those of the curve
    lower: np.ndarray  # (n_times,)
    upper: np.ndarray  # (n_times,)
    standard_error: np.ndarray  # (n_times,) Greenwood's
    level: float  # coverage at each time
    longest: float  # that of the curve


def survival_band(curve: SurvivalCurve, *, level: float = 0.95) -> SurvivalBand:
    """Limits symmetric in log(-log S), which keeps them between 0 and 1, with Greenwood's variance.

    They take the samples for independent; `survival_at` does not. Source: Kalbfleisch and Prentice, The
    Statistical Analysis of Failure Time Data, 2nd ed. (2002).
    """
    left = curve.n_at_risk - curve.n_ended
    terms = np.divide(curve.n_ended, curve.n_at_risk * left, out=np.full(len(left), math.nan), where=left > 0)
    relative = np.sqrt(np.cumsum(terms))
    probability = np.where(left > 0, curve.probability, math.nan)
    power = np.exp(float(ndtri(0.5 + 0.5 * level)) * relative / np.abs(np.log(probability)))
    limits = probability**power, probability ** (1.0 / power)
    return SurvivalBand(curve.time, *limits, probability * relative, level, curve.longest)


def survival_at(lifetimes: Lifetimes, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Survival probability at times (m,), and its standard error over swimmers (m,).

    The error is an infinitesimal jackknife in which all lifetimes of one swimmer change weight together, so
    that it holds where they are alike. The error is NaN from where the curve is 0, and for a single swimmer; both are
    beyond the longest time seen, unless all had ended by then.
    """
    seen = lifetimes.select(lifetimes.start_seen)
    curve, swimmers = seen.survival(), Swimmers.of(seen.swimmer)
    left = curve.n_at_risk - curve.n_ended
    hazard = np.divide(1.0, left, out=np.full(len(left), math.nan), where=left > 0)
    exposure = np.concatenate([[0.0], np.cumsum(hazard * curve.n_ended / curve.n_at_risk)])
    last = np.searchsorted(curve.time, seen.length, side="right")  # ends at or before each length
    probability, error = np.ones(len(at)), np.full(len(at), math.nan)
    for i, n_before in enumerate(np.searchsorted(curve.time, at, side="right")):
        if n_before:
            probability[i] = curve.probability[n_before - 1]
        if swimmers.n > 1:
            own = np.where(seen.ended & (last <= n_before), np.append(hazard, 0.0)[np.maximum(last - 1, 0)], 0.0)
            influence = swimmers.sums(exposure[np.minimum(last, n_before)] - own)
            error[i] = probability[i] * math.sqrt(swimmers.n / (swimmers.n - 1) * float(np.sum(influence**2)))
    known = curve.known(at)
    return np.where(known, probability, math.nan), np.where(known, error, math.nan)

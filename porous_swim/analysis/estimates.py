"""Numbers with their errors. The swimmers are the independent samples: one swimmer's encounters are not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from porous_swim.analysis.columns import numbered

NONE = "–"  # in place of a number that there is none of


@dataclass(frozen=True)
class Estimate:
    """A statistic with one standard error; NaN stands for a value or error that there is none of."""

    value: float
    standard_error: float
    n: int  # samples that it rests on
    n_censored: int  # samples of which only a part was seen
    unit: str  # "" for a pure number
    warning: str | None = None  # one sentence: why the value is not to be trusted

    @classmethod
    def none(cls, unit: str) -> Estimate:
        """A statistic that there is none of."""
        return cls(math.nan, math.nan, 0, 0, unit)

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON: what is not finite becomes null; `warning` is there where there is one."""
        found = {
            "value": _finite_or_none(self.value),
            "standard_error": _finite_or_none(self.standard_error),
            "n": self.n,
            "n_censored": self.n_censored,
            "unit": self.unit,
        }
        return found if self.warning is None else {**found, "warning": self.warning}


def value_and_error(value: float, error: float | None, *, digits: int = 4) -> str:
    """`39.41 ± 0.14`: two digits of the error, and the value to the same place; without an error so many `digits`."""
    if not math.isfinite(value):
        return NONE
    if error is None or not math.isfinite(error):
        return f"{value:.{digits}g}"
    if error == 0.0:
        return f"{value:.6g}"  # all samples agree: they do not tell how far they are off
    place = 1 - math.floor(math.log10(error))
    if 0 <= place <= 6:
        return f"{value:.{place}f} ± {error:.{place}f}"
    power = math.floor(math.log10(max(abs(value), error)))
    if -3 < power < 6:
        return f"{round(value, place):.{max(place, 0)}f} ± {round(error, place):.{max(place, 0)}f}"
    digits = max(place + power, 0)
    return f"({value / 10.0**power:.{digits}f} ± {error / 10.0**power:.{digits}f})e{power:+03d}"


def _finite_or_none(number: float) -> float | None:
    return float(number) if math.isfinite(number) else None


@dataclass(frozen=True)
class Swimmers:
    """Which rows of a table belong together: the swimmers that occur in it, numbered without gaps."""

    group: np.ndarray  # (n_rows,) int, number of the row's swimmer among those that occur
    n: int  # swimmers that occur

    @classmethod
    def of(cls, swimmer: np.ndarray) -> Swimmers:
        """From the column `swimmer` of a table, shape (n_rows,)."""
        occurring, group = numbered(swimmer)
        return cls(group, len(occurring))

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sum of `values` (n_rows,) over each swimmer's rows: (n,)."""
        return np.bincount(self.group, weights=values, minlength=self.n)


def joined(parts: Iterable[Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Arrays of each name one behind the other: sums over swimmers, of tables without a swimmer in common."""
    every = list(parts)
    return {name: np.concatenate([part[name] for part in every]) for name in every[0]}


def ratio_of_sums(numerator: np.ndarray, denominator: np.ndarray) -> tuple[float, float]:
    """Ratio of two totals and its delete-one jackknife error.

    Both arrays, (n_groups,), are sums over independent groups (swimmers). The ratio is NaN where the
    denominator vanishes; the error is NaN for fewer than two groups and where one group alone has all of
    the denominator. Source: Efron and Stein, Ann. Stat. 9, 586 (1981).
    """
    total_numerator, total_denominator = float(np.sum(numerator)), float(np.sum(denominator))
    if total_denominator == 0.0:
        return math.nan, math.nan
    n = len(numerator)
    rest = total_denominator - denominator
    if n < 2 or np.any(rest == 0.0):
        return total_numerator / total_denominator, math.nan
    left_one_out = (total_numerator - numerator) / rest
    return total_numerator / total_denominator, math.sqrt((n - 1) * float(np.var(left_one_out)))


def mean_over_swimmers(sums: np.ndarray, *, n_swimmers: int) -> tuple[float, float]:
    """Mean of a quantity per swimmer and its standard error.

    `sums` has one value for each swimmer that occurs; the others up to `n_swimmers` count as 0.
    """
    if n_swimmers == 0:
        return math.nan, math.nan
    mean = float(np.sum(sums)) / n_swimmers
    if n_swimmers < 2:
        return mean, math.nan
    squares = float(np.sum((sums - mean) ** 2)) + (n_swimmers - len(sums)) * mean**2
    return mean, math.sqrt(squares / ((n_swimmers - 1) * n_swimmers))

"""Estimates with errors, and whether two of them agree."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from porous_swim.analysis.columns import column
from porous_swim.analysis.estimates import Estimate

REFERENCE = Path(__file__).parents[1] / "reference"
STANDARD_ERRORS = 4.0  # allowed: one false alarm in 16 000 comparisons


@dataclass(frozen=True)
class Figure:
    """A number and its standard error."""

    value: float
    standard_error: float = 0.0

    def __sub__(self, other: Figure) -> Figure:
        return Figure(self.value - other.value, math.hypot(self.standard_error, other.standard_error))

    def __str__(self) -> str:
        return f"{self.value:.6g} +- {self.standard_error:.2g}"


def reference(name: str) -> Any:
    """The content of a file of independent values."""
    return json.loads((REFERENCE / name).read_text(encoding="utf-8"))


def sizes(reduced: int, full: int) -> pytest.MarkDecorator:
    """Run a test with `reduced` swimmers, and with `full` ones where slow tests are wanted."""
    slow = pytest.param(full, id="full", marks=pytest.mark.slow)
    return pytest.mark.parametrize("count", [pytest.param(reduced, id="reduced"), slow])


def require_agreement(ours: dict[str, Figure], theirs: dict[str, Figure], *, bias: float = 0.0) -> None:
    """Print both sides, and fail where they differ by more than 4 combined standard errors and `bias`.

    `bias` is relative to `theirs`.
    """
    apart = []
    for name, mine in ours.items():
        difference, other = mine - theirs[name], theirs[name]
        in_errors = difference.value / difference.standard_error
        line = f"{name}: {mine} against {other}, {in_errors:+.2f} standard errors"
        print(line)
        # so put that a NaN fails
        if not abs(difference.value) <= STANDARD_ERRORS * difference.standard_error + bias * abs(other.value):
            apart.append(line)
    assert not apart, apart


def figure(estimate: Estimate) -> Figure:
    """The figure of an estimate."""
    return Figure(estimate.value, estimate.standard_error)


def mean(values: np.ndarray) -> Figure:
    """Mean of independent samples."""
    return Figure(float(np.mean(values)), float(np.std(values, ddof=1)) / math.sqrt(len(values)))


def share(p: float, n: int) -> Figure:
    """A share of `n` independent samples."""
    return Figure(p, math.sqrt(p * (1.0 - p) / n))


def rate(encounters: pa.Table, chosen: np.ndarray, *, count: int, duration: float) -> Figure:
    """Chosen rows (n_encounters,) per swimmer and time; each of the `count` swimmers is one sample."""
    return mean(np.bincount(column(encounters, "swimmer")[chosen], minlength=count) / duration)

"""What a reproduced figure consists of: data, a picture, and rows of ours against theirs."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

AGREES, DIFFERS, REPORTED = "agrees", "DIFFERS", "reported"
_PRINTED = re.compile(r"(about )?(-?\d+(?:\.(\d+))?(?:/\d+)?)")
_ROUNDING = 1e-3  # of a number without noise: how near two programs, or a number that is exact, are expected to be


@dataclass(frozen=True)
class Row:
    """One number: the paper's text or caption, ours, and that of an independent simulator of the same model."""

    quantity: str
    ours: float
    standard_error: float = 0.0  # 0: without noise
    paper: str = ""
    independent: float | None = None
    independent_error: float = 0.0
    digit: float = 0.0  # a unit of the last digit to which the independent value is known

    @property
    def tolerance(self) -> float | None:
        """Largest difference that agrees: 4 combined standard errors, else 0.1 % or a unit of the last digit."""
        if self.independent is None:
            return None
        if self.standard_error or self.independent_error:
            return 4.0 * math.hypot(self.standard_error, self.independent_error)
        return max(_ROUNDING * abs(self.independent), self.digit)

    @property
    def paper_verdict(self) -> str:
        """Whether ours agrees with the number that the paper prints; nothing where it prints none.

        To agree means within what the paper rounds away, 0.1 % and 4 standard errors of ours: of its own errors it says
        nothing.
        """
        found = printed(self.paper)
        if found is None:
            return ""
        value, rounded = found
        allowed = max(rounded, _ROUNDING * abs(value)) + 4.0 * self.standard_error
        return AGREES if abs(self.ours - value) <= allowed else DIFFERS

    @property
    def verdict(self) -> str:
        """Whether ours agrees with the independent value; without one it is only reported."""
        if self.independent is None or self.tolerance is None:
            return REPORTED
        return AGREES if abs(self.ours - self.independent) <= self.tolerance else DIFFERS

    def cells(self) -> list[str]:
        """For a table: what stands below `HEADER`."""
        ours = f"{self.ours:.5g}" + (f" ± {self.standard_error:.2g}" if self.standard_error else "")
        other = "" if self.independent is None else f"{self.independent:.6g}"
        other += f" ± {self.independent_error:.2g}" if self.independent_error else ""
        return [self.quantity, self.paper, ours, other, self.paper_verdict, self.verdict]


HEADER = ["quantity", "paper", "ours", "independent", "against the paper", "against the independent"]


def printed(text: str) -> tuple[float, float] | None:
    """The number that a text begins with, and how far off its rounding may be; None where there is none.

    Half a unit of the last digit, a whole one after `about`; a fraction such as `1/5` is exact.
    """
    match = _PRINTED.match(text)
    if match is None:
        return None
    about, number, decimals = match.groups()
    if "/" in number:
        return float(Fraction(number)), 0.0
    unit = 10.0 ** -len(decimals or "")
    return float(number), unit if about else 0.5 * unit


@dataclass(frozen=True, eq=False)
class Reproduction:
    """A figure made again."""

    tables: Mapping[str, Mapping[str, np.ndarray]]  # columns of one length, by name of the table
    rows: list[Row]
    draw: Callable[[], Picture]
    notes: list[str] = field(default_factory=list)

    def write(self, folder: Path, name: str) -> list[Path]:
        """Write `name-TABLE.csv`, `name.png` and `name.svg` into an existing folder; return the files."""
        paths = []
        for table, columns in self.tables.items():
            paths.append(folder / f"{name}-{table}.csv")
            _write_columns(paths[-1], columns)
        picture = self.draw()
        for ending in ("png", "svg"):
            paths.append(folder / f"{name}.{ending}")
            picture.savefig(paths[-1], dpi=150)
        return paths


def _write_columns(path: Path, columns: Mapping[str, np.ndarray]) -> None:
    data = np.stack([np.asarray(column, dtype=float) for column in columns.values()], axis=1)
    np.savetxt(path, data, delimiter=",", header=",".join(columns), comments="", fmt="%.10g")


def panels(n: int, *, in_line: int = 3, width: float = 4.2, height: float = 3.4) -> tuple[Picture, list[Any]]:
    """A picture with n panels, `in_line` of them side by side, that needs no display."""
    from matplotlib.figure import Figure

    n_columns = min(n, in_line)
    n_lines = -(-n // n_columns)
    picture = Figure(figsize=(width * n_columns, height * n_lines), layout="constrained")
    axes = np.atleast_1d(picture.subplots(n_lines, n_columns)).ravel()
    for unused in axes[n:]:
        unused.set_axis_off()
    return picture, list(axes[:n])


def disc(axis: Any, radius: float) -> None:
    """Draw a colloid at the origin."""
    from matplotlib.patches import Circle

    axis.add_patch(Circle((0.0, 0.0), radius, facecolor="0.85", edgecolor="0.4"))
    axis.set_aspect("equal")

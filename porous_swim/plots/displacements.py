"""Mean squared displacement, its exponent, and the window that gives the effective diffusivity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from porous_swim.analysis.transport.diffusion import EffectiveDiffusivity
from porous_swim.analysis.transport.lagged import TimeAverages
from porous_swim.analysis.transport.transport import Lagged
from porous_swim.plots.scales import Scales, label_x, label_y
from porous_swim.plots.style import THEORY, Shown, legend, panels


@dataclass(frozen=True, eq=False)
class Displacements:
    """Time-averaged displacements of a run."""

    squares: TimeAverages
    exponent: Lagged
    diffusivity: EffectiveDiffusivity
    dimensions: int
    free: np.ndarray | None = None  # (n_lags,) a^2, of a free swimmer at the lags of `squares`


def draw(shown: list[Shown[Displacements]], scales: Scales | None) -> Figure:
    """Two panels on logarithmic axes of lag: the displacement with its fit, and the exponent."""
    picture, (squares, exponent) = panels(2, in_line=2, width=4.9, height=3.7)
    for run in shown:
        name = run.label if len(shown) > 1 else "all swimmers"
        found = run.data.squares
        moved = found.value > 0.0
        squares.errorbar(
            found.lag[moved], found.value[moved], found.standard_error[moved], fmt="o", markersize=3.0,
            color=run.color, elinewidth=0.8, label=name,
        )  # fmt: skip
        if run.data.free is not None:
            squares.plot(found.lag, run.data.free, "--", color=THEORY, linewidth=1.0, label="free swimmer, exact")
        _fit(squares, run, name_it=len(shown) == 1)
        exponent.errorbar(
            run.data.exponent.lag, run.data.exponent.value, run.data.exponent.standard_error, fmt="o-", markersize=3.0,
            color=run.color, linewidth=0.8, elinewidth=0.8,
        )  # fmt: skip
    squares.set(xscale="log", yscale="log")
    for value, what in ((2.0, "straight"), (1.0, "diffusive")):
        exponent.axhline(value, color="0.5", linewidth=0.8, linestyle="--")
        exponent.text(0.02, value + 0.04, what, transform=exponent.get_yaxis_transform(), color="0.4", fontsize=8.0)
    exponent.set(xscale="log", ylabel="exponent", ylim=_limits(shown))
    label_y(squares, "mean squared displacement", "a^2", scales)
    for axis in (squares, exponent):
        label_x(axis, "lag", "a/U", scales)
    legend(squares, loc="upper left")
    return picture


def _fit(axis: Any, run: Shown[Displacements], *, name_it: bool) -> None:
    fit = run.data.diffusivity
    if not np.isfinite(fit.value):
        return
    lag = np.geomspace(*fit.window, 50)
    line = fit.offset + 2.0 * run.data.dimensions * fit.value * lag
    shown = line > 0.0
    name = "fit: effective diffusivity" if name_it else None
    axis.axvspan(*fit.window, color=run.color, alpha=0.08, linewidth=0)
    axis.plot(lag[shown], line[shown], color=run.color, linewidth=2.0, alpha=0.6, label=name)


def _limits(shown: list[Shown[Displacements]]) -> tuple[float, float]:
    values = np.concatenate([run.data.exponent.value for run in shown] + [np.array([0.0, 2.0])])
    known = values[np.isfinite(values)]
    return max(float(known.min()), -1.0) - 0.1, min(float(known.max()), 3.0) + 0.3

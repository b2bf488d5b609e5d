"""How far swimmers wind around colloids."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from porous_swim.analysis.histogram import Histogram
from porous_swim.analysis.orbits import Orbits
from porous_swim.plots.style import Shown, legend, panels


def draw(shown: list[Shown[Orbits]]) -> Figure:
    """Distributions of unsigned and, in two dimensions, of signed winding."""
    signed = any(run.data.signed_winding.n > 0 for run in shown)
    picture, axes = panels(2 if signed else 1, in_line=2, width=4.9)
    for run in shown:
        bars(axes[0], run.data.winding, color=run.color, label=run.label if len(shown) > 1 else None)
        if signed and run.data.signed_winding.n > 0:
            bars(axes[1], run.data.signed_winding, color=run.color)
    axes[0].set(xlabel="winding (turns)", ylabel="share of completed encounters")
    logarithmic(axes[0], [run.data.winding for run in shown])
    legend(axes[0])
    if signed:
        axes[1].axvline(0.0, color="0.6", linewidth=0.8)
        axes[1].set(xlabel="net winding, counterclockwise (turns)", ylabel="share of completed encounters")
    return picture


def logarithmic(axis: Any, every: list[Histogram]) -> None:
    """A logarithmic axis from half of the least share on, as errors may reach down to nothing."""
    least = min((1.0 / found.n for found in every if found.n), default=1.0)
    axis.set(yscale="log", ylim=(0.5 * least, 1.3))


def bars(axis: Any, found: Histogram, *, color: str, label: str | None = None) -> None:
    """A distribution as a step line: the share of all samples in each bin, with one standard error."""
    width = np.diff(found.edges)
    share, error = found.density * width, found.standard_error * width
    axis.stairs(share, found.edges, color=color, linewidth=1.3, label=label, baseline=None)
    axis.stairs(share, found.edges, color=color, alpha=0.15, fill=True, baseline=0.0)
    filled = (found.count > 0) & np.isfinite(error)
    middle = 0.5 * (found.edges[1:] + found.edges[:-1])
    axis.errorbar(middle[filled], share[filled], error[filled], fmt="none", ecolor=color, elinewidth=0.8)

"""How long swimmers remember their direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from porous_swim.analysis.transport.lagged import TimeAverages
from porous_swim.plots.scales import Scales, label_x
from porous_swim.plots.style import THEORY, Shown, legend, panels


@dataclass(frozen=True, eq=False)
class Directors:
    """Correlation of directors of a run."""

    correlation: TimeAverages
    free: np.ndarray | None  # (n_lags,) of a free swimmer with the same noise; None where the noise is not known


def draw(shown: list[Shown[Directors]], scales: Scales | None) -> Figure:
    """Correlation against lag with one standard error, and what noise alone would leave of it."""
    picture, (axis,) = panels(1, width=7.0)
    for run in shown:
        found = run.data.correlation
        axis.errorbar(
            found.lag, found.value, found.standard_error, fmt="o-", markersize=3.0, color=run.color, linewidth=0.9,
            elinewidth=0.8, label=run.label if len(shown) > 1 else "all starts, over swimmers",
        )  # fmt: skip
        if run.data.free is not None:
            color = run.color if len(shown) > 1 else THEORY
            label = None if len(shown) > 1 else "by noise alone"
            axis.plot(found.lag, run.data.free, "--", color=color, linewidth=1.0, label=label)
    axis.axhline(0.0, color="0.5", linewidth=0.8)
    axis.set(ylabel=r"$\langle \mathbf{e}(t + \mathrm{lag}) \cdot \mathbf{e}(t) \rangle$", xscale="log")
    label_x(axis, "lag", "a/U", scales)
    legend(axis)
    return picture

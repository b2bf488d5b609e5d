"""Fractions of swimmers that are bound and in contact over time."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from matplotlib.figure import Figure

from porous_swim.analysis.columns import column
from porous_swim.plots.scales import Scales, label_x
from porous_swim.plots.style import Shown, legend, panels, thinned
from porous_swim.results.tables import TableInfo


def draw(shown: list[Shown[pa.Table]], scales: Scales | None) -> Figure:
    """Time series with bands of one binomial standard error: the swimmers are independent."""
    picture, (axis,) = panels(1, width=7.0)
    for run in shown:
        chosen = thinned(len(run.data))
        time, n = column(run.data, "time")[chosen], TableInfo.of(run.data).n_swimmers
        for name, style, what in (("fraction_bound", "-", "bound"), ("fraction_contact", "--", "in contact")):
            fraction = column(run.data, name)[chosen]
            error = np.sqrt(fraction * (1.0 - fraction) / max(n - 1, 1))
            label = f"{run.label}, {what}" if len(shown) > 1 else what
            axis.plot(time, fraction, style, color=run.color, linewidth=1.2, label=label)
            axis.fill_between(time, fraction - error, fraction + error, color=run.color, alpha=0.15, linewidth=0)
    axis.set(ylim=(-0.02, 1.02), ylabel="fraction of swimmers")
    label_x(axis, "time", "a/U", scales)
    beside = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}  # several runs leave no room inside
    legend(axis, **(beside if len(shown) > 1 else {}))
    return picture

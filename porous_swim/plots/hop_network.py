"""The network of hops over the colloids."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from porous_swim.analysis.columns import column, vectors
from porous_swim.analysis.places import centers_of, radii_of
from porous_swim.plots.colloids import colloid_discs
from porous_swim.plots.scales import Scales, label_x, label_y
from porous_swim.plots.style import MAP_COLORS, Shown, color_bar, name_panels, panels

_WIDEST, _MANY = 5.0, 6.0  # points, for the most hops; and for as many at least
_MOST_LINES = 2000  # as such in an SVG; more go in as one picture


@dataclass(frozen=True, eq=False)
class Network:
    """Links of `hop_network` and the colloids that they join."""

    links: pa.Table
    colloids: pa.Table
    box: tuple[float, float, float]


def draw(shown: list[Shown[Network]], scales: Scales | None) -> Figure:
    """Runs side by side. Each half of a bond is as wide as the hops are many that leave its end; seen along z."""
    picture, axes = panels(len(shown), in_line=2, width=5.6, height=4.8, square=True)
    for axis, run in zip(axes, shown, strict=True):
        centers = centers_of(run.data.colloids)[:, :2]
        colloid_discs(axis, centers, radii_of(run.data.colloids), alpha=0.6)
        count = column(run.data.links, "n_hops").astype(float)
        start = centers[column(run.data.links, "from_colloid")]
        half = 0.5 * vectors(run.data.links, "bond_x", "bond_y")
        order = np.argsort(count)  # the busiest on top
        lines = LineCollection(
            list(np.stack([start, start + half], axis=1)[order]),
            linewidths=_WIDEST * count[order] / max(float(count.max()), _MANY),
            cmap=MAP_COLORS, capstyle="butt", zorder=2.0,
            rasterized=len(count) > _MOST_LINES,
        )  # fmt: skip
        lines.set_array(count[order])
        lines.set_clim(0.0, float(count.max()))
        axis.add_collection(lines)
        axis.autoscale_view()
        _frame(axis, run.data.box)
        color_bar(picture, lines, axis, "hops", shrink=0.8, ticks=MaxNLocator(integer=True))
        label_x(axis, "x", "a", scales)
        label_y(axis, "y", "a", scales)
    name_panels(axes, shown)
    return picture


def _frame(axis: Any, box: tuple[float, float, float]) -> None:
    """The periodic box, where there is one."""
    if box[0] > 0.0 and box[1] > 0.0:
        axis.plot([0, box[0], box[0], 0, 0], [0, 0, box[1], box[1], 0], color="0.5", linewidth=0.6, linestyle=":")

"""Where swimmers are in height above the nearest colloid and in pitch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from porous_swim.analysis.histogram import Map
from porous_swim.plots.scales import Scales, label_y
from porous_swim.plots.style import MAP_COLORS, Shown, color_bar, legend, name_panels, panels


@dataclass(frozen=True, eq=False)
class HeightPitch:
    """A density and the height at which encounters end."""

    density: Map
    escape_height: float | None  # a


def draw(shown: list[Shown[HeightPitch]], scales: Scales | None) -> Figure:
    """Runs side by side: share of all recorded positions in each bin, on a logarithmic scale of colours."""
    picture, axes = panels(len(shown), in_line=2, width=5.4, height=4.0)
    for axis, run in zip(axes, shown, strict=True):
        found = run.data.density
        share = found.count / max(found.n, 1)
        axis.grid(visible=False)
        mesh = axis.pcolormesh(
            np.degrees(found.x_edges), found.y_edges, np.where(share > 0.0, share, np.nan).T,
            norm=LogNorm(1.0 / max(found.n, 1), max(float(share.max(initial=0.0)), 2.0 / max(found.n, 1))),
            cmap=MAP_COLORS, rasterized=True,
        )  # fmt: skip
        if run.data.escape_height is not None:
            axis.axhline(
                run.data.escape_height, color="0.3", linewidth=0.8, linestyle="--", label="where encounters end"
            )
            legend(axis, loc="upper center")
        axis.axvline(0.0, color="0.7", linewidth=0.6)
        axis.set(xlabel="pitch (degrees)", xticks=range(-90, 91, 30))
        occupied = np.flatnonzero(share.sum(axis=0) > 0.0)
        if len(occupied):
            axis.set_ylim(found.y_edges[occupied[0]] - 0.1, found.y_edges[occupied[-1] + 1] + 0.3)
        label_y(axis, "height above the nearest colloid", "a", scales)
        color_bar(picture, mesh, axis, "share of positions in a bin")
    name_panels(axes, shown)
    return picture

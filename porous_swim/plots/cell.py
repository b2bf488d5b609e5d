"""Where swimmers are in the cell of the lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from porous_swim.analysis.histogram import Map
from porous_swim.plots.scales import Scales, label_x, label_y
from porous_swim.plots.style import MAP_COLORS, Shown, color_bar, name_panels, panels

_DECADES = 1e4  # between the darkest and the brightest colour, at most


@dataclass(frozen=True, eq=False)
class Cell:
    """A density in a cell, and the colloids there."""

    density: Map
    centers: np.ndarray  # (n, 2) a, of all colloids and images that reach into the cell
    radii: np.ndarray  # (n,) a


def draw(shown: list[Shown[Cell]], scales: Scales | None) -> Figure:
    """Runs side by side: density over its mean in the cell."""
    from matplotlib.patches import Circle

    picture, axes = panels(len(shown), in_line=2, width=5.0, height=5.2, square=True)
    for axis, run in zip(axes, shown, strict=True):
        found = run.data.density
        width, height = (float(edges[-1] - edges[0]) for edges in (found.x_edges, found.y_edges))
        relative = np.where(found.count > 0, found.density, np.nan) * width * height
        most = float(np.nanmax(relative, initial=1.0))
        colors = LogNorm(max(float(np.nanmin(relative, initial=most)), most / _DECADES), most)
        mesh = axis.pcolormesh(found.x_edges, found.y_edges, relative.T, cmap=MAP_COLORS, norm=colors, rasterized=True)
        for center, radius in zip(run.data.centers, run.data.radii, strict=True):
            axis.add_patch(Circle((float(center[0]), float(center[1])), radius, fill=False, edgecolor="0.35"))
        axis.set(xlim=found.x_edges[[0, -1]], ylim=found.y_edges[[0, -1]])
        label_x(axis, "x in the cell", "a", scales)
        label_y(axis, "y in the cell", "a", scales)
        color_bar(picture, mesh, axis, "density over its mean", shrink=0.8)
    name_panels(axes, shown)
    return picture

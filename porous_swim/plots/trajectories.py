"""The medium, and the trajectories of some swimmers through it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from porous_swim.plots.colloids import colloid_discs, images_in
from porous_swim.plots.scales import Scales, label_x, label_y
from porous_swim.plots.style import STATE_COLORS, STATE_NAMES, Shown, legend, panels

_MOST_DISCS = 20000
_MARGIN = 0.06
_BEHIND = 0.22  # opacity of colloids that are seen through each other


@dataclass(frozen=True, eq=False)
class Trajectories:
    """Colloids, and swimmers at times."""

    centers: np.ndarray  # (n_colloids, 3) a
    radii: np.ndarray  # (n_colloids,) a
    box: tuple[float, float, float]  # a; 0 along an axis that does not repeat
    position: np.ndarray  # (n_frames, n_swimmers, 3) a, unwrapped
    state: np.ndarray  # (n_frames, n_swimmers) 0 free, 1 bound, 2 contact
    dimensions: int
    flat_normal: np.ndarray | None = None  # (3,) where the one colloid is flat: its centre is a point of the plane


def draw(shown: list[Shown[Trajectories]], scales: Scales | None) -> Figure:
    """Trajectories coloured by state, over the colloids and their images; in space seen along z and along y."""
    views = [(run, plane) for run in shown for plane in (((0, 1),) if run.data.dimensions == 2 else ((0, 1), (0, 2)))]
    picture, axes = panels(len(views), in_line=2, width=5.4, height=4.9, square=True)
    for axis, (run, plane) in zip(axes, views, strict=True):
        _panel(axis, run.data, plane)
        label_x(axis, "x", "a", scales)
        label_y(axis, "xyz"[plane[1]], "a", scales)
        if len(shown) > 1:
            axis.set_title(run.label)
    seen = sorted({int(state) for run in shown for state in np.unique(run.data.state)})
    handles = [Line2D([], [], color=STATE_COLORS[state], label=STATE_NAMES[state]) for state in seen]
    handles.append(Line2D([], [], color="black", marker="o", markersize=3.0, linestyle="", label="start"))
    legend(axes[0], handles=handles, loc="upper right")
    return picture


def _panel(axis: Any, trajectories: Trajectories, plane: tuple[int, int]) -> None:
    position = trajectories.position[:, :, plane]
    low, high = _view(trajectories, plane)
    box = trajectories.box[plane[0]], trajectories.box[plane[1]]
    centers, radii = trajectories.centers[:, plane], trajectories.radii
    if np.all(np.isfinite(radii)):
        centers, radii = images_in(centers, radii, box=box, low=low, high=high)
    if trajectories.flat_normal is not None:
        _flat(axis, centers[0], trajectories.flat_normal[list(plane)])
    elif len(radii) <= _MOST_DISCS:
        colloid_discs(axis, centers, radii, alpha=1.0 if trajectories.dimensions == 2 else _BEHIND)
    segments = np.stack([position[:-1], position[1:]], axis=2).reshape(-1, 2, 2)
    state = trajectories.state[1:].reshape(-1)
    for value, color in enumerate(STATE_COLORS):
        axis.add_collection(LineCollection(segments[state == value], colors=color, linewidths=1.2, zorder=2.0))
    axis.plot(position[0, :, 0], position[0, :, 1], "o", color="black", markersize=3.0, zorder=3.0)
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _flat(axis: Any, point: np.ndarray, normal: np.ndarray) -> None:
    """The line in which a plane is seen, where it is seen from its edge."""
    if np.hypot(*normal) > 1.0 - 1e-6:
        axis.axline(point, point + np.array([-normal[1], normal[0]]), color="0.45", linewidth=3.0, zorder=1.0)


def _view(shown: Trajectories, plane: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Corners of what is shown: all positions, and all colloids of a field that does not repeat; as wide as high."""
    points = shown.position[:, :, plane].reshape(-1, 2)
    if len(shown.centers) and np.all(np.isfinite(shown.radii)) and not any(shown.box[axis] > 0.0 for axis in plane):
        reach = shown.radii[:, None]
        points = np.concatenate([points, shown.centers[:, plane] - reach, shown.centers[:, plane] + reach])
    if len(points) == 0:
        points = np.array([[0.0, 0.0], [max(shown.box[axis], 1.0) for axis in plane]])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), (0.5 + _MARGIN) * max(float(np.max(high - low)), 1.0)
    return middle - half, middle + half

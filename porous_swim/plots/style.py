"""What all pictures share: panels, thin grids, and the colours of Okabe and Ito (2008), which all eyes tell apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from porous_swim.core.console import printable

RUN_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
STATE_COLORS = ("#56b4e9", "#b8a200", "#d55e00")  # free, bound, contact: the recording's, its yellow dark enough here
STATE_NAMES = ("free", "bound", "in contact")
MAP_COLORS = "viridis"
THEORY = "#404040"
TEXT_SIZE = 9.0
MOST_POINTS = 400  # of a curve: more would not be seen, and make a large file

Data = TypeVar("Data")


@dataclass(frozen=True, eq=False)
class Shown(Generic[Data]):
    """One run in a picture."""

    label: str
    """As matplotlib takes it: see `named`."""
    color: str
    data: Data


def named(label: str) -> str:
    """A name as matplotlib shows it as it stands: no dollar begins a formula, and no underscore hides it in legends."""
    text = printable(label).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def panels(
    n: int, *, in_line: int = 3, width: float = 4.2, height: float = 3.3, square: bool = False
) -> tuple[Figure, list[Any]]:
    """A picture with n panels, at most `in_line` side by side; `square` for maps, which have no grid."""
    n_columns = min(n, in_line)
    n_lines = -(-n // n_columns)
    with rc_context({"font.size": TEXT_SIZE, "axes.titlesize": TEXT_SIZE + 1.0, "axes.edgecolor": "0.4"}):
        picture = Figure(figsize=(width * n_columns, height * n_lines), layout="constrained")
        axes = np.atleast_1d(picture.subplots(n_lines, n_columns)).ravel()
    for unused in axes[n:]:
        unused.set_axis_off()
    for axis in axes[:n]:
        axis.set_axisbelow(True)
        if square:
            axis.set_aspect("equal")
        else:
            axis.grid(color="0.9", linewidth=0.6)
    return picture, list(axes[:n])


def legend(axis: Any, **where: Any) -> None:
    """A small legend, where anything has a name."""
    if "handles" in where or axis.get_legend_handles_labels()[0]:
        axis.legend(fontsize=TEXT_SIZE - 1.0, framealpha=0.85, edgecolor="none", **where)


def color_bar(picture: Figure, colored: Any, axis: Any, label: str, **more: Any) -> None:
    """What the colours of a map mean."""
    bar = picture.colorbar(colored, ax=axis, pad=0.02, **more)
    bar.set_label(label, fontsize=TEXT_SIZE)
    bar.ax.tick_params(labelsize=TEXT_SIZE)


def message(axis: Any, text: str) -> None:
    """Say in the middle of an empty panel why it is empty."""
    axis.set_axis_off()
    axis.text(0.5, 0.5, text, ha="center", va="center", wrap=True, transform=axis.transAxes, fontsize=TEXT_SIZE)


def thinned(n: int) -> np.ndarray:
    """Numbers of at most `MOST_POINTS` out of n points, the first and the last among them."""
    return np.unique(np.linspace(0, max(n - 1, 0), min(n, MOST_POINTS)).astype(int))


def thinned_tail(probability: np.ndarray) -> np.ndarray:
    """Numbers of at most `MOST_POINTS` points of a falling curve, evenly in its logarithm: a tail keeps every step."""
    positive = probability[probability > 0.0]
    if len(positive) == 0:
        return np.arange(len(probability))
    fallen = -np.log(np.maximum(probability, 0.5 * positive.min()))
    levels = np.linspace(fallen[0], fallen[-1], MOST_POINTS)
    return np.unique(np.minimum(np.searchsorted(fallen, levels), len(probability) - 1))


def name_panels(axes: list[Any], shown: list[Shown[Any]]) -> None:
    """Runs side by side are named above their panels; a single run needs no name."""
    if len(shown) > 1:
        for axis, run in zip(axes, shown, strict=True):
            axis.set_title(run.label)

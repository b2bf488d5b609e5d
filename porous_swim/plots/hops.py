"""How far, how long and which way swimmers hop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from porous_swim.analysis.histogram import Histogram
from porous_swim.plots.scales import Scales, label_x
from porous_swim.plots.style import Shown, legend, panels
from porous_swim.plots.winding import bars, logarithmic


@dataclass(frozen=True, eq=False)
class HopDistributions:
    """Distributions over hops."""

    length: Histogram  # a, between centres
    time: Histogram  # a/U
    turning_angle: Histogram  # degrees, from the hop before; signed in two dimensions


def draw(shown: list[Shown[HopDistributions]], scales: Scales | None) -> Figure:
    """Three panels: lengths, times, turning angles."""
    picture, (length, time, angle) = panels(3, width=3.9)
    for run in shown:
        bars(length, run.data.length, color=run.color, label=run.label if len(shown) > 1 else None)
        bars(time, run.data.time, color=run.color)
        bars(angle, run.data.turning_angle, color=run.color)
    label_x(length, "hop length", "a", scales)
    label_x(time, "hop time", "a/U", scales)
    angle.set_xlabel("turning angle (degrees)")
    angle.xaxis.set_major_locator(_every(60.0))
    logarithmic(time, [run.data.time for run in shown])
    for axis in (length, time, angle):
        axis.set_ylabel("share of hops")
    length.set_ylim(bottom=0.0)
    angle.set_ylim(bottom=0.0)
    legend(length)
    return picture


def _every(degrees: float) -> Any:
    from matplotlib.ticker import MultipleLocator

    return MultipleLocator(degrees)

"""Axes of pictures in a and U, and second ones in the laboratory's units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.ticker import NullFormatter

from porous_swim.core.scales import Scales as Scales
from porous_swim.core.scales import pretty
from porous_swim.plots.style import TEXT_SIZE


def common(scales: Sequence[Scales | None]) -> Scales | None:
    """The scales of runs in one picture: None where they differ, as no one axis can then hold for all."""
    return scales[0] if scales and all(found == scales[0] for found in scales) else None


def label_x(axis: Any, text: str, unit: str, scales: Scales | None) -> None:
    """Name the axis below and, where there are units, put the laboratory's above."""
    axis.set_xlabel(_named(text, unit))
    axis.xaxis.set_minor_formatter(NullFormatter())  # labels between decades would overlap
    found = scales and scales.physical(unit)
    if found:
        second = axis.secondary_xaxis("top", functions=_both_ways(found[0]))
        second.set_xlabel(f"{text} ({found[1]})", fontsize=TEXT_SIZE)
        second.xaxis.set_minor_formatter(NullFormatter())
        second.tick_params(which="both", labelsize=TEXT_SIZE)


def label_y(axis: Any, text: str, unit: str, scales: Scales | None) -> None:
    """Name the axis on the left and, where there are units, put the laboratory's on the right."""
    axis.set_ylabel(_named(text, unit))
    found = scales and scales.physical(unit)
    if found:
        second = axis.secondary_yaxis("right", functions=_both_ways(found[0]))
        second.set_ylabel(f"{text} ({found[1]})", fontsize=TEXT_SIZE)
        second.tick_params(which="both", labelsize=TEXT_SIZE)


def _named(text: str, unit: str) -> str:
    return f"{text} ({pretty(unit)})" if unit else text


def _both_ways(factor: float) -> tuple[Any, Any]:
    return (lambda value: value * factor), (lambda value: value / factor)

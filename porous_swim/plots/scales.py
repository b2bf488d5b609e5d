"""What a and a/U are in the laboratory, for tables and for second axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.ticker import NullFormatter

from porous_swim.plots.style import TEXT_SIZE

_POWERS = {  # unit of a table -> power of a, power of a/U, and its name in the laboratory
    "a": (1, 0, "µm"),
    "a^2": (2, 0, "µm²"),
    "a/U": (0, 1, "s"),
    "U": (1, -1, "µm/s"),
    "a U": (2, -1, "µm²/s"),
    "U/a": (0, -1, "1/s"),
    "turns U/a": (0, -1, "turns/s"),
}


@dataclass(frozen=True)
class Scales:
    """a in um and a/U in s."""

    length: float
    time: float

    @classmethod
    def of(cls, units: Mapping[str, Any] | None) -> Scales | None:
        """From the units of a run's tables; None where the scene had none."""
        return None if units is None else cls(float(units["length_um"]), float(units["time_s"]))

    def physical(self, unit: str) -> tuple[float, str] | None:
        """Factor from `unit` to the laboratory's, and the name of that; None for angles, turns and pure numbers."""
        if unit not in _POWERS:
            return None
        length, time, name = _POWERS[unit]
        return self.length**length * self.time**time, name


def common(scales: Sequence[Scales | None]) -> Scales | None:
    """The scales of runs in one picture: None where they differ, as no one axis can then hold for all."""
    return scales[0] if scales and all(found == scales[0] for found in scales) else None


def pretty(unit: str) -> str:
    """`a^2` as people write it."""
    return unit.replace("^2", "²")


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

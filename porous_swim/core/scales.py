"""What a and a/U are in the laboratory, and numbers in um and s for those in a and U."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_POWERS = {  # unit of a table -> power of a, power of a/U, and its name in the laboratory
    "a": (1, 0, "um"),
    "a^2": (2, 0, "um^2"),
    "a/U": (0, 1, "s"),
    "U": (1, -1, "um/s"),
    "a U": (2, -1, "um^2/s"),
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

    def convert(self, unit: str) -> tuple[float, str] | None:
        """Factor from `unit` to the laboratory's, and that unit in ASCII; None for angles, turns and pure numbers."""
        if unit not in _POWERS:
            return None
        length, time, name = _POWERS[unit]
        return self.length**length * self.time**time, name

    def physical(self, unit: str) -> tuple[float, str] | None:
        """The same with the unit as people write it."""
        found = self.convert(unit)
        return found and (found[0], pretty(found[1]))


def pretty(unit: str) -> str:
    """`um^2/s` as people write it: `µm²/s`."""
    return {"1/s": "s⁻¹"}.get(unit, unit.replace("^2", "²").replace("um", "µm"))


def shown_in(unit: str, scales: Scales | None) -> tuple[float, str]:
    """Factor and unit to show numbers of `unit` with: the laboratory's where it is known."""
    return (scales and scales.physical(unit)) or (1.0, pretty(unit))


def told(value: float, unit: str, scales: Scales | None, *, digits: str = "g") -> str:
    """A number of a message: `0.5` where the scene has no units, else `0.5 a (1 µm)`."""
    found = scales and scales.physical(unit)
    text = format(value, digits)
    return f"{text} {pretty(unit)} ({value * found[0]:.4g} {found[1]})" if found else text


def with_physical(summary: Mapping[str, Any], scales: Scales | None) -> dict[str, Any]:
    """Return a summary in which each statistic that has a unit tells under `physical` what it is in the laboratory."""
    if scales is None:
        return dict(summary)
    return {
        key: _completed(entry, scales) if isinstance(entry, Mapping) else entry for key, entry in summary.items()
    }  # fmt: skip


def _completed(entry: Mapping[str, Any], scales: Scales) -> dict[str, Any]:
    if not {"value", "standard_error", "unit"} <= set(entry):
        return with_physical(entry, scales)
    found = scales.convert(entry["unit"])
    if found is None:
        return dict(entry)
    factor, unit = found
    numbers = {
        name: None if entry[name] is None else entry[name] * factor for name in ("value", "standard_error")
    }  # fmt: skip
    return {**entry, "physical": {**numbers, "unit": unit}}

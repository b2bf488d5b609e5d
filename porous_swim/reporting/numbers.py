"""Numbers for people: a value with its error, and what both are in the laboratory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from porous_swim.analysis.estimates import NONE, value_and_error
from porous_swim.core.scales import Scales, pretty
from porous_swim.reporting.section import Cell, Number


def with_unit(value: float, error: float | None, unit: str) -> str:
    """The same with its unit."""
    text = value_and_error(value, error)
    return f"{text} {pretty(unit)}" if unit and text != NONE else text


def physical(value: float, error: float | None, unit: str, scales: Scales | None) -> str:
    """The same in the laboratory's units; nothing where there are none for it."""
    found = scales and scales.physical(unit)
    if not found or not math.isfinite(value):
        return ""
    factor, name = found
    return f"{value_and_error(value * factor, None if error is None else error * factor)} {name}"


def both(value: float, unit: str, scales: Scales | None, *, error: float | None = None) -> str:
    """`5 a (5 µm)`."""
    second = physical(value, error, unit, scales)
    return f"{with_unit(value, error, unit)} ({second})" if second else with_unit(value, error, unit)


def interval(low: float, high: float, unit: str, scales: Scales | None) -> str:
    """`5 to 6 a (5 to 6 µm)`."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return NONE
    text = f"{low:.4g} to {high:.4g} {pretty(unit)}".rstrip()
    found = scales and scales.physical(unit)
    return f"{text} ({low * found[0]:.4g} to {high * found[0]:.4g} {found[1]})" if found else text


def counted(n: int, what: str) -> str:
    """`1 swimmer`, `2,000 swimmers`."""
    return f"{n:,} {what}" if n == 1 else f"{n:,} {what}s"


def cell(value: float | None, error: float | None, *, note: str = "", warning: str | None = None) -> Cell:
    """A number with its error for a table, and why it is not to be trusted, where there is such."""
    if value is None or not math.isfinite(value):
        return Number(NONE, math.nan, warning=warning) if warning else NONE
    return Number(value_and_error(value, error), value, note, warning or "")


def statistics(summary: Mapping[str, Any], *path: str) -> dict[tuple[str, ...], Mapping[str, Any]]:
    """Every statistic of a summary, by its path there."""
    found: dict[tuple[str, ...], Mapping[str, Any]] = {}
    for key, entry in summary.items():
        if isinstance(entry, Mapping):
            if {"value", "standard_error", "n", "unit"} <= set(entry):
                found[(*path, key)] = entry
            else:
                found |= statistics(entry, *path, key)
    return found

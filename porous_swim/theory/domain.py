"""Sentences for arguments outside of their range."""

from __future__ import annotations

import math
from collections.abc import Sequence


def check_positive(**values: float) -> None:
    """`ValueError` unless each value is a finite number above 0, or infinity for a radius."""
    for name, value in values.items():
        if not value > 0.0 or (math.isinf(value) and name != "radius"):
            allowed = "numbers above 0, or inf for a plane wall" if name == "radius" else "finite numbers above 0"
            raise ValueError(f"{name}: found {value:g}, allowed are {allowed}")


def check_finite(**values: float) -> None:
    """`ValueError` unless each value is a finite number."""
    for name, value in values.items():
        if not math.isfinite(value):
            raise ValueError(f"{name}: found {value:g}, allowed are finite numbers")


def check_aspect_ratio(aspect_ratio: float) -> None:
    """`ValueError` unless 0 < gamma <= 1."""
    if not 0.0 < aspect_ratio <= 1.0:
        raise ValueError(f"aspect_ratio: found {aspect_ratio:g}, allowed are 0 < aspect_ratio <= 1")


def check_order(order: str, allowed: Sequence[str]) -> None:
    """`ValueError` unless `order` is one of `allowed`."""
    if order not in allowed:
        raise ValueError(f"order: found {order!r}, allowed are {' and '.join(repr(name) for name in allowed)}")


def bretherton(aspect_ratio: float) -> float:
    """Gamma = (1 - gamma^2)/(1 + gamma^2)."""
    return (1.0 - aspect_ratio**2) / (1.0 + aspect_ratio**2)

"""Numbers that parts of a scene hand to the kernels: each is declared once, where its part is, and has a name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Protocol


@dataclass(frozen=True)
class Given:
    """What the numbers of a part may depend on, beside its own keys. In a, U and a/U."""

    dipole_strength: float  # alpha
    aspect_ratio: float  # gamma
    dimensions: int
    time_step: float

    @property
    def bretherton(self) -> float:
        """Gamma = (1 - gamma^2)/(1 + gamma^2), 0 for a sphere."""
        squared = self.aspect_ratio * self.aspect_ratio
        return (1.0 - squared) / (1.0 + squared)


class HasNumbers(Protocol):
    """A part that hands numbers to the kernels."""

    NUMBERS: ClassVar[tuple[str, ...]]

    def numbers(self, given: Given) -> dict[str, float]:
        """Return a value for each of `NUMBERS`."""


def numbers_of(parts: Iterable[HasNumbers], given: Given) -> dict[str, float]:
    """Return the numbers of all `parts`; several may share one.

    Raises:
        TypeError: a part hands over other numbers than it declares.
        ValueError: two parts give different values to one name.
    """
    found: dict[str, float] = {}
    for part in parts:
        numbers, name = part.numbers(given), type(part).__name__
        if set(numbers) != set(part.NUMBERS):
            raise TypeError(f"{name}.numbers: expected a value for each of {part.NUMBERS}, found {tuple(numbers)}")
        for key, value in numbers.items():
            if found.setdefault(key, value) != value:
                raise ValueError(f"{name}.numbers: {key} is {value:g}, and another part has {found[key]:g} for it")
    return found

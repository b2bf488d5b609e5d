"""What starts and ends an encounter between a swimmer and a colloid."""

from __future__ import annotations

from math import pi, sin
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from porous_swim.core.numbers import Given
from porous_swim.core.parts import FARTHEST, KeyedError, Length, Part


class Encounter(Part):
    """Starts at first contact and ends when the height above that colloid exceeds `escape_height`."""

    escape_height: Length = Field(default=1.5, gt=0.0, le=FARTHEST)
    """Height of the swimmer's centre above the surface at which an encounter ends (the paper's r)."""
    contact_band: Length = Field(default=0.05, ge=0.0, le=FARTHEST)
    """A bound swimmer no higher than this above its contact height counts as in contact."""
    escape_pitch: Annotated[float, Field(gt=0.0, lt=1.571)] | Literal["leading", "exact"] = "leading"
    """Pitch whose first passage is timed: `leading` 3 alpha/(8 gamma^2), `exact` that of lift-off from each colloid, at
    which dh/dt = 0 in contact, or radians."""

    NUMBERS: ClassVar[tuple[str, ...]] = ("escape_sine", "alpha")
    # of the escape pitch; above 1: never; below -1: the lift-off pitch of each colloid, which follows from alpha

    def numbers(self, given: Given) -> dict[str, float]:
        """See `Part`."""
        alpha = given.dipole_strength
        return {"escape_sine": self.escape_sine(alpha, given.aspect_ratio), "alpha": alpha}

    def escape_sine(self, dipole_strength: float, aspect_ratio: float) -> float:
        """Sine of the pitch that is timed: 2 where there is none, -2 for the lift-off pitch of each colloid.

        Leading order: theta_e = 3 alpha/(8 hbar^2) with hbar = gamma (Soft Matter 11, 3396, section 4).
        """
        if self.escape_pitch == "exact":
            return -2.0 if dipole_strength >= 0.0 else 2.0
        pitch = self.escape_pitch
        if pitch == "leading":
            pitch = 3.0 * dipole_strength / (8.0 * aspect_ratio**2)
        return sin(pitch) if 0.0 <= pitch < 0.5 * pi else 2.0

    def check(self) -> None:
        """Raise a `KeyedError` where a swimmer in contact has escaped."""
        if self.escape_height <= 1.0 + self.contact_band:  # 1: the contact height of every shape on its tip
            message = f"expected more than 1 + contact_band = {1.0 + self.contact_band:g}, found {self.escape_height:g}"
            raise KeyedError("encounter.escape_height", f"{message}: a swimmer in contact must not have escaped")

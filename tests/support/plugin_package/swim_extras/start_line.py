"""Swimmers side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

import porous_swim as ps
from porous_swim.core.parts import ContactHeight, Length
from porous_swim.obstacles.field import ObstacleField
from porous_swim.swimmers.placement import Swimmers, checked_swimmers


class StartLine(ps.Release):
    """Swimmers at equal distances on a line along y through the origin, all swimming along x."""

    kind: Literal["start_line"]
    length: Annotated[Length, Field(ge=0.0, le=1e6)]
    """Length of the line; the first and the last swimmer are at its ends."""

    def place(
        self, field: ObstacleField, count: int, rng: np.random.Generator, contact_height: ContactHeight, *,
        folder: Path = Path(),
    ) -> Swimmers:  # fmt: skip
        """Return the swimmers; nothing in it is random."""
        position, director = np.zeros((2, count, 3))
        position[:, 1] = np.linspace(-0.5 * self.length, 0.5 * self.length, count)
        director[:, 0] = 1.0
        return checked_swimmers(
            position, director, field=field, contact_height=contact_height, key="swimmers.release.length"
        )

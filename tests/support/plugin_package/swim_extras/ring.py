"""Equal colloids on a circle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

import porous_swim as ps
from porous_swim.core.parts import KeyedError, Length, Radius, Whole
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.overlaps import checked_field


class Ring(ps.Layout):
    """Equal colloids on a circle around the origin, in open space."""

    OPEN = True

    layout: Literal["ring"]
    radius: Radius
    """Radius A of every colloid."""
    ring_radius: Annotated[Length, Field(gt=0.0, le=1e6)]
    """Radius of the circle on which their centres are."""
    count: Annotated[Whole, Field(gt=1, le=1000)]
    """Number of colloids."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where the box repeats."""
        if domain.periodic:
            raise KeyedError("domain.boundary", "a ring stands in open space: expected open, found periodic")

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many colloids there will be."""
        return self.count

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the ring as a field."""
        angle = 2.0 * np.pi * np.arange(self.count) / self.count
        centers = self.ring_radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(self.count)], axis=1)
        radii = np.full(self.count, self.radius)
        return checked_field(centers, radii, box=np.zeros(3), domain=domain, key="obstacles.ring_radius")

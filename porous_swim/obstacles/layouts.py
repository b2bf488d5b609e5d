"""How colloids are placed: each layout is a frozen model with `check(domain)` and `place(...)`.

`place(domain, rng, folder)` puts the centres into the box [0, box); what is wrong is a `KeyedError`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from porous_swim.columns import read_columns
from porous_swim.obstacles.disorder import Packing, Random
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.lattices import BodyCentred, FaceCentred, Hexagonal, SimpleCubic, Square
from porous_swim.obstacles.overlaps import checked_field
from porous_swim.obstacles.wall import Wall
from porous_swim.parts import LARGEST_RADIUS, LEAST_RADIUS, KeyedError, Part, Point, Radius, as_vector


class NoObstacles(Part):
    """Free space, or an empty periodic box."""

    layout: Literal["none"]

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where `domain` lacks a box, or has one that it does not need."""
        _optional_box(domain)

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return a field without colloids."""
        return ObstacleField(np.zeros((0, 3)), np.zeros(0), _optional_box(domain), domain.dimensions)


class Single(Part):
    """One colloid, alone in space or in a periodic box."""

    layout: Literal["single"]
    radius: Radius
    """Radius A of the colloid."""
    position: Point = (0.0, 0.0, 0.0)
    """Its centre; in a periodic box it is wrapped into the box."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where position or box do not fit `domain`."""
        _optional_box(domain)
        as_vector(self.position, key="obstacles.position", dimensions=domain.dimensions)

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the field of the one colloid."""
        center = as_vector(self.position, key="obstacles.position", dimensions=domain.dimensions)
        return checked_field(
            center[None, :],
            np.array([self.radius]),
            box=_optional_box(domain),
            dimensions=domain.dimensions,
            key="obstacles.position",
        )


class FromFile(Part):
    """Colloids read from a CSV file with the columns x, y, z, radius (z may be left out in 2-D)."""

    layout: Literal["file"]
    path: Annotated[str, Field(min_length=1)]
    """The CSV file, relative to the scene's folder. Numbers in a, also where the scene has units."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where the box does not fit `domain`."""
        _optional_box(domain)

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the field of the file's colloids."""
        flat = domain.dimensions == 2
        axes = ["x", "y"] if flat else ["x", "y", "z"]
        columns = read_columns(
            folder / self.path,
            key="obstacles.path",
            required=[*axes, "radius"],
            optional=["z"] if flat else [],
        )
        centers = np.stack([columns["x"], columns["y"], columns["z"]], axis=1)
        self._check_rows(centers, columns["radius"], flat=flat)
        return checked_field(
            centers,
            columns["radius"],
            box=_optional_box(domain),
            dimensions=domain.dimensions,
            key="obstacles.path",
        )

    def _check_rows(self, centers: np.ndarray, radii: np.ndarray, *, flat: bool) -> None:
        if len(radii) == 0:
            raise KeyedError("obstacles.path", f"{self.path}: expected at least one colloid below the header")
        if np.any(radii <= 0.0):
            i = int(np.argmax(radii <= 0.0))
            raise KeyedError(
                "obstacles.path", f"{self.path}: colloid {i} must have a radius above 0, found {radii[i]:g}"
            )
        beyond = (radii < LEAST_RADIUS) | (radii > LARGEST_RADIUS)
        if np.any(beyond):
            i = int(np.argmax(beyond))
            allowed = f"{LEAST_RADIUS:g} to {LARGEST_RADIUS:g}"
            raise KeyedError(
                "obstacles.path", f"{self.path}: colloid {i} must have a radius of {allowed}, found {radii[i]:g}"
            )
        if flat and np.any(centers[:, 2] != 0.0):
            i = int(np.argmax(centers[:, 2] != 0.0))
            message = f"{self.path}: in two dimensions colloid {i} must have z = 0, found {centers[i, 2]:g}"
            raise KeyedError("obstacles.path", message)


def _optional_box(domain: Domain) -> np.ndarray:
    if domain.periodic:
        return domain.sized_box()
    domain.refuse_size("an open domain is unbounded")
    return np.zeros(3)


Layout = Annotated[
    NoObstacles
    | Single
    | Wall
    | Square
    | Hexagonal
    | SimpleCubic
    | BodyCentred
    | FaceCentred
    | Random
    | Packing
    | FromFile,
    Field(discriminator="layout"),
]

OPEN_BY_DEFAULT = ("none", "single", "wall")

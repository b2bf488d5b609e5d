"""Lattices of equal spheres. `spacing` is the distance between the centres of nearest neighbours."""

from __future__ import annotations

from math import prod, sqrt
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from porous_swim.core.parts import LONGEST, KeyedError, Length, Radius, Whole, check_all
from porous_swim.core.scales import told
from porous_swim.obstacles.base import Layout
from porous_swim.obstacles.domain import MOST_COLLOIDS, Domain
from porous_swim.obstacles.field import ObstacleField


class Lattice(Layout):
    """Equal spheres on a lattice; it sets the box."""

    DIMENSIONS: ClassVar[int]
    EDGES: ClassVar[tuple[float, ...]]  # of the orthogonal cell, in nearest-neighbour distances
    BASIS: ClassVar[tuple[tuple[float, ...], ...]]  # centres in the cell, in edges

    radius: Radius
    """Radius A of every colloid."""
    spacing: Annotated[Length, Field(gt=0.0, le=LONGEST)]
    """Distance between the centres of nearest neighbours, at least 2 radii."""
    cells: Annotated[tuple[Annotated[Whole, Field(gt=0, le=MOST_COLLOIDS)], ...], Field(min_length=2, max_length=3)]
    """Number of orthogonal cells along each axis."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where the lattice does not fit `domain`."""
        tag = getattr(self, "layout", type(self).__name__)
        check_all(
            lambda: self._check_dimensions(domain, tag),
            lambda: domain.refuse_size(f"the layout {tag} sets the box from spacing and cells"),
            lambda: self._check_cells(domain),
            lambda: self._check_spacing(domain),
        )

    def _check_dimensions(self, domain: Domain, tag: str) -> None:
        if domain.dimensions != self.DIMENSIONS:
            message = f"the layout {tag} needs {self.DIMENSIONS}, found {domain.dimensions}"
            raise KeyedError("domain.dimensions", message)

    def _check_cells(self, domain: Domain) -> None:
        if len(self.cells) != self.DIMENSIONS:
            message = f"expected {self.DIMENSIONS} numbers of cells, found {len(self.cells)}"
            raise KeyedError("obstacles.cells", message)
        count = self.n_colloids(domain, Path())
        if count > MOST_COLLOIDS:
            raise KeyedError("obstacles.cells", f"expected at most {MOST_COLLOIDS} colloids, found {count}")

    def _check_spacing(self, domain: Domain) -> None:
        if self.spacing < 2.0 * self.radius:
            numbers = self.radius, 2.0 * self.radius, self.spacing
            radius, least, found = (told(value, "a", domain.scales) for value in numbers)
            overlap = told(2.0 * self.radius - self.spacing, "a", domain.scales, digits=".3g")
            message = f"colloids of radius {radius} overlap by {overlap}: expected at least {least}, found {found}"
            raise KeyedError("obstacles.spacing", message)

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many colloids there will be."""
        return prod(self.cells) * len(self.BASIS)

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the lattice as a field; nothing in it is random."""
        self.check(domain)
        edges = self.spacing * np.array(self.EDGES)
        corners = np.stack(np.meshgrid(*(np.arange(n) for n in self.cells), indexing="ij"), axis=-1)
        flat = corners.reshape(-1, 1, self.DIMENSIONS) + np.array(self.BASIS)
        centers = np.zeros((flat.shape[0] * flat.shape[1], 3))
        centers[:, : self.DIMENSIONS] = (flat * edges).reshape(-1, self.DIMENSIONS)
        box = np.zeros(3)
        if domain.periodic:
            box[: self.DIMENSIONS] = np.array(self.cells) * edges
        return ObstacleField.of_spheres(centers, np.full(len(centers), self.radius), box, domain.dimensions)


class Square(Lattice):
    """A square lattice in the plane, one colloid to a cell."""

    DIMENSIONS, EDGES, BASIS = 2, (1.0, 1.0), ((0.0, 0.0),)

    layout: Literal["square"]


class Hexagonal(Lattice):
    """A hexagonal lattice in the plane, two colloids to a cell of spacing by sqrt(3) spacing."""

    DIMENSIONS, EDGES, BASIS = 2, (1.0, sqrt(3.0)), ((0.0, 0.0), (0.5, 0.5))

    layout: Literal["hexagonal"]


class SimpleCubic(Lattice):
    """A simple cubic lattice, one colloid to a cell."""

    DIMENSIONS, EDGES, BASIS = 3, (1.0, 1.0, 1.0), ((0.0, 0.0, 0.0),)

    layout: Literal["sc"]


class BodyCentred(Lattice):
    """A body-centred cubic lattice, two colloids to a cell of edge 2 spacing/sqrt(3)."""

    DIMENSIONS, EDGES, BASIS = 3, (2.0 / sqrt(3.0),) * 3, ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))

    layout: Literal["bcc"]


class FaceCentred(Lattice):
    """A face-centred cubic lattice, four colloids to a cell of edge sqrt(2) spacing."""

    DIMENSIONS, EDGES = 3, (sqrt(2.0),) * 3
    BASIS = ((0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5))

    layout: Literal["fcc"]

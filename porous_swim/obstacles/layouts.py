"""All layouts: those of one colloid or none, colloids from a file, and the list of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from porous_swim.core.csv_table import read_columns
from porous_swim.core.parts import LARGEST_RADIUS, LEAST_RADIUS, KeyedError, Length, Point, Radius, as_vector
from porous_swim.core.registry import add
from porous_swim.core.scales import told
from porous_swim.obstacles.base import Layout
from porous_swim.obstacles.disorder import Packing, Random
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.lattices import BodyCentred, FaceCentred, Hexagonal, SimpleCubic, Square
from porous_swim.obstacles.measured import Beads, Overlaps, compared_with_box, merged, resolved
from porous_swim.obstacles.overlaps import TOUCH, checked_field
from porous_swim.obstacles.wall import Wall


class NoObstacles(Layout):
    """Free space, or an empty periodic box."""

    OPEN = True
    ROUND: ClassVar[bool] = False  # as of `Wall`

    layout: Literal["none"]

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where `domain` lacks a box, or has one that it does not need."""
        _optional_box(domain)

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many colloids there will be."""
        return 0

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return a field without colloids."""
        return ObstacleField.of_spheres(np.zeros((0, 3)), np.zeros(0), _optional_box(domain), domain.dimensions)


class Single(Layout):
    """One colloid, alone in space or in a periodic box."""

    OPEN = True

    layout: Literal["single"]
    radius: Radius
    """Radius A of the colloid."""
    position: Point = (0.0, 0.0, 0.0)
    """Its centre; in a periodic box it is wrapped into the box."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where position or box do not fit `domain`."""
        _optional_box(domain)
        as_vector(self.position, key="obstacles.position", dimensions=domain.dimensions)

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many colloids there will be."""
        return 1

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the field of the one colloid."""
        center = as_vector(self.position, key="obstacles.position", dimensions=domain.dimensions)
        return checked_field(
            center[None, :],
            np.array([self.radius]),
            box=_optional_box(domain),
            domain=domain,
            key="obstacles.position",
        )


class FromFile(Layout):
    """Colloids read from a CSV file with the columns x, y, z, radius (z may be left out in 2-D)."""

    layout: Literal["file"]
    path: Annotated[str, Field(min_length=1)]
    """The CSV file, relative to the scene's folder."""
    unit: Annotated[str, Field(min_length=1, max_length=20)] | None = None
    """Unit of the numbers in the file: `a`, a length such as `um` where the scene has units, or `px` with `scale`.
    Left out: `a`."""
    scale: Annotated[Length, Field(gt=0.0)] | None = None
    """What a pixel is, with `unit: px`, such as `0.16 um`."""
    merge: Annotated[Length, Field(gt=0.0)] | None = None
    """Detections whose centres are nearer than this are one colloid, at their mean place with their mean radius.
    Left out: none are."""
    overlaps: Overlaps = "error"
    """What becomes of colloids that overlap by more than `tolerance`: `error` refuses the file, `shrink` makes both
    smaller until they touch, `drop` leaves out the smaller one."""
    tolerance: Annotated[float, Field(ge=0.0, le=0.1)] = 1e-4
    """Share of their summed radii by which colloids may overlap as they are: touching ones do where digits are
    rounded."""

    _factor: float = PrivateAttr(1.0)  # a to a unit of the file
    _unsaid: bool = PrivateAttr(False)  # the scene has units, and the file has none

    @model_validator(mode="after")
    def _unit_is_a_length(self, info: ValidationInfo) -> FromFile:
        units = (info.context or {}).get("units")
        if (self.unit == "px") != (self.scale is not None):
            raise KeyedError("scale", "expected with unit: px, and only there, such as `0.16 um`")
        self._unsaid = units is not None and self.unit is None
        if self.unit == "px":
            assert self.scale is not None
            self._factor = self.scale
        elif self.unit not in (None, "a"):
            if units is None:
                message = f"{self.unit!r} needs a `units` section; without one expected a, or px with scale in a"
                raise KeyedError("unit", message)
            try:
                self._factor = units.number(f"1 {self.unit}", "length")
            except ValueError as error:
                raise KeyedError("unit", str(error)) from None
        return self

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where the box does not fit `domain`."""
        _optional_box(domain)

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return about how many colloids there will be: a line of the file each."""
        path = folder / self.path
        try:
            with path.open("rb") as file:
                return sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 20), b""))
        except OSError:
            return 0  # placing says what is wrong with it

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the field of the file's colloids."""
        flat, box, name = domain.dimensions == 2, _optional_box(domain), Path(self.path).name
        axes = ["x", "y"] if flat else ["x", "y", "z"]
        columns = read_columns(
            folder / self.path,
            key="obstacles.path",
            required=[*axes, "radius"],
            optional=["z"] if flat else [],
        )
        centers = np.stack([columns["x"], columns["y"], columns["z"]], axis=1)
        self._check_rows(centers, columns["radius"], domain)
        beads = Beads(self._factor * centers, self._factor * columns["radius"], domain.scales)
        if self._unsaid:
            beads = beads.noted(
                f"the numbers in {name} are read in half-lengths a, though the scene has units: say what they are by "
                "obstacles.unit (a, um, or px with scale)"
            )
        if self.merge is not None:
            beads = merged(beads, self.merge, box=box)
        beads = compared_with_box(beads, box=box)
        beads = resolved(beads, self.overlaps, tolerance=self.tolerance, box=box, name=name)
        return checked_field(
            beads.centers, beads.radii, box=box, domain=domain, key="obstacles.path",
            tolerance=max(self.tolerance, TOUCH), notes=beads.notes,
        )  # fmt: skip

    def _check_rows(self, centers: np.ndarray, radii: np.ndarray, domain: Domain) -> None:
        if len(radii) == 0:
            raise KeyedError("obstacles.path", f"{self.path}: expected at least one colloid below the header")
        if np.any(radii <= 0.0):
            i = int(np.argmax(radii <= 0.0))
            raise KeyedError(
                "obstacles.path", f"{self.path}: colloid {i} must have a radius above 0, found {radii[i]:g}"
            )
        in_a = self._factor * radii
        beyond = (in_a < LEAST_RADIUS) | (in_a > LARGEST_RADIUS)
        if np.any(beyond):
            i = int(np.argmax(beyond))
            least, most, found = (told(x, "a", domain.scales) for x in (LEAST_RADIUS, LARGEST_RADIUS, float(in_a[i])))
            message = f"{self.path}: colloid {i} must have a radius of {least} to {most}, found {found}"
            raise KeyedError("obstacles.path", message)
        if domain.dimensions == 2 and np.any(centers[:, 2] != 0.0):
            i = int(np.argmax(centers[:, 2] != 0.0))
            message = f"{self.path}: in two dimensions colloid {i} must have z = 0, found {centers[i, 2]:g}"
            raise KeyedError("obstacles.path", message)


def _optional_box(domain: Domain) -> np.ndarray:
    if domain.periodic:
        return domain.sized_box()
    domain.refuse_size("an open domain is unbounded")
    return np.zeros(3)


add(NoObstacles, Single, Wall, Square, Hexagonal, SimpleCubic, BodyCentred, FaceCentred, Random, Packing, FromFile)

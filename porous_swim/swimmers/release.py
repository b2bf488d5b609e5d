"""Where swimmers start: every kind of release is a frozen model with `check(domain)` and `place(...)`.

`place(field, count, rng, contact_height, folder=...)` returns `Swimmers` that keep their contact height above
every colloid, or raises a `KeyedError`. The first swimmers do not depend on how many follow them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from porous_swim.core.csv_table import read_columns
from porous_swim.core.parts import (
    FARTHEST,
    LONGEST,
    ContactHeight,
    Direction,
    KeyedError,
    Length,
    Point,
    Whole,
    as_vector,
    unit_vector,
)
from porous_swim.core.registry import add
from porous_swim.obstacles.domain import MOST_COLLOIDS, Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.swimmers.base import Release
from porous_swim.swimmers.placement import Swimmers, checked_swimmers, fits, frame_of, random_directors

_KEY = "swimmers.release"
_BLOCK = 1024  # swimmers that share a stream of trial places
_LEAST_SHARE = 1e-4  # of the trials; below that the field has no room worth the name
_ENOUGH_TRIES = 100_000  # to tell a share of 1e-4 from none: 10 expected
_AT_ONCE, _MOST_AT_ONCE = 4096, 64  # trials looked at together, and rounds of them
_MOST_TRIES, _MOST_TRIES_EACH = 4_000_000, 100  # of all swimmers, or of each if that is more: half a minute for 10^4


class Uniform(Release):
    """Directors isotropic; then positions uniform in the box, wherever a swimmer fits."""

    kind: Literal["uniform"] = "uniform"

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where there is no box to fill."""
        if not domain.periodic:
            raise KeyedError(
                _KEY,
                "a uniform release fills a periodic box, and domain.boundary is open: expected domain.boundary: "
                "periodic, or here point, beam, parallel or file",
            )

    def place(
        self,
        field: ObstacleField,
        count: int,
        rng: np.random.Generator,
        contact_height: ContactHeight,
        *,
        folder: Path = Path(),
    ) -> Swimmers:
        """Return `count` swimmers; a `KeyedError` when fewer than 1 in 10^4 trials fit."""
        blocks = rng.spawn(-(-count // _BLOCK))
        placed, left = [], max(_MOST_TRIES, _MOST_TRIES_EACH * count)
        for stream in blocks:
            block, tries = self._block(field, stream, contact_height, most=left)
            placed.append(block)
            left -= tries
        position = np.concatenate([block.position for block in placed])[:count]
        director = np.concatenate([block.director for block in placed])[:count]
        return Swimmers(position, director)

    def _block(
        self, field: ObstacleField, rng: np.random.Generator, contact_height: ContactHeight, *, most: int
    ) -> tuple[Swimmers, int]:
        """Place one block; return it with the number of trials that it took, not many more than `most`."""
        director = random_directors(rng, _BLOCK, field.dimensions)
        position = np.zeros((_BLOCK, 3))
        pending, tries = np.arange(_BLOCK), 0
        while len(pending):
            # the fewer are left the more rounds at once; each draws for all, so that swimmers do not mix
            k = min(max(_AT_ONCE // len(pending), 1), _MOST_AT_ONCE)
            if tries > most:
                found = f"{_BLOCK - len(pending)} of {tries:,} trials kept clear of the colloids"
                raise KeyedError(_KEY, f"swimmers hardly fit: {found}; give more room, or a release from a file")
            trial = (rng.random((k, _BLOCK, 3)) * field.box)[:, pending]
            good = fits(
                trial.reshape(-1, 3), np.tile(director[pending], (k, 1)), field=field, contact_height=contact_height
            ).reshape(k, len(pending))
            first, found_room = good.argmax(axis=0), good.any(axis=0)
            tries += int(np.where(found_room, first + 1, k).sum())
            position[pending[found_room]] = trial[first, np.arange(len(pending))][found_room]
            pending = pending[~found_room]
            if tries >= _ENOUGH_TRIES and _BLOCK - len(pending) < _LEAST_SHARE * tries:
                found = f"{_BLOCK - len(pending)} of {tries} trials kept clear of the colloids"
                least = f"expected at least 1 in {1.0 / _LEAST_SHARE:g}"
                raise KeyedError(_KEY, f"swimmers do not fit: {found}, {least}")
        return Swimmers(position, director), tries


class PointRelease(Release):
    """All swimmers start at one place."""

    kind: Literal["point"]
    position: Point
    """Where they start."""
    director: Direction | None = None
    """Where they point; any length. Left out: each its own way, isotropic."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where position or director do not fit the dimensions."""
        as_vector(self.position, key=f"{_KEY}.position", dimensions=domain.dimensions)
        if self.director is not None:
            unit_vector(self.director, key=f"{_KEY}.director", dimensions=domain.dimensions)

    def place(
        self,
        field: ObstacleField,
        count: int,
        rng: np.random.Generator,
        contact_height: ContactHeight,
        *,
        folder: Path = Path(),
    ) -> Swimmers:
        """Return `count` swimmers at the point."""
        at = as_vector(self.position, key=f"{_KEY}.position", dimensions=field.dimensions)
        if self.director is None:
            director = random_directors(rng, count, field.dimensions)
        else:
            e = unit_vector(self.director, key=f"{_KEY}.director", dimensions=field.dimensions)
            director = np.tile(e, (count, 1))
        return checked_swimmers(
            np.tile(at, (count, 1)),
            director,
            field=field,
            contact_height=contact_height,
            key=f"{_KEY}.position",
        )


class Beam(Release):
    """Parallel directors, starts uniform over a disc across them (over a segment in 2-D)."""

    kind: Literal["beam"]
    origin: Point
    """Centre of the disc."""
    director: Direction
    """Where all swimmers point; any length."""
    width: Annotated[Length, Field(ge=0.0, le=LONGEST)]
    """Diameter of the disc, length of the segment."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where origin or director do not fit the dimensions."""
        as_vector(self.origin, key=f"{_KEY}.origin", dimensions=domain.dimensions)
        unit_vector(self.director, key=f"{_KEY}.director", dimensions=domain.dimensions)

    def place(
        self,
        field: ObstacleField,
        count: int,
        rng: np.random.Generator,
        contact_height: ContactHeight,
        *,
        folder: Path = Path(),
    ) -> Swimmers:
        """Return `count` swimmers of the beam."""
        origin = as_vector(self.origin, key=f"{_KEY}.origin", dimensions=field.dimensions)
        e = unit_vector(self.director, key=f"{_KEY}.director", dimensions=field.dimensions)
        first, second = frame_of(e[None, :])
        u = rng.random((count, 2))
        if field.dimensions == 2:
            across = self.width * (u[:, :1] - 0.5) * first
        else:
            distance, angle = 0.5 * self.width * np.sqrt(u[:, :1]), 2.0 * np.pi * u[:, 1:]
            across = distance * (np.cos(angle) * first + np.sin(angle) * second)
        return checked_swimmers(
            origin + across, np.tile(e, (count, 1)), field=field, contact_height=contact_height, key=_KEY
        )


class Parallel(Release):
    """Starts uniform around one colloid (over one point of a wall) at one height, directors along it, else random."""

    kind: Literal["parallel"]
    height: Annotated[Length, Field(gt=0.0, le=FARTHEST)]
    """Height of the swimmers' centres above the surface."""
    colloid: Annotated[Whole, Field(ge=0, le=MOST_COLLOIDS)] = 0
    """Which colloid, counted from 0."""

    def place(
        self,
        field: ObstacleField,
        count: int,
        rng: np.random.Generator,
        contact_height: ContactHeight,
        *,
        folder: Path = Path(),
    ) -> Swimmers:
        """Return `count` swimmers around the colloid."""
        if self.colloid >= len(field.radii):
            message = f"expected the index of one of {len(field.radii)} colloids, found {self.colloid}"
            raise KeyedError(f"{_KEY}.colloid", message)
        places, headings = rng.spawn(2)
        facing = random_directors(places, count, field.dimensions)
        position, normal = field.above(self.colloid, facing, self.height)
        first, second = frame_of(normal)
        u = headings.random((count, 1))
        if field.dimensions == 2:
            director = np.where(u < 0.5, first, -first)
        else:
            director = np.cos(2.0 * np.pi * u) * first + np.sin(2.0 * np.pi * u) * second
        return checked_swimmers(position, director, field=field, contact_height=contact_height, key=f"{_KEY}.height")


class FromFile(Release):
    """Starts read from a CSV file with the columns x, y, z, ex, ey, ez (z and ez may be left out in 2-D)."""

    kind: Literal["file"]
    path: Annotated[str, Field(min_length=1)]
    """The CSV file, relative to the scene's folder; one row per swimmer. Numbers in a, also with units."""

    def place(
        self,
        field: ObstacleField,
        count: int,
        rng: np.random.Generator,
        contact_height: ContactHeight,
        *,
        folder: Path = Path(),
    ) -> Swimmers:
        """Return the swimmers of the file, of which there must be `count`."""
        key, flat = f"{_KEY}.path", field.dimensions == 2
        names = ["x", "y", "z", "ex", "ey", "ez"]
        optional = ["z", "ez"] if flat else []
        required = [name for name in names if name not in optional]
        columns = read_columns(folder / self.path, key=key, required=required, optional=optional)
        rows = np.stack([columns[name] for name in names], axis=1)
        if len(rows) != count:
            raise KeyedError(key, f"{self.path}: expected as many rows as swimmers.count ({count}), found {len(rows)}")
        position, director = rows[:, :3], rows[:, 3:]
        if flat and np.any(rows[:, [2, 5]] != 0.0):
            i = int(np.argmax(np.any(rows[:, [2, 5]] != 0.0, axis=1)))
            raise KeyedError(key, f"{self.path}: in two dimensions swimmer {i} must have z = ez = 0")
        length = np.linalg.norm(director, axis=1, keepdims=True)
        if np.any(length == 0.0):
            i = int(np.argmax(length == 0.0))
            raise KeyedError(key, f"{self.path}: swimmer {i} has the zero vector for a director")
        return checked_swimmers(position, director / length, field=field, contact_height=contact_height, key=key)


add(Uniform, PointRelease, Beam, Parallel, FromFile)

"""Colloids at random: one by one, or packed densely."""

from __future__ import annotations

from abc import abstractmethod
from math import pi, sqrt
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from porous_swim.core.parts import FARTHEST, KeyedError, Length, Radii, Whole
from porous_swim.core.scales import told
from porous_swim.obstacles.base import Layout
from porous_swim.obstacles.domain import MOST_COLLOIDS, Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.insertion import insert
from porous_swim.obstacles.overlaps import checked_field
from porous_swim.obstacles.spheres import bulk

Fractions = Annotated[tuple[Annotated[float, Field(ge=1e-9, le=1e9)], ...], Field(min_length=1)]


_DENSEST = {2: pi / sqrt(12.0), 3: pi / sqrt(18.0)}  # of equal discs (Thue), of equal spheres (Hales)
_MOST_PACKED = 1_000_000  # 0.2 ms each at a fraction of 0.3, 1 ms where they jam
_MANY = 200  # spheres of which a random arrangement comes no farther than one without end, within a few per cent


class Disorder(Layout):
    """Colloids without order; two of `count`, `packing_fraction` and `domain.size` give the third."""

    radius: Radii
    """Radius of the colloids, or a list of radii."""
    fractions: Fractions | None = None
    """Share of the colloids that has each radius; they are scaled to a sum of 1. Left out: equal shares."""
    count: Annotated[Whole, Field(gt=0, le=MOST_COLLOIDS)] | None = None
    """Number of colloids."""
    packing_fraction: Annotated[float, Field(ge=1e-12, lt=1.0)] | None = None
    """Share of the volume (area in 2-D) in colloids; with `domain.size` as near as a whole count comes."""
    min_gap: Annotated[Length, Field(ge=0.0, le=FARTHEST)] = 0.0
    """Least distance between two surfaces. A swimming sphere passes where it is 2 or more."""
    seed: Annotated[Whole, Field(ge=0, lt=2**64)] | None = None
    """Where the colloids are follows from it. Set it to keep the medium while `run.seed` changes the swimmers.
    Left out: `run.seed`."""

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` unless exactly two of count, packing_fraction and domain.size are given."""
        given = [self.count is not None, self.packing_fraction is not None, domain.size is not None]
        if sum(given) != 2:
            names = ("count", "packing_fraction", "domain.size")
            found = " and ".join(name for name, there in zip(names, given, strict=True) if there) or "none"
            message = "expected two of count, packing_fraction and domain.size"
            raise KeyedError("obstacles", f"{message}, found {found if sum(given) < 3 else 'all three'}")
        if self.fractions is not None and len(self.fractions) != len(self.radius):
            message = f"expected as many as there are radii ({len(self.radius)}), found {len(self.fractions)}"
            raise KeyedError("obstacles.fractions", message)
        if domain.size is not None:
            domain.sized_box()

    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many colloids there will be."""
        if self.count is not None:
            return self.count
        assert self.packing_fraction is not None
        d = domain.dimensions
        mean = float(self._shares() @ bulk(np.array(self.radius), d))
        return round(self.packing_fraction * float(np.prod(domain.sized_box()[:d])) / mean)

    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return a field that differs with `rng`. An open one is cut out of a periodic one."""
        self.check(domain)
        radii, box = self._radii_and_box(domain)
        centers = np.zeros((len(radii), 3))
        centers[:, : domain.dimensions] = self._centers(radii + 0.5 * self.min_gap, box[: domain.dimensions], rng)
        if not domain.periodic:
            box = np.zeros(3)
        return checked_field(centers, radii, box=box, domain=domain, key="obstacles")

    _LIMITS: ClassVar[dict[int, float]] = {}  # share of the box that many equal spheres reach, by dimensions
    _WHY: ClassVar[str] = ""

    @abstractmethod
    def _centers(self, radii: np.ndarray, box: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return (n, d) centres of spheres of `radii` (n,) in the periodic `box` (d,)."""

    def _shares(self) -> np.ndarray:
        """Return the share of each radius."""
        shares = np.array(self.fractions or (1.0,) * len(self.radius))
        return np.asarray(shares / shares.sum())

    def _radii_and_box(self, domain: Domain) -> tuple[np.ndarray, np.ndarray]:
        """Return radii (n,), the largest first, and the edges (3,) of the box."""
        d, shares = domain.dimensions, self._shares()
        count = self.n_colloids(domain, Path())
        if not 0 < count <= MOST_COLLOIDS:
            message = f"expected 1 to {MOST_COLLOIDS} colloids in the box, found {count}"
            raise KeyedError("obstacles.packing_fraction", message)
        radii = np.sort(np.repeat(np.array(self.radius), _apportion(count, shares)))[::-1].copy()
        if domain.size is not None:
            box = domain.sized_box()
        else:
            box = np.zeros(3)
            box[:d] = (bulk(radii, d).sum() / self.packing_fraction) ** (1.0 / d)
        shortest = 2.0 * radii[0] + self.min_gap
        if box[:d].min() < shortest:
            radius, edge, least = (told(float(x), "a", domain.scales) for x in (radii[0], box[:d].min(), shortest))
            message = f"a colloid of radius {radius} overlaps its own image in a box of {edge}"
            raise KeyedError("obstacles", f"{message}: expected at least {least}")
        self._check_room(radii + 0.5 * self.min_gap, box[:d])
        return radii, box

    def _check_room(self, radii: np.ndarray, box: np.ndarray) -> None:
        """Raise a `KeyedError` where spheres of `radii` (n,), gaps included, are known not to fit into `box` (d,)."""
        share, d = float(bulk(radii, len(box)).sum() / np.prod(box)), len(box)
        equal = radii[0] == radii[-1]
        most, why = (_DENSEST[d], "the densest packing of equal ones there is") if equal else (1.0, "all of the box")
        if equal and len(radii) >= _MANY:
            limit = self._LIMITS.get(d, most)
            most, why = (limit, self._WHY) if limit < most else (most, why)
        if share > most:
            gaps = ", gaps included," if self.min_gap else ""
            raise KeyedError(
                "obstacles",
                f"the colloids would fill {share:.4g} of the box{gaps} and {most:.4g} is {why}: give fewer, a smaller "
                "packing_fraction or min_gap, or a larger domain.size",
            )


class Random(Disorder):
    """Spheres put down one by one where there is room (random sequential addition), the largest first."""

    # Jammed by addition at 0.5471 and 0.3841 (Torquato, Uche, Stillinger, Phys. Rev. E 74, 061308, 2006), and 0.01 more
    # for boxes of some hundred
    _LIMITS, _WHY = {2: 0.557, 3: 0.394}, "more than equal ones fill that are put down one by one"

    layout: Literal["random"]

    def _centers(self, radii: np.ndarray, box: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        centers = insert(radii, box, rng)
        if len(centers) < len(radii):
            share = bulk(radii, len(box)).sum() / np.prod(box)
            raise KeyedError(
                "obstacles",
                f"only {len(centers)} of {len(radii)} colloids found room (fraction {share:.3g} with gaps): "
                "give fewer, a larger domain.size, or the layout packing",
            )
        return centers


class Packing(Disorder):
    """A random packing of moving, growing spheres (Lubachevsky, Stillinger, J. Stat. Phys. 60, 561, 1990)."""

    _LIMITS, _WHY = {3: 0.66}, "more than a random packing of equal ones reaches (0.64)"

    layout: Literal["packing"]

    def _centers(self, radii: np.ndarray, box: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        import spheropack

        if len(radii) > _MOST_PACKED:
            found = f"expected at most {_MOST_PACKED:,} colloids, which take some ten minutes, found {len(radii):,}"
            raise KeyedError("obstacles", f"{found}: give fewer, or the layout random")
        try:
            packing = spheropack.pack(
                radii=radii,
                container=spheropack.PeriodicBox(tuple(box)),
                seed=int(rng.integers(2**63)),
                strict=True,
            )
        except (spheropack.PackingError, ValueError) as error:
            share = bulk(radii, len(box)).sum() / np.prod(box)
            raise KeyedError(
                "obstacles",
                f"the colloids cannot be packed to a fraction of {share:.4g}, gaps included: {error}",
            ) from None
        return np.asarray(packing.positions, dtype=np.float64)


def _apportion(count: int, shares: np.ndarray) -> np.ndarray:
    """Return whole numbers with the sum `count` that are nearest to `count * shares` (largest remainders)."""
    numbers: np.ndarray = np.floor(count * shares).astype(np.int64)
    remainder = count * shares - numbers
    numbers[np.argsort(-remainder, kind="stable")[: count - numbers.sum()]] += 1
    return numbers

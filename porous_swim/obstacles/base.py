"""What a layout is: it puts colloids into a domain."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from porous_swim.core.registry import OpenPart
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField


class Layout(OpenPart):
    """How colloids are placed: a frozen model, chosen by `layout` in the section `obstacles`.

    A field `seed` is the seed of the medium in place of `run.seed`. A field `path` names a file, relative to the
    scene's folder: run folders get a copy of it, and what is in it belongs to the identity of the scene.
    """

    TAG: ClassVar[str] = "layout"
    OPEN: ClassVar[bool] = False
    """Whether space is open where the scene does not say, in place of periodic."""
    ROUND: ClassVar[bool] = True
    """Whether it puts bodies that swimmers can go all the way round, of which a rod may touch two."""

    if TYPE_CHECKING:
        layout: str

    def check(self, domain: Domain) -> None:
        """Raise a `KeyedError` where layout and `domain` do not fit, without placing anything; here: accept all.

        Errors name keys of the scene, such as `obstacles.spacing` or `domain.size`.
        """

    @abstractmethod
    def n_colloids(self, domain: Domain, folder: Path) -> int:
        """Return how many colloids there will be, or about how many: memory is estimated from it."""

    @abstractmethod
    def place(self, domain: Domain, rng: np.random.Generator, folder: Path) -> ObstacleField:
        """Return the colloids, which follow from the layout, `domain` and `rng` alone; files are in `folder`.

        Centres are (n, 3) float64 in a, inside of the box [0, box) where it repeats, with z = 0 in 2-D; radii (n,) in
        a. `porous_swim.obstacles.overlaps.checked_field` wraps them into the box and refuses overlaps. A `KeyedError`
        says why there is no room.
        """

"""What a kind of body has to know of itself. Everybody else asks the field, which holds bodies of any kinds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal, Protocol

import numpy as np

from porous_swim.physics.model import Surface


class Search(Protocol):
    """Finds bodies of one kind, and their periodic images, near points."""

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return index (n,), image (n, 3) and height (n,) of the nearest surface for each of `points` (n, 3)."""

    def near(self, points: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return point (m,), body (m,) and offset (m, 3) for all images whose surface is nearer than `height`."""


@dataclass(frozen=True, eq=False)
class Solids:
    """What is to be seen of some bodies. Lengths in a."""

    shape: Literal["ellipsoid", "box"]
    centers: np.ndarray  # (n, 3)
    half_sizes: np.ndarray  # (n, 3), along the axes
    axes: np.ndarray  # (3, 3), rows, right-handed


class Bodies(ABC):
    """Bodies of one kind, fixed in space: all that is known of that kind alone. Lengths in a.

    `which` is a number among them, or numbers (n,). `offset` is a swimmer's centre minus a body's.
    """

    SURFACE: ClassVar[Surface]  # as the kernel is compiled for
    ROUND: ClassVar[bool]  # whether swimmers can go all the way round a body: wind around it, and be hidden by it
    ENDLESS: ClassVar[bool]  # whether a body goes on beyond every picture, so that a part of it is drawn

    centers: np.ndarray  # (n, 3); what offsets are measured from
    radii: np.ndarray  # (n,), of curvature; infinite where the surface is flat

    @property
    @abstractmethod
    def at_surface(self) -> np.ndarray:
        """What `distance` of `physics.surface` is at the surface of each, (n,): heights are distances less this."""

    @abstractmethod
    def search(self, box: np.ndarray) -> Search:
        """Return the search in a `box` (3,) whose edges are 0 along axes that do not repeat."""

    def to_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of space in the axes in which the device has offsets and directors: the same."""
        return vectors

    def from_device(self, vectors: np.ndarray) -> np.ndarray:
        """Return `vectors` (n, 3) of the device in the axes of space."""
        return vectors

    @abstractmethod
    def stance(self, offset: np.ndarray, director: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height and sine of the pitch, both (n,), of swimmers at `offset` (n, 3) with `director` (n, 3)."""

    @abstractmethod
    def above(self, which: int, direction: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
        """Return points (n, 3) at `height` above a body in unit `direction`s (n, 3), and the normals there."""

    @abstractmethod
    def bulk(self, dimensions: int) -> np.ndarray:
        """Return the volume (3-D) or area (2-D) that each takes from the box, (n,)."""

    def nearest_gaps(self, box: np.ndarray) -> np.ndarray:
        """Return the gap from each (n,) to the nearest other; of none (0,) for a kind whose gaps are not known."""
        return np.zeros(0)

    def narrow_gaps(self, width: float, box: np.ndarray) -> np.ndarray:
        """Return the gaps (m,) below `width` between two of them, images included, each pair once, sorted."""
        return np.zeros(0)

    @abstractmethod
    def outline(self, points: np.ndarray) -> np.ndarray:
        """Return corners (m, 3) of what is to be seen of them beside `points` (n, 3)."""

    @abstractmethod
    def solids(self, which: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Solids:
        """Return what is drawn of some (n,), where a picture shows space from `lower` (3,) to `upper` (3,)."""

    @abstractmethod
    def name(self, which: int, number: int) -> str:
        """What messages call one, whose `number` among all bodies of the field is given."""

    @abstractmethod
    def described(self) -> str:
        """What `check` calls all of them."""

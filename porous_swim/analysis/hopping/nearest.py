"""Whether hops lead to nearest neighbours: by shells of distances where there are such, else by cells that touch."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pyarrow as pa

from porous_swim.analysis.hopping.neighbours import MOST_POINTS, Neighbours, neighbours
from porous_swim.analysis.hopping.shells import ShellEnds, shell_ends

NEAREST, SECOND, FARTHER = 1, 2, 3  # shells
UNKNOWN = (
    "Distances between the colloids form no shells, and their cells are not known: they are too many "
    f"(above {MOST_POINTS:,} with their images), or all but in a line."
)


class Nearest:
    """Neighbourhoods in a field of colloids; what is expensive is found when it is first asked for."""

    def __init__(self, colloids: pa.Table, *, box: tuple[float, float, float]) -> None:
        self._colloids, self._box = colloids, box

    @cached_property
    def _ends(self) -> ShellEnds:
        return shell_ends(self._colloids, box=self._box)

    @cached_property
    def _neighbours(self) -> Neighbours | None:
        return neighbours(self._colloids, box=self._box)

    @property
    def unknown(self) -> bool:
        """Whether there is no telling."""
        return np.isnan(self._ends.first) and self._neighbours is None

    def among(self, first: np.ndarray, second: np.ndarray, image: np.ndarray, length: np.ndarray) -> np.ndarray:
        """Which bonds, (n,) bool, join nearest neighbours; none where that is `unknown`.

        Bonds are from colloids (n,) to colloids (n,) in relative images (n, 3), of lengths (n,) in a.
        """
        if len(length) == 0:
            return np.zeros(0, bool)
        if np.isfinite(self._ends.first):
            return np.asarray(length <= self._ends.first)
        return np.zeros(len(length), bool) if self._neighbours is None else self._neighbours.have(first, second, image)

    def shells(self, length: np.ndarray) -> np.ndarray:
        """The shell of bonds of lengths (n,), a: `NEAREST`, `SECOND` or `FARTHER`, (n,); NaN where there are none."""
        shell = np.full(len(length), np.nan)
        if len(length):
            shell[length <= self._ends.first] = NEAREST
            shell[(length > self._ends.first) & (length <= self._ends.second)] = SECOND
            shell[length > self._ends.second] = FARTHER
        return shell

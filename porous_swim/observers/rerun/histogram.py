"""A histogram of values whose range nobody knows beforehand, in bounded memory."""

from __future__ import annotations

import numpy as np

from porous_swim.core.state import State

MAX_BINS = 64  # before a merge: 32 to 64 bins are shown of a full range, enough to see a shape


class GrowingHistogram:
    """Counts in equal bins that double in width whenever they would be more than `MAX_BINS`.

    Where values are whole multiples of `resolution` (`discrete`) none lies on an edge, and each bin holds
    equally many of them: bins that ignore the step of the times they count show a comb. Every value stays
    counted.
    """

    def __init__(self, *, resolution: float, discrete: bool) -> None:
        self._resolution = resolution
        self._shift = 0.5 if discrete else 0.0  # of a resolution: edges between the possible values
        self._n_merged = 1  # resolutions in a bin, a power of two
        self._first = 0  # index of the first bin; an index counts bins from the origin
        self.counts = np.zeros(0, dtype=np.int64)  # (n_bins,)

    @property
    def width(self) -> float:
        """Width of a bin, in the unit of the values."""
        return self._n_merged * self._resolution

    @property
    def edges(self) -> np.ndarray:
        """Edges of the bins, (n_bins + 1,)."""
        index = np.arange(self._first, self._first + len(self.counts) + 1)
        return index * self.width - self._shift * self._resolution

    def add(self, values: np.ndarray) -> None:
        """Count `values`, (n,)."""
        if len(values) == 0:
            return
        index = np.floor(values / self._resolution + self._shift).astype(np.int64)
        while self._n_bins(index // self._n_merged) > MAX_BINS:
            self._merge()
        index //= self._n_merged
        first, last = int(index.min()), int(index.max()) + 1
        if len(self.counts):
            first, last = min(first, self._first), max(last, self._first + len(self.counts))
        counts = np.bincount(index - first, minlength=last - first)
        offset = self._first - first if len(self.counts) else 0
        counts[offset : offset + len(self.counts)] += self.counts
        self._first, self.counts = first, counts

    def state(self) -> dict[str, np.ndarray]:
        """Counts and bins."""
        return {"counts": self.counts, "first": np.array(self._first), "n_merged": np.array(self._n_merged)}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another histogram of the same values."""
        self.counts = state["counts"].copy()
        self._first, self._n_merged = int(state["first"]), int(state["n_merged"])

    def _n_bins(self, index: np.ndarray) -> int:
        first, last = int(index.min()), int(index.max()) + 1
        if len(self.counts):
            first, last = min(first, self._first), max(last, self._first + len(self.counts))
        return last - first

    def _merge(self) -> None:
        padded = np.concatenate([np.zeros(self._first % 2, dtype=np.int64), self.counts])
        padded = np.concatenate([padded, np.zeros(len(padded) % 2, dtype=np.int64)])
        self.counts = padded.reshape(-1, 2).sum(axis=1)
        self._first //= 2
        self._n_merged *= 2

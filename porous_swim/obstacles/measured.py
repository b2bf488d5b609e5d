"""Colloids as they were measured: rounded digits, overlaps, detections of one bead as several. Lengths in a."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from porous_swim.core.parts import KeyedError
from porous_swim.core.scales import Scales, told
from porous_swim.obstacles.nearest import NearestSphere, wrap

Overlaps = Literal["error", "shrink", "drop"]
_SAME_BEAD = 0.5  # of the smaller radius: centres nearer than that are no two beads that touch
_EMPTY = 0.25  # of an edge of the box: without colloids it is noteworthy
_FEW = 10  # colloids, of which the extent says little


@dataclass(frozen=True, eq=False)
class Beads:
    """Spheres and what has been done to them."""

    centers: np.ndarray  # (n, 3)
    radii: np.ndarray  # (n,)
    scales: Scales | None = None  # what a is in the laboratory
    notes: tuple[str, ...] = ()  # sentences

    def noted(self, note: str, *, centers: np.ndarray | None = None, radii: np.ndarray | None = None) -> Beads:
        """The same with other centres or radii, and a sentence more."""
        centers, radii = self.centers if centers is None else centers, self.radii if radii is None else radii
        return replace(self, centers=centers, radii=radii, notes=(*self.notes, note))

    def told(self, length: float, digits: str = ".4g") -> str:
        """A length in a message, in um as well where a is known."""
        return told(length, "a", self.scales, digits=digits)


def merged(beads: Beads, distance: float, *, box: np.ndarray) -> Beads:
    """Make one of all detections that are joined by centres nearer than `distance`: mean place, mean radius."""
    n = len(beads.radii)
    first, second, offset, apart = _pairs(beads.centers, np.full(n, 0.5 * distance), box)
    near = apart < distance
    first, second, offset = first[near], second[near], offset[near]
    n_groups, group = connected_components(
        coo_array((np.ones(len(first)), (first, second)), shape=(n, n)), directed=False
    )
    if n_groups == n:
        return beads
    leader = np.unique(group, return_index=True)[1]
    shift = beads.centers - beads.centers[leader[group]]
    edge = np.where(box > 0.0, box, np.inf)
    shift -= np.rint(shift / edge) * np.where(box > 0.0, box, 0.0)
    size = np.bincount(group)
    mean = np.stack([np.bincount(group, shift[:, axis]) / size for axis in range(3)], axis=1)
    note = f"{n:,} detections were merged into {n_groups:,} colloids (obstacles.merge {beads.told(distance)})"
    return beads.noted(note, centers=beads.centers[leader] + mean, radii=np.bincount(group, beads.radii) / size)


def resolved(beads: Beads, overlaps: Overlaps, *, tolerance: float, box: np.ndarray, name: str) -> Beads:
    """Deal with pairs that overlap by more than `tolerance` of their summed radii; else a `KeyedError`.

    `name` is that of the table.
    """
    radii = beads.radii
    first, second, _, apart = _pairs(beads.centers, radii, box)
    reach = radii[first] + radii[second]
    share = (reach - apart) / reach
    accepted = (share > 1e-9) & (share <= tolerance)
    deep = share > tolerance
    if accepted.any():
        beads = beads.noted(
            f"{accepted.sum():,} pairs of colloids overlap by up to {_percent(share[accepted].max())} of their summed "
            f"radii, no more than obstacles.tolerance ({_percent(tolerance)}), and are taken as they are"
        )
    if not deep.any():
        return beads
    first, second, apart, share = first[deep], second[deep], apart[deep], share[deep]
    if overlaps == "drop":
        kept = _kept(radii, first, second)
        dropped = f"{np.sum(~kept):,} of {len(radii):,} colloids"
        note = f"{dropped} were dropped, as they overlap larger or equal ones (obstacles.overlaps)"
        return beads.noted(note, centers=beads.centers[kept], radii=radii[kept])
    same = apart < _SAME_BEAD * np.minimum(radii[first], radii[second])
    if same.any():
        raise KeyedError("obstacles.path", _duplicates(first[same], second[same], apart[same], beads, name))
    if overlaps == "error":
        raise KeyedError("obstacles.path", _overlap(first, second, apart, share, beads))
    factor = np.ones(len(radii))
    for one in (first, second):  # the sum of two radii is then at most the distance
        np.minimum.at(factor, one, 1.0 - share)
    return beads.noted(
        f"{np.sum(factor < 1.0):,} of {len(radii):,} colloids were shrunk, by up to {_percent(1.0 - factor.min())}, "
        "until they overlap no more (obstacles.overlaps)",
        radii=radii * factor,
    )


def compared_with_box(beads: Beads, *, box: np.ndarray) -> Beads:
    """Say which colloids lie outside of the box, and where it is much larger than the table."""
    for axis, edge in zip(range(3), box, strict=True):
        x, name = beads.centers[:, axis], "xyz"[axis]
        if edge <= 0.0:
            continue
        spread = (
            f"the table has centres from {x.min():.6g} to {beads.told(x.max(), '.6g')} in {name}, and the box goes "
            f"from 0 to {beads.told(edge, 'g')}"
        )
        outside = int(np.sum((x < 0.0) | (x > edge)))
        empty = edge - (x.max() - x.min()) - 2.0 * float(beads.radii.max())
        if outside:
            beads = beads.noted(
                f"{outside:,} of {len(x):,} colloids lie outside of the box and are moved into it: {spread}"
            )
        elif len(x) >= _FEW and empty > _EMPTY * edge:
            beads = beads.noted(f"a part of the box has no colloids, {beads.told(empty)} wide: {spread}")
    return beads


def _pairs(
    centers: np.ndarray, radii: np.ndarray, box: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """All pairs of spheres that overlap: numbers first < second, offset between centres, its length; by image."""
    wrapped = wrap(centers, box)
    spheres = NearestSphere(wrapped, radii, box)
    size = np.floor(np.log2(radii))
    found = []
    for value in np.unique(size):  # of like size, so that the search goes no further than these reach
        own = np.flatnonzero(size == value)
        point, sphere, offset = spheres.near(wrapped[own], float(radii[own].max()))
        found.append((own[point], sphere, offset))
    first, second, offset = (np.concatenate(part) for part in zip(*found, strict=True))
    apart = np.linalg.norm(offset, axis=1)
    touch = (first < second) & (apart < radii[first] + radii[second])
    return first[touch], second[touch], offset[touch], apart[touch]


def _kept(radii: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Which colloids stay, taken from the largest to the smallest: (n,) bool."""
    order = np.argsort(-radii, kind="stable")
    rank = np.empty(len(radii), dtype=np.int64)
    rank[order] = np.arange(len(radii))
    early, late = np.minimum(rank[first], rank[second]), np.maximum(rank[first], rank[second])
    kept = np.ones(len(radii), dtype=bool)
    for i in np.argsort(late, kind="stable"):
        if kept[order[early[i]]]:
            kept[order[late[i]]] = False
    return kept


def _duplicates(first: np.ndarray, second: np.ndarray, apart: np.ndarray, beads: Beads, name: str) -> str:
    count = len(np.unique(second))
    merge = 1.01 * float(apart.max()) or 0.01 * float(beads.radii.min())
    return (
        f"{name}: {count:,} duplicate{'s' * (count > 1)}: centres nearer than half a radius to those of earlier rows, "
        f"such as rows {first[0] + 1} and {second[0] + 1} below the header, {_in_a(apart[0], beads)} apart; give "
        f"obstacles.merge, the distance below which detections are one, here more than {_in_a(merge, beads, '.2g')}"
    )


def _overlap(first: np.ndarray, second: np.ndarray, apart: np.ndarray, share: np.ndarray, beads: Beads) -> str:
    centers, radii = beads.centers, beads.radii
    worst = int(np.argmax(share))
    i, j = int(first[worst]), int(second[worst])
    through = " through the periodic boundary" if np.linalg.norm(centers[i] - centers[j]) > apart[worst] * 1.001 else ""
    pairs = "1 pair overlaps" if len(first) == 1 else f"{len(first):,} pairs overlap"
    return (
        f"colloids {i} and {j} overlap by {beads.told(radii[i] + radii[j] - apart[worst], '.6g')}{through}: centres "
        f"{beads.told(apart[worst], '.6g')} apart, radii {beads.told(radii[i], 'g')} and {beads.told(radii[j], 'g')}; "
        f"{pairs}, by up to "
        f"{_percent(share.max())} of their summed radii: set obstacles.overlaps to shrink or drop, or raise "
        "obstacles.tolerance"
    )


def _in_a(length: float, beads: Beads, digits: str = ".4g") -> str:
    """A length that is to go into a scene or was found in a table of it: always with its unit."""
    return beads.told(length, digits) if beads.scales else f"{length:{digits}} a"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"

"""The network of hops: which colloid follows which, and whether hops go both ways alike.

A link leads from a colloid to an image of one, so that a box of one colloid still has all its neighbours. Without the
images the network is the matrix between the colloids of the box: `hop_counts`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from scipy.special import chdtrc

from porous_swim.analysis.columns import column, needs, vectors
from porous_swim.analysis.estimates import Swimmers
from porous_swim.analysis.hopping.hop_table import HOP_ENDS

_BOND = ("bond_x", "bond_y", "bond_z", "length", "shell")


@needs(hops=" ".join(("swimmer", *HOP_ENDS, *_BOND)))
def hop_network(hops: pa.Table) -> pa.Table:
    """One row for each link that a `hop_table` uses, sorted.

    `n_hops` counts its hops, `probability` is their share among those that leave the same colloid, with its
    `standard_error` over swimmers (infinitesimal jackknife; null where one swimmer made them all). `image_*`, `bond_*`,
    `length` and `shell` are those of the hops.
    """
    return _links(hops, HOP_ENDS, _BOND)


@needs(hops=" ".join(("swimmer", *HOP_ENDS[:2])))
def hop_counts(hops: pa.Table) -> pa.Table:
    """The same for pairs of colloids in the box, whatever their images: `from_colloid`, `to_colloid`, `n_hops`, ..."""
    return _links(hops, HOP_ENDS[:2], ())


def _links(hops: pa.Table, ends: tuple[str, ...], kept: tuple[str, ...]) -> pa.Table:
    keys = vectors(hops, *ends)
    first, link = _numbered(keys)
    links = keys[first]
    _, source_of_link = np.unique(links[:, 0], return_inverse=True)  # links are sorted by the colloid left
    source = source_of_link.reshape(-1)[link]
    count, leaving = np.bincount(link, minlength=len(links)), np.bincount(source)
    probability = count / leaving[source_of_link]
    error = _error_of_shares(link, source, source_of_link, probability, column(hops, "swimmer"))
    columns = {name: pa.array(links[:, i], hops.schema.field(name).type) for i, name in enumerate(ends)}
    columns |= {name: hops.column(name).take(pa.array(first)) for name in kept}
    columns |= {"n_hops": pa.array(count), "probability": pa.array(probability)}
    return pa.table({**columns, "standard_error": pa.array(error, from_pandas=True)})


def _numbered(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First row of each distinct row of keys (n, k), in order, and the number of each row's among those, (n,).

    As np.unique along an axis, which compares rows byte by byte and takes ten times as long.
    """
    number = first = np.zeros(len(keys), np.int64)
    for key in keys.T:
        _, own = np.unique(key, return_inverse=True)
        paired = number * (int(own.max(initial=0)) + 1) + own.reshape(-1)
        _, first, number = np.unique(paired, return_index=True, return_inverse=True)
        number = number.reshape(-1)
    return first, number


def _error_of_shares(
    link: np.ndarray, source: np.ndarray, source_of_link: np.ndarray, share: np.ndarray, swimmer: np.ndarray
) -> np.ndarray:
    """Standard error of each link's share, (n_links,), from what each swimmer's hops from its colloid add to it."""
    swimmers = Swimmers.of(swimmer)
    n_links, n_sources = len(source_of_link), int(source.max(initial=-1)) + 1
    left, n_left = np.unique(swimmers.group * n_sources + source, return_counts=True)
    used, n_used = np.unique(swimmers.group * n_links + link, return_counts=True)
    which = used % n_links
    out_of = n_left[np.searchsorted(left, used // n_links * n_sources + source_of_link[which])]
    squares = np.bincount(which, weights=n_used.astype(float) ** 2, minlength=n_links)
    mixed = np.bincount(which, weights=n_used.astype(float) * out_of, minlength=n_links)
    all_left = np.bincount(left % max(n_sources, 1), weights=n_left.astype(float) ** 2, minlength=n_sources)
    n_leavers = np.bincount(left % max(n_sources, 1), minlength=n_sources)[source_of_link]
    total = np.maximum(squares - 2.0 * share * mixed + share**2 * all_left[source_of_link], 0.0)
    factor = np.divide(n_leavers, n_leavers - 1, out=np.full(n_links, np.nan), where=n_leavers > 1)
    return np.sqrt(factor * total) / np.bincount(source, minlength=n_sources)[source_of_link]


@needs(network="from_colloid to_colloid n_hops", colloids="colloid")
def hop_degrees(network: pa.Table, colloids: pa.Table) -> pa.Table:
    """One row for each colloid: `n_out`, `n_in` hops that leave and enter it, `out_degree`, `in_degree` links used."""
    number = np.sort(column(colloids, "colloid"))
    n, count = len(number), column(network, "n_hops")
    start, end = column(network, "from_colloid"), column(network, "to_colloid")
    return pa.table(
        {
            "colloid": number,
            "n_out": np.bincount(start, weights=count, minlength=n).astype(np.int64),
            "n_in": np.bincount(end, weights=count, minlength=n).astype(np.int64),
            "out_degree": np.bincount(start, minlength=n),
            "in_degree": np.bincount(end, minlength=n),
        }
    )


@dataclass(frozen=True)
class Symmetry:
    """Bowker's test that hops go from i to j as often as from j to i."""

    chi_squared: float
    degrees_of_freedom: int  # pairs of opposite links with at least one hop
    p_value: float


@needs(network=" ".join((*HOP_ENDS, "n_hops")))
def hop_symmetry(network: pa.Table) -> Symmetry:
    """Test the links of a `hop_network` against their reverses.

    Takes hops for independent. Those of one swimmer are not: one that goes to and fro makes counts more equal than
    chance, so that the test finds an asymmetry later. Counts below 5 a pair make chi^2 rough.
    Source: Bowker, J. Am. Stat. Assoc. 43, 572 (1948).
    """
    forward = vectors(network, *HOP_ENDS).astype(np.int64)
    backward = np.concatenate([forward[:, 1::-1], -forward[:, 2:]], axis=1)
    difference = forward - backward
    leading = difference[np.arange(len(forward)), np.argmax(difference != 0, axis=1)]
    turned = leading > 0
    pairs, pair = np.unique(np.where(turned[:, None], backward, forward), axis=0, return_inverse=True)
    count = column(network, "n_hops")
    there, back = (
        np.bincount(pair.reshape(-1), weights=np.where(way, count, 0), minlength=len(pairs))
        for way in (~turned, turned)
    )
    chi_squared = float(np.sum((there - back) ** 2 / (there + back)))
    p_value = float(chdtrc(len(pairs), chi_squared)) if len(pairs) else float("nan")
    return Symmetry(chi_squared, len(pairs), p_value)

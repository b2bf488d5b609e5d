"""Encounters in groups: every statistic of a table is one of each group too.

A part of a table keeps its `TableInfo`: fractions of time and rates are still per swimmer of the whole run. What
depends on a swimmer's next encounter (flights, hops, escape-pitch times) needs the whole table: take the whole
`Lifetimes` and select from them with `encounter_radii`. Sets of parameters are runs of their own, with tables and
swimmers of their own: `porous_swim.sweep`.
"""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import check_columns, column, needs
from porous_swim.analysis.places import radii_of


@needs(encounters="colloid", colloids="colloid radius")
def encounter_radii(encounters: pa.Table, colloids: pa.Table) -> np.ndarray:
    """Radius of the colloid of each encounter, (n_encounters,), a."""
    return radii_of(colloids)[column(encounters, "colloid")]


@needs(encounters="colloid", colloids="colloid radius")
def by_radius(encounters: pa.Table, colloids: pa.Table) -> dict[float, pa.Table]:
    """The encounters with colloids of each radius that was met, smallest first."""
    return _parts(encounters, encounter_radii(encounters, colloids))


def by_column(table: pa.Table, name: str) -> dict[float, pa.Table]:
    """The rows for each value of one column, smallest first: of each colloid, say."""
    check_columns(table, (name,), of="by_column: table")
    return _parts(table, column(table, name))


def _parts(table: pa.Table, key: np.ndarray) -> dict[float, pa.Table]:
    values, group = np.unique(key, return_inverse=True)
    order = np.argsort(group.reshape(-1), kind="stable")
    bounds = np.concatenate([[0], np.cumsum(np.bincount(group.reshape(-1), minlength=len(values)))])
    ordered = table.take(pa.array(order))
    return {
        value.item(): ordered.slice(begin, end - begin)
        for value, begin, end in zip(values, bounds[:-1], bounds[1:], strict=True)
    }

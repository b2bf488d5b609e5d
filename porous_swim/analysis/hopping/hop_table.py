"""Hops row by row. Lengths in a, times in a/U, angles in rad."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs
from porous_swim.analysis.estimates import Estimate, Swimmers, ratio_of_sums
from porous_swim.analysis.hopping.hops import MOVES, hop_vectors, hops
from porous_swim.analysis.hopping.nearest import FARTHER, NEAREST, SECOND, Nearest
from porous_swim.results.tables import TableInfo, make_table

HOP_ENDS = ("from_colloid", "to_colloid", "image_x", "image_y", "image_z")


def _fields(names: str, unit: str, *, nullable: bool = False) -> list[pa.Field]:
    return [pa.field(name, pa.float64(), nullable=nullable, metadata={"unit": unit}) for name in names.split()]


HOPS_SCHEMA = pa.schema(
    [
        *(pa.field(name, pa.int32()) for name in ("swimmer", *HOP_ENDS)),
        *_fields("end_time start_time time", "a/U"),
        *_fields("bond_x bond_y bond_z length displacement", "a"),
        *_fields("azimuth polar_angle", "rad"),
        *_fields("turning_angle signed_turning_angle", "rad", nullable=True),
        *_fields("residence", "a/U", nullable=True),
        pa.field("shell", pa.int32()),
    ]
)


@needs(encounters=MOVES, colloids="colloid x y z radius")
def hop_table(encounters: pa.Table, colloids: pa.Table) -> pa.Table:
    """One row for each hop, swimmer by swimmer in order of time. The encounters need their `TableInfo`.

    `image_*` is the image entered less the image left; `bond_*` the vector from centre to centre over images and
    `length` its length; `displacement` the distance from exit to entry; `time` from the end of one encounter to the
    start of the next. `azimuth` and `polar_angle` are those of the bond, about and from +z. `turning_angle`, 0 to pi,
    is between this bond and that of the swimmer's hop before (returns between them do not matter), null for its
    first; `signed_turning_angle`, -pi to pi, is counterclockwise, null in 3-D. `residence` is the length of
    the encounter that was left. `shell`: 1 to a nearest neighbour of the colloid left, 2 to one in the second shell
    of distances, 3 farther; null where distances form no shells, as in disordered fields (see `shell_ends`).
    """
    info = TableInfo.of(encounters)
    hopped = hops(encounters)
    bond = hop_vectors(hopped, colloids, box=info.box)
    length = np.linalg.norm(bond, axis=1)
    turn, signed = _turns(bond, hopped.swimmer)
    image = hopped.to_image - hopped.from_image
    columns = {
        "swimmer": hopped.swimmer, "from_colloid": hopped.from_colloid, "to_colloid": hopped.to_colloid,
        "end_time": hopped.end_time, "start_time": hopped.start_time, "time": hopped.time,
        "length": length, "displacement": np.linalg.norm(hopped.displacement, axis=1),
        "azimuth": np.arctan2(bond[:, 1], bond[:, 0]),
        "polar_angle": np.arctan2(np.hypot(bond[:, 0], bond[:, 1]), bond[:, 2]),
        "turning_angle": turn,
        "signed_turning_angle": signed if info.dimensions == 2 else np.full(len(bond), np.nan),
        "residence": hopped.residence, "shell": Nearest(colloids, box=info.box).shells(length),
        **{f"image_{axis}": image[:, i] for i, axis in enumerate("xyz")},
        **{f"bond_{axis}": bond[:, i] for i, axis in enumerate("xyz")},
    }  # fmt: skip
    return make_table(HOPS_SCHEMA, columns, info=info)


def _turns(bond: np.ndarray, swimmer: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle from the hop before, (n,): unsigned, and about +z; NaN where the swimmer made none before."""
    unsigned, signed = np.full(len(bond), np.nan), np.full(len(bond), np.nan)
    later = np.flatnonzero(swimmer[1:] == swimmer[:-1]) + 1
    before, after = bond[later - 1], bond[later]
    cross, along = np.cross(before, after), np.sum(before * after, axis=1)
    unsigned[later] = np.arctan2(np.linalg.norm(cross, axis=1), along)
    signed[later] = np.arctan2(cross[:, 2], along)
    return unsigned, signed


@dataclass(frozen=True)
class Shells:
    """Shares of the hops by neighbourhood of the colloid left; errors are a jackknife over swimmers."""

    nearest: Estimate
    second: Estimate
    farther: Estimate


@needs(table="swimmer shell")
def hop_shells(table: pa.Table) -> Shells:
    """How many hops of a `hop_table` lead to nearest, to second-nearest, and to farther neighbours.

    None where distances form no shells; only the nearest where they form a first one alone.
    """
    shell, swimmers = column(table, "shell"), Swimmers.of(column(table, "swimmer"))
    counts, unknown = swimmers.sums(np.ones(len(shell))), np.isnan(shell)

    def share(value: int, *, known: bool) -> Estimate:
        if not known:
            return Estimate.none("")
        return Estimate(*ratio_of_sums(swimmers.sums(shell == value), counts), len(shell), 0, "")

    every = not unknown.any()
    return Shells(share(NEAREST, known=not unknown.all()), share(SECOND, known=every), share(FARTHER, known=every))

"""Scattering: by how much an encounter turns a swimmer that it does not bind. Lengths in a, angles in rad."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs, vectors
from porous_swim.analysis.places import centers_of, sphere_radii_of
from porous_swim.results.tables import TableInfo

_BOUND = 0.5  # turns: beyond, the angle, which is known up to full turns, says nothing of how the swimmer went
_ENCOUNTERS = (
    "swimmer colloid image_x image_y image_z start_time end_time start_censored end_censored winding "
    "entry_x entry_y entry_z entry_ex entry_ey entry_ez exit_ex exit_ey exit_ez"
)

_SCHEMA = pa.schema(
    [
        pa.field("swimmer", pa.int32()),
        pa.field("colloid", pa.int32()),
        *(pa.field(name, pa.float64(), metadata={"unit": "a"}) for name in ("radius", "impact_parameter")),
        pa.field("scattering_angle", pa.float64(), metadata={"unit": "rad"}),
        pa.field("length", pa.float64(), metadata={"unit": "a/U"}),
        pa.field("winding", pa.float64(), metadata={"unit": "turns"}),
    ]
)


@needs(encounters=_ENCOUNTERS, colloids="colloid x y z radius")
def scattering(encounters: pa.Table, colloids: pa.Table, *, most_turns: float = _BOUND) -> pa.Table:
    """One row for each completed encounter that wound at most `most_turns`, by default half a turn: it did not bind.

    `impact_parameter` is the distance from the colloid's centre to the line along the director at entry.
    `scattering_angle` is the angle from the director at entry to that at exit, positive when it was turned to the
    side on which the swimmer passes, as in `theory.scattering_angle`; 0 to pi unsigned where the impact
    parameter is 0. The theory's parameter is that of the straight line far away, before any flow bent it. The
    encounters need their `TableInfo`.

    Raises:
        ResultsError: a plane wall.
    """
    completed = ~(column(encounters, "end_censored") | column(encounters, "start_censored"))
    free = encounters.filter(pa.array(completed & (column(encounters, "winding") <= most_turns)))
    colloid = column(free, "colloid")
    image = vectors(free, "image_x", "image_y", "image_z") * np.asarray(TableInfo.of(encounters).box)
    offset = vectors(free, "entry_x", "entry_y", "entry_z") - centers_of(colloids)[colloid] - image
    before, after = (vectors(free, *(f"{end}_e{axis}" for axis in "xyz")) for end in ("entry", "exit"))
    beside = offset - np.sum(offset * before, axis=1, keepdims=True) * before
    turn = np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), np.sum(before * after, axis=1))
    columns = {
        "swimmer": column(free, "swimmer"),
        "colloid": colloid,
        "radius": sphere_radii_of(colloids)[colloid],
        "impact_parameter": np.linalg.norm(beside, axis=1),
        "scattering_angle": np.where(np.sum(after * beside, axis=1) < 0.0, -turn, turn),
        "length": column(free, "end_time") - column(free, "start_time"),
        "winding": column(free, "winding"),
    }
    return pa.table([pa.array(columns[field.name], field.type) for field in _SCHEMA], schema=_SCHEMA)

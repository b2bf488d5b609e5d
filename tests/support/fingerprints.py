"""Short runs of every kind, and a fingerprint of each column of what they leave.

Encounters and trajectories are compared to the bit: the kernel adds, multiplies, divides and takes roots in the order
that its source says, on every processor. What the host sums afterwards (time series, lags, summary) is rounded to nine
digits first, as NumPy and BLAS add in an order that depends on the processor.

    python -m tests.support.fingerprints          # which columns differ from tests/reference/fingerprints.json
    python -m tests.support.fingerprints --write  # after a change meant to change results: say so in the changelog
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

import porous_swim as ps
from porous_swim.running.batch import run_batch
from tests.support.engines import hexagonal, make_engine, released

REFERENCE = Path(__file__).parents[1] / "reference" / "fingerprints.json"
SENTENCES = ("reason", "warning")  # of a summary: words may change
DIGITS = 9  # of sums that the host makes: rounding of some 1e-13 turns a digit once in 10^4 numbers at the most

Prints = dict[str, str]  # column or statistic -> hash

CRYSTAL = {"layout": "hexagonal", "radius": 3.5, "spacing": 10.0, "cells": [4, 3]}
ONE = {"layout": "single", "radius": 6.0}
FCC = {"layout": "fcc", "radius": 5.0, "spacing": 16.0, "cells": [2, 2, 2]}
PLANE = {"dimensions": 2}
THERMAL = {"kind": "brownian", "translational_diffusion": 0.006}
GAUSSIAN = {"kind": "brownian", "translational_diffusion": 0.006, "variates": "gaussian"}
QUIET = {"kind": "none"}
PACKING = {"layout": "packing", "radius": [3.0, 5.0], "fractions": [2, 1], "packing_fraction": 0.2, "count": 40}
RODS = {"count": 48, "dipole_strength": 0.3, "aspect_ratio": 0.4}


def scene_of(
    obstacles: Mapping[str, Any], noise: Mapping[str, Any], *, domain: Mapping[str, Any] | None = None,
    swimmers: Mapping[str, Any] | None = None, run: Mapping[str, Any] | None = None, **sections: Any,
) -> ps.Scene:  # fmt: skip
    """A short run of few swimmers."""
    return ps.Scene.from_mapping(
        {
            "swimmers": {"count": 64, "dipole_strength": 0.8, **(swimmers or {})},
            "noise": noise,
            "obstacles": obstacles,
            "domain": domain or {},
            "run": {"time_step": 0.02, "duration": 40, "seed": 5, **(run or {})},
            "record": {"every": 2, "swimmers": 16, "trails": 0},
            **sections,
        }
    )


def _scenes() -> dict[str, ps.Scene]:
    """The scenes whose whole results are compared."""
    strong, start = {"dipole_strength": 4.0}, {"kind": "point", "position": [0, 0, 0]}
    drop = {"kind": "point", "position": [-9, 0, 6], "director": [2, 0, -1]}
    beam = {"kind": "beam", "origin": [-12, 0], "director": [1, 0], "width": 6}
    return {
        "crystal": scene_of(CRYSTAL, THERMAL, domain=PLANE, swimmers=strong),
        "crystal_euler": scene_of(CRYSTAL, THERMAL, domain=PLANE, swimmers=strong, run={"integrator": "euler"}),
        "crystal_double": scene_of(CRYSTAL, THERMAL, domain=PLANE, swimmers=strong, run={"precision": "f64"}),
        "crystal_gaussian": scene_of(CRYSTAL, GAUSSIAN, domain=PLANE, swimmers=strong),
        "crystal_located": scene_of(CRYSTAL, QUIET, domain=PLANE, swimmers={"count": 24, "dipole_strength": 0.3}),
        "lattice": scene_of(FCC, THERMAL),
        "lattice_located": scene_of(FCC, QUIET, swimmers={"count": 24}),
        "packing": scene_of(PACKING, THERMAL),
        "rods": scene_of({**CRYSTAL, "spacing": 12.0}, THERMAL, domain=PLANE, swimmers=RODS),
        "rods_in_space": scene_of(FCC, THERMAL, swimmers=RODS),
        "rods_euler": scene_of(FCC, GAUSSIAN, swimmers=RODS, run={"integrator": "euler", "time_step": 0.005}),
        "rods_located": scene_of(ONE, QUIET, domain=PLANE, swimmers=RODS | {"count": 12, "release": beam}),
        "wall": scene_of({"layout": "wall", "normal": [0, 0, 1]}, THERMAL, swimmers={"release": drop}),
        "no_flow": scene_of(FCC, THERMAL, hydrodynamics={"kind": "none"}),
        "free_space": scene_of({"layout": "none"}, THERMAL, swimmers={"release": start}),
        "flights": scene_of({**FCC, "spacing": 40.0}, THERMAL, run={"flight_step": 0.5, "duration": 80}),
    }


def _run(scene: ps.Scene) -> Prints:
    return prints_of(ps.run(scene))


def _batch() -> Prints:
    """Two colloids and three swimmer kinds in one launch."""
    scenes = [
        scene_of(
            {"layout": "single", "radius": radius}, THERMAL,
            swimmers={"count": 24, "dipole_strength": alpha, "release": {"kind": "parallel", "height": 1.001}},
        )
        for radius, alpha in ((6.0, 0.8), (6.0, 1.6), (12.0, 0.8))
    ]  # fmt: skip
    members = enumerate(run_batch(scenes))
    return {f"{k}.{name}": exact(column) for k, member in members for name, column in member.encounters.items()}


def _short_log() -> Prints:
    """A log of four rows, which is full at almost every step at which something happens."""
    field = hexagonal()
    engine = make_engine(field, *released(field, 64), alpha=4.0, D=0.02, log_rows=4)
    engine.advance(4000)
    return {name: exact(column) for name, column in engine.encounters().items()}


def prints_of(results: ps.Results) -> Prints:
    """The fingerprints of a run: to the bit where the kernel made the numbers, else to nine digits."""
    tables = {name: getattr(results, name) for name in ("encounters", "trajectory", "timeseries", "lags")}
    prints = {}
    for name, table in tables.items():
        hashed = exact if name in ("encounters", "trajectory") else rounded
        prints |= {f"{name}.{column}": hashed(values_of(table[column])) for column in table.column_names}
    statistics = {key: value for key, value in results.summary.items() if key not in ("provenance", "warnings")}
    return prints | {f"summary.{key}": digest(_told(value)) for key, value in statistics.items()}


def values_of(column: pa.ChunkedArray) -> np.ndarray:
    """A column with NaN where it has no value."""
    return column.to_numpy(zero_copy_only=False)


def exact(column: np.ndarray) -> str:
    """Hash of the bits; every NaN is one."""
    values = np.ascontiguousarray(column)
    if values.dtype == object:  # booleans with nulls
        return digest(json.dumps(values.tolist()))
    if values.dtype.kind == "f":
        values = np.where(np.isnan(values), np.array(np.nan, values.dtype), values) + np.array(0.0, values.dtype)
    return hashlib.sha256(values.tobytes()).hexdigest()[:16]


def rounded(column: np.ndarray) -> str:
    """Hash of the numbers to `DIGITS` digits."""
    return digest(" ".join(f"{number:.{DIGITS - 1}e}" for number in np.asarray(column, float).ravel() + 0.0))


def digest(text: str) -> str:
    """Hash of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _told(value: Any) -> str:
    """A statistic as text, numbers to `DIGITS` digits."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_told(value[key])}" for key in sorted(value) if key not in SENTENCES) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_told, value)) + "]"
    return f"{value + 0.0:.{DIGITS - 1}e}" if isinstance(value, float) else str(value)


RUNS: dict[str, Callable[[], Prints]] = {
    **{name: partial(_run, scene) for name, scene in _scenes().items()},
    "batch": _batch,
    "short_log": _short_log,
}


def stored() -> dict[str, Prints]:
    """The fingerprints that were kept."""
    return json.loads(REFERENCE.read_text(encoding="utf-8"))


def differences(found: Prints, kept: Prints) -> list[str]:
    """Names of columns that differ, are missing or are new."""
    return sorted(name for name in found.keys() | kept.keys() if found.get(name) != kept.get(name))


def main() -> None:
    """Compare, or write anew."""
    found = {name: run() for name, run in RUNS.items()}
    if "--write" in sys.argv:
        REFERENCE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return
    kept = stored()
    for name, prints in found.items():
        print(name, ", ".join(differences(prints, kept.get(name, {}))) or "unchanged")


if __name__ == "__main__":
    main()

"""Scenes of the validation, from plain data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import porous_swim as ps

NO_FRAMES = {"swimmers": 0, "trails": 0}


def make_scene(
    *, swimmers: dict[str, Any], obstacles: dict[str, Any], dimensions: int, run: dict[str, Any], D: float = 0.0,
    record: dict[str, Any] | None = None, folder: Path = Path(), **sections: dict[str, Any],
) -> ps.Scene:  # fmt: skip
    """A scene; `D` brings noise with D_r = 3 D/4 unless `sections` has `noise`. By default only the last frame."""
    noise = {"kind": "brownian", "translational_diffusion": D} if D > 0.0 else {"kind": "none"}
    data = {
        "swimmers": swimmers, "noise": noise, "obstacles": obstacles, "domain": {"dimensions": dimensions}, "run": run,
        "record": {"every": run["duration"], **NO_FRAMES} if record is None else record, **sections,
    }  # fmt: skip
    return ps.Scene.from_mapping(data, folder=folder)


def one_swimmer(
    radius: float, dipole_strength: float, position: list[float], *, time_step: float, duration: float,
    integrator: str = "euler",
) -> ps.Scene:  # fmt: skip
    """One swimmer without noise that sets out along x, in the plane that it shares with the colloid's centre."""
    release = {"kind": "point", "position": position, "director": [1, 0]}
    return make_scene(
        swimmers={"count": 1, "dipole_strength": dipole_strength, "release": release},
        obstacles={"layout": "single", "radius": radius}, dimensions=2,
        run={"time_step": time_step, "duration": duration, "precision": "f64", "integrator": integrator},
        record={"every": duration, "swimmers": 1},
    )  # fmt: skip


LATTICES: dict[str, dict[str, Any]] = {
    "hexagonal_alpha4": {
        "alpha": 4.0, "D": 0.006, "dimensions": 2,
        "obstacles": {"layout": "hexagonal", "radius": 3.5, "spacing": 10.0, "cells": [4, 2]},
    },
    "fcc_3d": {
        "alpha": 0.8, "D": 0.002, "dimensions": 3,
        "obstacles": {"layout": "fcc", "radius": 5.0, "spacing": 16.0, "cells": [2, 2, 2]},
    },
}  # fmt: skip


def crystal(case: str, count: int, *, time_step: float, seed: int, integrator: str = "euler") -> ps.Scene:
    """Swimmers released all over a crystal, for 300 a/U."""
    lattice = LATTICES[case]
    return make_scene(
        swimmers={"count": count, "dipole_strength": lattice["alpha"], "release": {"kind": "uniform"}},
        obstacles=lattice["obstacles"], dimensions=lattice["dimensions"], D=lattice["D"],
        run={"time_step": time_step, "duration": 300.0, "seed": seed, "integrator": integrator},
        record={"every": 10.0, **NO_FRAMES},
    )  # fmt: skip

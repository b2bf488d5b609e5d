"""What a scene is, as numbers for machines: the work of `porous-swim check --json`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from porous_swim.commands.check import ready
from porous_swim.observers.rerun.recording_size import recording_size
from porous_swim.obstacles.field import ObstacleField
from porous_swim.running.costs import compiling_seconds, expected_seconds
from porous_swim.running.footprint import footprint
from porous_swim.scene.scene import Scene
from porous_swim.theory import critical_radius


def facts_of(scene: Scene) -> dict[str, Any]:
    """Return numbers in a, U and a/U, times of a CPU in s, sizes in bytes; and the warnings.

    All is done that a run does before its first step, so that it raises the same SceneError or DeviceError.
    """
    field, gamma = ready(scene), scene.swimmers.aspect_ratio
    units = scene.unit_system
    return {
        "scene": scene.name, "scene_id": scene.scene_id, "description": scene.description,
        "swimmers": {
            "count": scene.swimmers.count, "dipole_strength": scene.swimmers.dipole_strength, "aspect_ratio": gamma,
            "critical_radius": _critical_radius(scene),
        },
        "noise": {
            "translational_diffusion": scene.translational_diffusion,
            "rotational_diffusion": scene.rotational_diffusion,
        },
        "colloids": _colloids(field),
        "units": None if units is None else {"length_um": units.length, "time_s": units.time},
        "run": {
            "n_steps": scene.n_steps, "time_step": scene.run.time_step, "flight_step": scene.run.flight_step,
            "duration": scene.run.duration, "precision": scene.precision, "integrator": scene.integrator,
        },
        "record": {
            "n_frames": _n_frames(scene), "every": scene.record_period * scene.run.time_step,
            "swimmers": scene.n_recorded, "trails": scene.n_trails,
        },
        "costs": _costs(scene, field),
        "warnings": scene.warnings(field),
    }  # fmt: skip


def _n_frames(scene: Scene) -> int:
    return scene.n_steps // scene.record_period + 1


def _critical_radius(scene: Scene) -> float | None:
    """The radius above which a lone colloid captures for good, without noise; None where there is none."""
    if scene.hydrodynamics.kind == "none":
        return None
    try:
        found = critical_radius(scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio)
    except ValueError:
        return None
    return found if math.isfinite(found) else None


def _colloids(field: ObstacleField) -> dict[str, Any]:
    finite = field.radii[np.isfinite(field.radii)]
    return {
        "surface": field.surface, "count": len(field.radii), "dimensions": field.dimensions,
        "radius": [float(finite.min()), float(finite.max())] if len(finite) else None,
        "box": field.box.tolist() if field.periodic else None, "packing_fraction": field.packing_fraction,
    }  # fmt: skip


def _costs(scene: Scene, field: ObstacleField) -> dict[str, Any]:
    seconds, found = expected_seconds(scene, field), footprint(scene)
    size = recording_size(
        n_frames=_n_frames(scene), n_swimmers=scene.n_recorded, n_trails=scene.n_trails,
        rods=scene.swimmers.aspect_ratio < 1.0,
    )  # fmt: skip
    return {
        "seconds": {
            "swimming": seconds.swimming, "recording": seconds.recording, "total": seconds.total,
            "compiling_at_first": compiling_seconds(scene), "threads": seconds.n_threads,
        },
        "bytes": {
            "memory": round(found.host), "device": found.device, "disk": round(found.disk), "recording": round(size),
        },
    }  # fmt: skip

"""What a scene is, in lines for people: the work of `porous-swim check`."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from porous_swim.analysis.theory import critical_radius
from porous_swim.observers.recording import recording_size
from porous_swim.scene import Scene

NANOSECONDS = {"f32": 30.0, "f64": 60.0}  # a swimmer-step on one core of a present-day CPU, within a factor of two
BYTES = {"f32": 260, "f64": 400}  # a swimmer on the device


def describe(scene: Scene) -> list[tuple[str, str]]:
    """(label, text) for each thing worth knowing before the run; the last ones are warnings."""
    field = scene.place_obstacles()
    n, D, D_r = scene.swimmers.count, scene.translational_diffusion, scene.rotational_diffusion
    steps = scene.n_steps
    rows = [
        ("scene", f"{scene.name} ({scene.scene_id}){': ' + scene.description if scene.description else ''}"),
        ("swimmers", f"{n:,}, alpha {scene.swimmers.dipole_strength:g}, gamma {scene.swimmers.aspect_ratio:g}"),
        ("colloids", f"{len(field.radii):,} in {field.dimensions} dimensions, {_box(field.box)}"),
    ]
    if field.packing_fraction is not None:
        rows.append(("packing fraction", f"{field.packing_fraction:.4f}"))
    rows.append(("noise", f"1/D = {_inverse(D)}, 1/D_r = {_inverse(D_r)}" if D or D_r else "none"))
    rows += _critical(scene, field.radii)
    seconds = n * steps * NANOSECONDS[scene.precision] * 1e-9
    frames = steps // scene.record_period + 1
    size = recording_size(n_frames=frames, n_swimmers=scene.n_recorded, n_trails=scene.n_trails)
    rows += [
        ("steps", f"{steps:,} of {scene.run.time_step:g} a/U, {scene.precision}"),
        ("expected time", f"about {_duration(seconds)} of one CPU core, and some seconds to compile"),
        ("memory", f"{n * BYTES[scene.precision] / 1e6:.3g} MB for the swimmers on the device"),
        ("recording", f"about {size / 1e6:.2g} MB: {scene.n_recorded:,} swimmers, {frames:,} frames"),
    ]
    if (units := scene.unit_system) is not None:
        rows.append(("units", f"a = {units.length:g} um, U = {units.speed:g} um/s, a/U = {units.time:g} s"))
    return rows + [("warning", text) for text in scene.warnings(field)]


def _critical(scene: Scene, radii: np.ndarray) -> list[tuple[str, str]]:
    """A/A_c for the radii of the field: a lone colloid captures for good, without noise, above 1."""
    if len(radii) == 0 or scene.hydrodynamics.kind == "none":
        return []
    order: Literal["exact", "leading"] = "exact" if scene.swimmers.aspect_ratio == 1.0 else "leading"
    A_c = critical_radius(scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio, order=order)
    if math.isinf(A_c):
        return [("A_c", "infinite: without a dipole no radius captures")]
    values = np.unique(radii)
    ratios = ", ".join(f"{A / A_c:.3g} (A = {A:g})" for A in values[:6])
    if len(values) > 6:
        ratios = f"{values[0] / A_c:.3g} to {values[-1] / A_c:.3g} (A = {values[0]:g} to {values[-1]:g})"
    return [("A/A_c", f"{ratios}; A_c = {A_c:.5g} ({order})")]


def _box(box: np.ndarray) -> str:
    edges = " x ".join(f"{edge:g}" for edge in box if edge > 0.0)
    return f"periodic box {edges}" if edges else "open space"


def _inverse(rate: float) -> str:
    return f"{1.0 / rate:.4g} a/U" if rate > 0.0 else "infinite"


def _duration(seconds: float) -> str:
    return (
        f"{seconds:.0f} s"
        if seconds < 100
        else f"{seconds / 60:.0f} min"
        if seconds < 6000
        else f"{seconds / 3600:.1f} h"
    )

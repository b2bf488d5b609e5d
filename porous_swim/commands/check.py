"""What a scene is, in lines for people: the work of `porous-swim check`."""

from __future__ import annotations

import math

import numpy as np

from porous_swim.core.scales import Scales
from porous_swim.observers.rerun.recording_size import recording_size
from porous_swim.obstacles.cells import build_cells
from porous_swim.obstacles.field import ObstacleField
from porous_swim.running.costs import Seconds, compiling_seconds, expected_seconds
from porous_swim.running.footprint import amount, footprint, require_memory
from porous_swim.running.simulation import Start
from porous_swim.scene.scene import Scene
from porous_swim.scene.units import UnitSystem
from porous_swim.theory import critical_radius


def ready(scene: Scene) -> ObstacleField:
    """Do all that a run does before its first step, so that what it refuses is refused here; return the colloids."""
    require_memory(scene)
    field = Start.of(scene).field
    build_cells(field, reach=scene.encounter.escape_height)
    return field


def describe(scene: Scene) -> list[tuple[str, str]]:
    """(label, text) for each thing worth knowing before the run; the last ones are warnings.

    All is done that a run does before its first step, so that it raises the same SceneError or DeviceError.
    """
    field = ready(scene)
    rows = [("scene", f"{scene.name} ({scene.scene_id})")]
    if scene.description:
        rows.append(("", scene.description))
    rows += [("swimmers", _swimmers(scene)), ("noise", _noise(scene)), ("colloids", _colloids(field))]
    rows += [*_critical(scene, field), *_units(scene), *_costs(scene, field)]
    return rows + [("warning", text) for text in scene.warnings(field)]


def _swimmers(scene: Scene) -> str:
    alpha, gamma = scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio
    kind = "neutral swimmer" if alpha == 0.0 else "pusher" if alpha > 0.0 else "puller"
    shape = "spheres" if gamma == 1.0 else f"aspect ratio gamma = {gamma:g}"
    return f"{_count(scene.swimmers.count, kind)} with alpha = {alpha:.4g}, {shape}"


def _noise(scene: Scene) -> str:
    D, D_r = scene.translational_diffusion, scene.rotational_diffusion
    if D == D_r == 0.0:
        return "none"
    text = f"D = {D:.4g} (1/D = {_inverse(D)}), D_r = {D_r:.4g} (1/D_r = {_inverse(D_r)})"
    if (units := scene.unit_system) is None:
        return text
    (per_D, in_D), (per_D_r, in_D_r) = (_laboratory(units, unit) for unit in ("a U", "U/a"))
    return f"{text}; in the laboratory D = {D * per_D:.4g} {in_D}, D_r = {D_r * per_D_r:.4g} {in_D_r}"


def _colloids(field: ObstacleField) -> str:
    if len(field.radii) == 0:
        return f"none, in {field.dimensions} dimensions"
    edges = " x ".join(f"{edge:g}" for edge in field.box if edge > 0.0)
    place = f"a periodic box of {edges} a" if edges else "open space"
    kind = "area" if field.dimensions == 2 else "volume"
    share = "" if field.packing_fraction is None else f"; packing fraction ({kind}) {field.packing_fraction:.4f}"
    return f"{field.described()} in {field.dimensions} dimensions, in {place}{share}"


def _units(scene: Scene) -> list[tuple[str, str]]:
    if (units := scene.unit_system) is None:
        return []
    return [("units", f"a = {units.length:g} um, U = {units.speed:g} um/s, a/U = {units.time:g} s")]


def _laboratory(units: UnitSystem, unit: str) -> tuple[float, str]:
    """What one of `unit`, in a and U, is there."""
    found = Scales(units.length, units.time).physical(unit)
    assert found is not None
    return found


def _costs(scene: Scene, field: ObstacleField) -> list[tuple[str, str]]:
    steps, found, gamma = scene.n_steps, footprint(scene), scene.swimmers.aspect_ratio
    frames = steps // scene.record_period + 1
    size = recording_size(n_frames=frames, n_swimmers=scene.n_recorded, n_trails=scene.n_trails, rods=gamma < 1.0)
    end = f"{scene.run.duration:g} a/U"
    if (units := scene.unit_system) is not None:
        end += f" ({scene.run.duration * units.time:g} s)"
    return [
        ("run", f"{steps:,} steps of {scene.run.time_step:g} a/U to {end}, in {scene.precision}{_flights(scene)}"),
        ("expected time", _time(expected_seconds(scene, field), compiling_seconds(scene))),
        (
            "memory",
            f"about {amount(found.host)} at the peak, {amount(found.device)} of it for the swimmers on the device; "
            "a small run takes some 200 MB more where its kernel is not compiled yet",
        ),
        ("disk", f"about {amount(found.disk)} for recording and tables, and twice that while they are written"),
        ("recording", f"about {amount(size)}: {_count(scene.n_recorded, 'swimmer')}, {_count(frames, 'frame')}"),
    ]


def _flights(scene: Scene) -> str:
    return "" if scene.run.flight_step is None else f"; {scene.run.flight_step:g} a/U at once far from colloids"


def _time(seconds: Seconds, compiling: float) -> str:
    parts = f"swimming {_duration(seconds.swimming)}, recording {_duration(seconds.recording)}"
    return (
        f"about {_duration(seconds.total)} on {_count(seconds.n_threads, 'thread')} of an idle CPU ({parts}), "
        f"and {compiling:g} s more to compile the first time"
    )


def _critical(scene: Scene, field: ObstacleField) -> list[tuple[str, str]]:
    """A/A_c for the radii of the field: a lone colloid captures for good, without noise, above 1."""
    radii = field.radii
    if len(radii) == 0 or scene.hydrodynamics.kind == "none":
        return []
    if len(flat := np.flatnonzero(np.isinf(radii))):
        name = field.name(int(flat[0]))
        return [("A/A_c", f"infinite: without noise {name} keeps every swimmer that comes to touch it")]
    try:
        A_c = critical_radius(scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio)
    except ValueError:
        return [("A/A_c", "above 1 for every radius: no colloid is too small to capture")]
    if math.isinf(A_c):
        return [("A/A_c", "0: without a dipole no radius captures")]
    values = np.unique(radii)
    ratios = ", ".join(f"{_short(A / A_c)} (A = {A:g})" for A in values[:6])
    if len(values) > 6:
        ratios = f"{_short(values[0] / A_c)} to {_short(values[-1] / A_c)} (A = {values[0]:g} to {values[-1]:g})"
    return [("A/A_c", f"{ratios}; A_c = {A_c:.4g}")]


def _count(n: int, noun: str) -> str:
    return f"{n:,} {noun}{'' if n == 1 else 's'}"


def _short(number: float) -> str:
    """Three digits, never as a power of ten where that is no help."""
    return f"{number:,.0f}" if 100.0 <= number < 1e9 else f"{number:.3g}"


def _inverse(rate: float) -> str:
    return f"{1.0 / rate:.4g} a/U" if rate > 0.0 else "infinite"


def _duration(seconds: float) -> str:
    if seconds < 1.0:
        return "under a second"
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"

"""What single keys allow but the engine cannot compute together: refused before a run, by `check` too."""

from __future__ import annotations

from math import sqrt

import numpy as np

from porous_swim.core.parts import KeyedError
from porous_swim.core.scales import told
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.model import SceneModel

_COARSEST = 1e-3  # of the least contact height, that a height may be rounded to; the flow is then off by 0.4 %
_DIGITS = {"f32": 24, "f64": 53}
_MOST_CHANGE = 1.0  # of the flow at contact, of itself within a step
_LONGEST_KICK = 1.0  # a, where there are colloids


def check_limits(scene: SceneModel, field: ObstacleField) -> None:
    """Raise a `KeyedError` for what cannot be computed in a scene with its colloids."""
    _check_precision(scene, field)
    _check_flow(scene, field)
    _check_noise(scene, field)


def _check_precision(scene: SceneModel, field: ObstacleField) -> None:
    """Heights are differences of distances as large as `at_surface`."""
    largest = float(field.at_surface.max(initial=0.0))
    most = _COARSEST * scene.swimmers.aspect_ratio * 2.0 ** _DIGITS[scene.precision]
    if largest > most:
        remedy = "set it to f64, or put a plane wall" if scene.precision == "f32" else "put a plane wall"
        radius, allowed = told(largest, "a", scene.scales, digits=".4g"), told(most, "a", scene.scales, digits=".3g")
        raise KeyedError(
            "run.precision",
            f"{scene.precision} has too few digits for heights above a colloid of radius {radius}: expected at most "
            f"{allowed} for swimmers of aspect ratio {scene.swimmers.aspect_ratio:g}; {remedy} in its place",
        )


def _check_flow(scene: SceneModel, field: ObstacleField) -> None:
    if scene.integrator == "located" or scene.hydrodynamics.kind == "none" or len(field.radii) == 0:
        return  # where steps are located their length follows the flow
    alpha, dt = scene.swimmers.dipole_strength, scene.run.time_step
    change = abs(alpha) * _slope_at_contact(scene.swimmers.aspect_ratio, float(field.radii.max())) * dt
    if change > _MOST_CHANGE:
        step, most = told(dt, "a/U", scene.scales), told(dt / change, "a/U", scene.scales, digits=".2g")
        raise KeyedError(
            "run.time_step",
            f"{step} is too long for dipole_strength {alpha:.4g}, whose flow on a swimmer in contact changes at a "
            f"rate of {change / dt:.3g} U/a: expected at most {most}, or with this step a dipole_strength "
            f"of at most {abs(alpha) / change:.3g} in size",
        )


def _slope_at_contact(h: float, A: float) -> float:
    """-dK/dh at height h above a sphere of radius A, where alpha K is the flow that draws a lying pusher to it."""
    if np.isinf(A):
        return 0.75 / h**3  # K = 3/(8 h^2)
    H = h * (2.0 * A + h)
    K = 1.5 * A * (A + h) / (H * H)
    return K * (2.0 / h + 2.0 / (2.0 * A + h) - 1.0 / (A + h))


def _check_noise(scene: SceneModel, field: ObstacleField) -> None:
    D, dt = scene.translational_diffusion, scene.run.time_step
    kick = sqrt(2.0 * D * dt)
    if kick > _LONGEST_KICK and len(field.radii):
        step, most = (
            told(dt, "a/U", scene.scales),
            told(_LONGEST_KICK**2 / (2.0 * D), "a/U", scene.scales, digits=".2g"),
        )
        raise KeyedError(
            "run.time_step",
            f"{step} is too long for D = {D:.4g}, whose noise moves a swimmer by {kick:.3g} a in a step, through what "
            f"stands in between: expected at most {most}",
        )

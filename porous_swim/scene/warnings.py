"""What is legal in a scene and seldom meant, each in a sentence with a number."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt

import numpy as np

from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.pores import closed_share
from porous_swim.scene.model import SceneModel

_NOTEWORTHY_JUMP = 0.1  # of the swimming speed
_LONG_KICK = 0.1  # half-lengths or radians in one step
_LONG_STEP = 0.05  # half-lengths swum in one step
_LARGE_RADIUS = 2000.0  # a
_LONG_ARC = 0.5  # rad between two frames: a circle of fewer than thirteen chords does not look like one
# docs/convergence.md: residence times between reflecting walls are this much short, times step and rate of the flow
_SHORT = 0.11
_NOTEWORTHY_BIAS = 0.01
_NOTEWORTHY_ROOM = 0.005


def warnings_of(scene: SceneModel, field: ObstacleField) -> list[str]:
    """Return the warnings for a scene and its colloids."""
    return [
        *field.notes,
        *_step(scene),
        *_clamp(scene, field),
        *_flow(scene, field),
        *_rounding(scene, field),
        *_mid_planes(scene, field),
        *_frames(scene, field),
        *_narrow_gaps(scene, field),
        *_pores(scene, field),
    ]


def _step(scene: SceneModel) -> Iterator[str]:
    dt = scene.run.time_step
    if dt > _LONG_STEP and scene.integrator == "euler":
        yield f"run.time_step {dt:g} is long: a swimmer moves as far in a step; keep it below {_LONG_STEP:g}"
    for name, value, what in (
        ("D", scene.translational_diffusion, "half-lengths"),
        ("D_r", scene.rotational_diffusion, "radians"),
    ):
        kick = sqrt(2.0 * value * dt)
        if kick > _LONG_KICK:
            longest = _LONG_KICK**2 / (2.0 * value)
            yield (
                f"run.time_step {dt:g} is long for {name} = {value:.4g}: noise moves a swimmer by "
                f"{kick:.2g} {what} in a step; keep it below {longest:.2g}"
            )


def _clamp(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    # Measured: 1.3 % at dt 0.001 at one colloid of radius 20, 10 % at 0.005 in a hexagonal crystal.
    noisy = scene.translational_diffusion or scene.rotational_diffusion
    if scene.integrator == "euler" and noisy and len(field.radii):
        root = sqrt(scene.run.time_step)
        yield (
            "euler steps with noise hold a swimmer too long at a wall: at run.time_step "
            f"{scene.run.time_step:g} residence times are about {41.0 * root:.1f} % long at a large colloid "
            f"and {140.0 * root:.0f} % in a tight crystal; the bias falls as the square root of the step, "
            "and run.integrator: reflected has none of it"
        )


def _flow(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    """The flow must not change much over what a swimmer moves in a step: at contact it is 3 alpha/(8 h^2)."""
    if scene.integrator != "reflected" or scene.hydrodynamics.kind == "none" or len(field.radii) == 0:
        return
    dt, alpha, gamma = scene.run.time_step, scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio
    rate = 0.75 * abs(alpha) / gamma**3
    bias = _SHORT * rate * dt
    if bias > _NOTEWORTHY_BIAS:
        yield (
            f"run.time_step {dt:g} is long for alpha = {alpha:.4g}: the flow at contact changes at a rate of "
            f"{rate:.3g} U/a, and residence times may be {100.0 * bias:.1g} % short; keep it below "
            f"{_NOTEWORTHY_BIAS / (_SHORT * rate):.2g}"
        )


def _rounding(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    # Measured relative error of the drift near contact in single precision: 4e-6, 4e-5, 5e-4 at A = 20, 200, 2000.
    largest = float(field.at_surface.max(initial=0.0))
    if scene.precision == "f32" and largest > _LARGE_RADIUS:
        yield (
            f"f32 is coarse for a colloid of radius {largest:.4g}: heights are rounded to {largest * 2.0**-24:.1g}, "
            f"and the flow is off by about {2.5e-7 * largest:.1g} of itself; set run.precision: f64"
        )


def _mid_planes(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    gaps = field.nearest_gaps()
    if scene.hydrodynamics.kind == "none" or len(gaps) < 2:
        return
    # The image flow of a wall, halfway in the commonest gap but no nearer than a sphere can come.
    height = max(float(np.median(gaps)) / 2.0, 1.0)
    jump = 3.0 * abs(scene.swimmers.dipole_strength) / (8.0 * height**2)
    if jump > _NOTEWORTHY_JUMP:
        yield (
            f"only the nearest colloid acts on a swimmer, so its drift jumps by up to about {jump:.2g} U "
            f"halfway between neighbours (alpha = {scene.swimmers.dipole_strength:.4g}, typical gap "
            f"{np.median(gaps):.3g})"
        )


def _frames(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    """A swimmer that slides along a colloid of radius A at speed 1 turns around it at a rate of 1/(A + gamma)."""
    least = float(field.radii.min(initial=np.inf))
    every, orbit = scene.record_period * scene.run.time_step, least + scene.swimmers.aspect_ratio
    arc = every / orbit
    if scene.n_recorded and arc > _LONG_ARC:
        yield (
            f"frames are {every:g} a/U apart, in which a swimmer goes {arc:.2g} rad around a colloid of radius "
            f"{least:g}: the recording and the trajectory show no orbit there; keep record.every below "
            f"{_LONG_ARC * orbit:.2g}"
        )


def _pores(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    clearance = scene.swimmers.aspect_ratio  # of a centre from a surface: of a rod that lies along it
    share = closed_share(field, clearance)
    if share > _NOTEWORTHY_ROOM:
        yield (
            f"about {100.0 * share:.3g} % of the room for swimmers is in closed pores: all around them surfaces are "
            f"nearer to each other than {2.0 * clearance:g}, the width of a swimmer, and none that is there ever leaves"
        )


def _narrow_gaps(scene: SceneModel, field: ObstacleField) -> Iterator[str]:
    """A swimmer passes where surfaces are as far apart as it is thick, a rod that points along the gap."""
    gamma = scene.swimmers.aspect_ratio
    gaps = field.narrow_gaps(2.0 * gamma)
    if len(gaps):
        how = "are 2 thick" if gamma == 1.0 else f"are {2.0 * gamma:.3g} thick at least, whichever way they point"
        number = "1 gap between colloids is" if len(gaps) == 1 else f"{len(gaps):,} gaps between colloids are"
        smallest = f"{gaps[0]:.3g}" if len(gaps) == 1 else f"the narrowest is {gaps[0]:.3g}"
        yield f"{number} too narrow for swimmers to pass ({smallest}): swimmers {how}"

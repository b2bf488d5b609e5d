"""What moves the swimmers of one scene, or of several that run together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.engine.dynamics import Dynamics
from porous_swim.engine.parameters import Numbers, Parameters, flight_height
from porous_swim.physics.noise import Brownian
from porous_swim.scene.scene import Scene


def dynamics_of(scenes: Sequence[Scene]) -> Dynamics:
    """Return what moves the swimmers of `scenes`, in their order; the first says what is the same for all."""
    first, counts = scenes[0], [scene.swimmers.count for scene in scenes]
    return Dynamics(
        Parameters.of(scenes), numbers_of(scenes), (type(first.hydrodynamics),),
        first.noise.variates if isinstance(first.noise, Brownian) else None, first.precision, first.integrator,
        type(first.swimmers.motility), np.repeat(np.arange(len(scenes), dtype=np.int32), counts),
    )  # fmt: skip


def numbers_of(scenes: Sequence[Scene]) -> Numbers:
    """Return the numbers that all swimmers of `scenes` share."""
    first = scenes[0]
    return Numbers(
        first.run.time_step, first.encounter.escape_height, first.encounter.contact_band, first.run.seed,
        first.flight_ticks, lowest_flight(scenes),
    )  # fmt: skip


def lowest_flight(scenes: Sequence[Scene]) -> float:
    """Return the height from which on the swimmers of all `scenes` may fly, a."""
    alpha = max(abs(scene.swimmers.dipole_strength) for scene in scenes)
    D = max(scene.translational_diffusion for scene in scenes)
    return flight_height(alpha, D, scenes[0].flight_ticks * scenes[0].run.time_step)

"""What moves the swimmers of a run: what is compiled of it, and the numbers; and how its work is cut up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import taichi as ti

from porous_swim.engine.parameters import Numbers, Parameters
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.contact import shape_of
from porous_swim.physics.hydrodynamics import NoHydrodynamics
from porous_swim.physics.model import Model, Variates
from porous_swim.physics.motility import Steady

REALS = {"f32": (ti.f32, np.float32), "f64": (ti.f64, np.float64)}  # by precision: on the device, on the host


@dataclass(frozen=True, eq=False)
class Dynamics:
    """What moves swimmers, in whatever field."""

    parameters: Parameters
    numbers: Numbers
    flows: tuple[type, ...]
    """Models with `make_drift`, whose sum is the drift."""
    variates: Variates | None
    """None without noise."""
    precision: str
    integrator: str
    motility: type = Steady
    """A model with `make_swim` and `make_reorient`."""
    set_of: np.ndarray | None = None
    """(n_swimmers,) int32, the parameter set of each swimmer; by default all have the first."""

    @property
    def real(self) -> np.dtype:
        """The type of real numbers on the host."""
        return np.dtype(REALS[self.precision][1])

    def model(self, field: ObstacleField, lanes: int) -> Model:
        """What is compiled for a field, in blocks of so many lanes."""
        shape = shape_of(float(self.parameters["gamma"].min()), float(field.radii.min(initial=np.inf)))
        flows = self.flows if len(field.radii) else (NoHydrodynamics,)  # nothing reflects
        return Model(
            REALS[self.precision][0], field.dimensions, field.surface, shape, flows=flows, motility=self.motility,
            numbers=self.parameters.names, variates=self.variates, integrator=self.integrator,
            flights=self.numbers.flight_ticks > 1, lanes=lanes,
        )  # fmt: skip


@dataclass(frozen=True)
class Tuning:
    """How the work is cut up; no result depends on it. What is None is chosen by the engine."""

    lanes: int | None = None
    """Swimmers to a block."""
    chunk: int | None = None
    """Steps between looks at events."""
    log_rows: int | None = None
    """Rows of the encounter log on the device."""

"""The contenders: what takes turns on the clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import taichi as ti

from porous_swim.bench.bare import make_bare
from porous_swim.bench.job import TIME_STEP, OneColloid
from porous_swim.bench.timing import Work
from porous_swim.engine import backend
from porous_swim.engine.engine import TASK
from porous_swim.engine.medium import on_device
from porous_swim.physics.hydrodynamics import ImageDipole
from porous_swim.physics.model import Model
from porous_swim.physics.motility import Steady
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene

SETTLING = 4000  # steps until swimmers are spread over free and bound


class Bare:
    """The job of one colloid in Taichi without bookkeeping: see `bare`."""

    def __init__(self, n_swimmers: int, precision: str, lanes: int) -> None:
        backend.ensure("cpu", 1)
        job, real = OneColloid(), {"f32": ti.f32, "f64": ti.f64}[precision]
        self._advance = make_bare(
            Model(real, flows=(ImageDipole,), motility=Steady, numbers=tuple(job.law), variates="uniform", lanes=lanes)
        )
        self._stride = max(1, TASK // min(4, n_swimmers // lanes))
        self._state = on_device(job.start(n_swimmers, precision))
        self._numbers = job.radius, ti.Vector(list(job.law.values())), TIME_STEP, job.seed
        self._step, self._lanes = 0, lanes

    def advance(self, n_steps: int) -> None:
        """Move all swimmers."""
        with backend.whole_vectors(self._lanes > 1):
            self._advance(self._state, self._step, n_steps, *self._numbers, self._stride)
        self._step += n_steps

    @property
    def state(self) -> np.ndarray:
        """(6, n) offsets and directors."""
        return np.asarray(self._state.to_numpy())


def bare_work(n_swimmers: int, n_steps: int, precision: str, lanes: int) -> Work:
    """The bare kernel, on one thread."""
    bare = Bare(n_swimmers, precision, lanes)

    def work() -> int:
        bare.advance(n_steps)
        ti.sync()
        return n_swimmers * n_steps

    return work


@dataclass(frozen=True, eq=False)
class Placed:
    """A scene on the device, behind its first steps."""

    simulation: Simulation

    @classmethod
    def of(cls, scene: Scene, *, settling: int = SETTLING, lanes: int | None = None) -> Placed:
        """Compile and settle."""
        simulation = Simulation(scene, lanes=lanes)
        simulation.advance(settling)
        return cls(simulation)

    @property
    def n_colloids(self) -> int:
        """In the field."""
        return len(self.simulation.field.radii)

    def work(self, n_steps: int, *, launches: int = 1) -> Work:
        """`launches` times `n_steps` with all that the engine does."""

        def work() -> int:
            for _ in range(launches):
                self.simulation.advance(n_steps)
            return launches * n_steps * self.simulation.engine.n_swimmers

        return work

"""What the benchmark runs: one colloid for the reference in C, and shipped scenes for the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from porous_swim.core.numbers import Given, numbers_of
from porous_swim.physics.contact import HardContact
from porous_swim.physics.hydrodynamics import ImageDipole
from porous_swim.physics.noise import Brownian
from porous_swim.scene.scene import Scene, load_scene
from porous_swim.scene.shipped import scenes_folder

TIME_STEP = 0.005  # a/U


@dataclass(frozen=True)
class OneColloid:
    """Spherical pushers with uniform noise that start from 0 to 4 a above contact with one colloid."""

    radius: float = 20.0
    dipole_strength: float = 0.8
    diffusion: float = 0.002
    time_step: float = TIME_STEP
    seed: int = 1

    @property
    def law(self) -> dict[str, float]:
        """The numbers of a swimmer by name, with D_r = 3 D/4."""
        noise = Brownian(translational_diffusion=self.diffusion, variates="uniform")
        return numbers_of((ImageDipole(), HardContact(), noise), Given(self.dipole_strength, 1.0, 3, self.time_step))

    @property
    def rules(self) -> list[float]:
        """The numbers of the reference, in its order."""
        return [self.time_step, self.radius, *(self.law[name] for name in ("alpha", "bretherton", "kick", "turn"))]

    def start(self, n_swimmers: int, precision: str) -> np.ndarray:
        """(6, n) offsets from the colloid and unit directors."""
        rng = np.random.default_rng(self.seed)
        radial, director = rng.normal(size=(2, 3, n_swimmers))
        offset = radial / np.linalg.norm(radial, axis=0) * (self.radius + 1.0 + 4.0 * rng.random(n_swimmers))
        state = np.concatenate([offset, director / np.linalg.norm(director, axis=0)])
        return np.ascontiguousarray(state, {"f32": np.float32, "f64": np.float64}[precision])


def scene_of(name: str, n_swimmers: int, **changes: Any) -> Scene:
    """A shipped scene: Euler, uniform noise, f32, one thread of the CPU; `changes` are keys with `__` for dots."""
    common: Mapping[str, Any] = {
        "swimmers.count": n_swimmers, "noise.variates": "uniform", "run.time_step": TIME_STEP,
        "run.integrator": "euler", "run.precision": "f32", "run.device": "cpu", "run.threads": 1,
    }  # fmt: skip
    dotted = {key.replace("__", "."): value for key, value in changes.items()}
    return load_scene(scenes_folder() / f"{name}.yaml").replace({**common, **dotted})


def crystal(n_swimmers: int, *, cells: tuple[int, int] = (30, 17), **changes: Any) -> Scene:
    """The hexagonal crystal in the plane, of 1020 colloids."""
    return scene_of("crystal", n_swimmers, obstacles__cells=list(cells), **changes)


def lattice(n_swimmers: int, *, cells: int = 6, **changes: Any) -> Scene:
    """The face-centred cubic lattice, of 864 colloids."""
    return scene_of("lattice_3d", n_swimmers, obstacles__cells=[cells] * 3, **changes)


def packing(n_swimmers: int) -> Scene:
    """A random packing of 1000 colloids that fill a fifth of space."""
    return scene_of("packing", n_swimmers, obstacles__packing_fraction=0.2)


def single(n_swimmers: int) -> Scene:
    """One colloid, with all that the engine does."""
    return scene_of("single_colloid", n_swimmers, swimmers__release={"kind": "parallel", "height": 2.0})

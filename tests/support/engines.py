"""Engines for tests, from a few numbers."""

from __future__ import annotations

import hashlib

import numpy as np

from porous_swim.engine import backend
from porous_swim.engine.dynamics import Dynamics, Tuning
from porous_swim.engine.engine import Engine
from porous_swim.engine.parameters import Numbers, Parameters, flight_height
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.insertion import insert
from porous_swim.obstacles.wall import PlaneWall
from porous_swim.physics.hydrodynamics import ImageDipole
from porous_swim.physics.motility import Steady


def field_of(centers, radii, box=(0.0, 0.0, 0.0), dimensions=3) -> ObstacleField:
    """Spheres given as lists."""
    centers = np.array(centers, dtype=float).reshape(-1, 3)
    return ObstacleField.of_spheres(
        centers, np.broadcast_to(np.array(radii, float), len(centers)), np.array(box, float), dimensions
    )


def plane_wall(point, normal, dimensions=3) -> ObstacleField:
    """The plane through `point` whose unit `normal` points into the fluid."""
    plane = PlaneWall(np.asarray(point, float), np.asarray(normal, float), dimensions)
    return ObstacleField((plane,), np.zeros(3), dimensions)


def hexagonal(*, radius=3.5, spacing=10.0, cells=(4, 3)) -> ObstacleField:
    """A hexagonal crystal in the plane."""
    nx, ny = cells
    height = spacing * np.sqrt(3.0)
    corner = np.array([(i * spacing, j * height, 0.0) for i in range(nx) for j in range(ny)])
    centers = np.concatenate([corner, corner + np.array([0.5 * spacing, 0.5 * height, 0.0])])
    return field_of(centers, radius, (nx * spacing, ny * height, 0.0), 2)


def fcc(*, radius=5.0, spacing=16.0, cells=2) -> ObstacleField:
    """A face-centred cubic crystal."""
    a = spacing * np.sqrt(2.0)
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), -1).reshape(-1, 1, 3) * a
    basis = np.array([(0, 0, 0), (0, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 0.5, 0)]) * a
    return field_of((corners + basis).reshape(-1, 3), radius, [cells * a] * 3)


def packed(n: int, *, seed=0, smallest=1.0, largest=5.0, fraction=0.25) -> ObstacleField:
    """`n` spheres of nine radii at random in a periodic box, none overlapping."""
    rng = np.random.default_rng(seed)
    radii = np.sort(rng.choice(np.linspace(smallest, largest, 9), n))[::-1].copy()
    edge = float((4.0 / 3.0 * np.pi * np.sum(radii**3) / fraction) ** (1.0 / 3.0))
    centers = insert(radii, np.full(3, edge), rng)
    assert len(centers) == n
    return field_of(centers, radii, (edge,) * 3)


def released(field: ObstacleField, n: int, *, seed=0, clearance=1.01) -> tuple[np.ndarray, np.ndarray]:
    """Uniform positions (n, 3) with room for a sphere, isotropic directors (n, 3)."""
    rng, d = np.random.default_rng(seed), field.dimensions
    position = np.zeros((n, 3))
    wanting = np.arange(n)
    while len(wanting):
        position[wanting] = rng.random((len(wanting), 3)) * field.box
        wanting = wanting[field.nearest(position[wanting])[2] < clearance]
    director = np.zeros((n, 3))
    director[:, :d] = rng.normal(size=(n, d))
    return position, director / np.linalg.norm(director, axis=1, keepdims=True)


def make_engine(
    field: ObstacleField, position, director, *, alpha=0.8, gamma=1.0, D=0.002, D_r=None, time_step=0.005, seed=1,
    precision="f32", variates="gaussian", device="cpu", threads=None, hydrodynamics=ImageDipole, flows=(),
    motility=Steady, own=None, integrator="euler", escape_sine=2.0, flight_ticks=1, set_of=None, lanes=None, chunk=None,
    log_rows=None, **options,
) -> Engine:  # fmt: skip
    """An engine for swimmers of one kind; numbers may be arrays with `set_of`. Further `flows` have `own` numbers."""
    gammas = np.asarray(gamma, float)
    numbers = {
        "alpha": alpha, "bretherton": (1.0 - gammas * gammas) / (1.0 + gammas * gammas), "gamma": gamma,
        "kick": np.sqrt(2.0 * np.asarray(D) * time_step),
        "turn": np.sqrt(2.0 * np.asarray(0.75 * D if D_r is None else D_r) * time_step),
        "escape_sine": escape_sine, **(own or {}),
    }  # fmt: skip
    columns = np.broadcast_arrays(*(np.atleast_1d(np.asarray(each, float)) for each in numbers.values()))
    lowest = flight_height(float(np.abs(alpha).max()), float(np.max(D)), flight_ticks * time_step)
    dynamics = Dynamics(
        Parameters(tuple(numbers), np.stack(columns, axis=1)),
        Numbers(time_step, 1.5, 0.05, seed, flight_ticks, lowest), (hydrodynamics, *flows),
        variates if np.any(D) else None, precision, integrator, motility, set_of,
    )  # fmt: skip
    return Engine(
        backend.ensure(device, threads), field, np.atleast_2d(np.array(position, float)),
        np.atleast_2d(np.array(director, float)), dynamics=dynamics, tuning=Tuning(lanes, chunk, log_rows), **options,
    )  # fmt: skip


def fingerprint(engine: Engine) -> str:
    """Hash of where all swimmers are and of all encounters, to the bit."""
    now, rows = engine.snapshot(), engine.encounters()
    digest = hashlib.sha256()
    for array in (
        now.position,
        now.director,
        now.colloid,
        now.image,
        now.bound,
        *(rows[name] for name in sorted(rows)),
    ):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()

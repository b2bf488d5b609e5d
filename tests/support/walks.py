"""Random walks with known statistics."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from tests.support import synthetic


def brownian(
    rng: np.random.Generator, *, n_swimmers: int, n_frames: int, dimensions: int, diffusivity: float, drift: float = 0.0
) -> pa.Table:
    """Frames 1 a/U apart of independent Gaussian steps, with a drift along x; directors along x."""
    steps = np.zeros((n_frames, n_swimmers, 3))
    steps[1:, :, :dimensions] = np.sqrt(2.0 * diffusivity) * rng.normal(size=(n_frames - 1, n_swimmers, dimensions))
    steps[1:, :, 0] += drift
    about = synthetic.info(n_swimmers=n_swimmers, last_time=n_frames - 1.0, dimensions=dimensions)
    directors = np.broadcast_to(np.array([1.0, 0.0, 0.0]), steps.shape)
    return synthetic.trajectory(about, np.arange(float(n_frames)), np.cumsum(steps, axis=0), directors)


def persistent(
    rng: np.random.Generator, *, n_swimmers: int, n_frames: int, turning: float, diffusivity: float = 0.0
) -> pa.Table:
    """In the plane: frames after each step of 1 a/U along the director, which then turns by a Gaussian angle.

    The director decays by c = exp(-turning^2/2) each step.
    """
    position, directors = _persistent(rng, n_swimmers, n_frames, turning, diffusivity)
    about = synthetic.info(n_swimmers=n_swimmers, last_time=n_frames - 1.0, dimensions=2)
    return synthetic.trajectory(about, np.arange(float(n_frames)), position, directors)


def persistent_lags(
    rng: np.random.Generator, *, n_swimmers: int, n_frames: int, every: int, turning: float, diffusivity: float = 0.0
) -> pa.Table:
    """The table of lags of `persistent`, with frames after the first at each of `every` steps."""
    position, directors = _persistent(rng, n_swimmers, n_frames * every + 1, turning, diffusivity)
    about = synthetic.info(n_swimmers=n_swimmers, last_time=float(n_frames * every), dimensions=2)
    clock = np.arange(n_frames + 1) * float(every)
    return synthetic.lags(about, clock, position[::every], directors[::every])


def _persistent(
    rng: np.random.Generator, n_swimmers: int, n_frames: int, turning: float, diffusivity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and directors (n_frames, n_swimmers, 3)."""
    angle = rng.uniform(0.0, 2.0 * np.pi, n_swimmers) + np.concatenate(
        [np.zeros((1, n_swimmers)), np.cumsum(turning * rng.normal(size=(n_frames - 1, n_swimmers)), axis=0)]
    )
    directors = np.stack([np.cos(angle), np.sin(angle), np.zeros(angle.shape)], axis=2)
    steps = np.zeros(directors.shape)
    steps[1:] = directors[:-1]
    steps[1:, :, :2] += np.sqrt(2.0 * diffusivity) * rng.normal(size=(n_frames - 1, n_swimmers, 2))
    return np.cumsum(steps, axis=0), directors


def persistent_msd(n: np.ndarray, *, turning: float, diffusivity: float = 0.0) -> np.ndarray:
    """Exact mean squared displacement of `persistent` after n steps (n_lags,)."""
    c = np.exp(-0.5 * turning**2)
    return 4.0 * diffusivity * n + n * (1.0 + c) / (1.0 - c) - 2.0 * c * (1.0 - c**n) / (1.0 - c) ** 2


def of_two_diffusivities(rng: np.random.Generator, *, n_swimmers: int, n_frames: int) -> pa.Table:
    """In the plane: `brownian` in which each swimmer has a diffusivity of 0.5 or of 1.5, by chance."""
    table = brownian(rng, n_swimmers=n_swimmers, n_frames=n_frames, dimensions=2, diffusivity=0.5)
    scale = np.sqrt(rng.choice([1.0, 3.0], n_swimmers))[table["swimmer"].to_numpy()]
    for axis in "xyz":
        place = table.schema.get_field_index(axis)
        moved = pa.array(scale * table[axis].to_numpy())
        table = table.set_column(place, table.schema.field(axis), moved)
    return table


def travellers(rng: np.random.Generator, *, n_swimmers: int, n_frames: int, mean: float) -> pa.Table:
    """Straight along x, each at a speed of its own: a distance of 1 takes a time that is exponential."""
    position = np.zeros((n_frames, n_swimmers, 3))
    position[:, :, 0] = np.arange(n_frames)[:, None] / rng.exponential(mean, n_swimmers)
    about = synthetic.info(n_swimmers=n_swimmers, last_time=n_frames - 1.0)
    return synthetic.trajectory(about, np.arange(float(n_frames)), position, np.ones(position.shape))


def lingering(rng: np.random.Generator, *, n_swimmers: int, n_frames: int) -> tuple[pa.Table, pa.Table]:
    """About a colloid of radius 2 in the plane, slowly through heights and pitches that are uniform; and the colloid.

    Heights are between 0.5 and 1.5. Frames of a swimmer are alike: each is near the one before.
    """
    part = rng.uniform(size=(1, n_swimmers, 3)) + np.cumsum(0.05 * rng.normal(size=(n_frames, n_swimmers, 3)), axis=0)
    height, pitch, around = np.moveaxis(part % 1.0, 2, 0) * np.reshape([1.0, np.pi, 2.0 * np.pi], (3, 1, 1))
    angle = around + 0.5 * np.pi - (pitch - 0.5 * np.pi)

    def unit(angle: np.ndarray) -> np.ndarray:
        return np.stack([np.cos(angle), np.sin(angle), np.zeros(angle.shape)], axis=2)

    about = synthetic.info(n_swimmers=n_swimmers, last_time=n_frames - 1.0, dimensions=2)
    position = (2.5 + height)[..., None] * unit(around)
    table = synthetic.trajectory(about, np.arange(float(n_frames)), position, unit(angle))
    return table, synthetic.colloids(about, np.zeros((1, 3)), radius=2.0)

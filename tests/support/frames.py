"""Synthetic frames: persistent walkers that glide around colloids. Not the physics, only its look.

Used to test and to look at observers without an engine. Lengths in a, times in a/U.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from porous_swim.observers.base import BOUND, CONTACT, FREE, Counts, Ensemble, Frame
from porous_swim.obstacles.field import ObstacleField

CONTACT_HEIGHT, CONTACT_BAND, ESCAPE_HEIGHT = 1.0, 0.05, 1.5


def hexagonal_crystal(*, cells: tuple[int, int] = (12, 7), spacing: float = 10.0, radius: float = 3.5) -> ObstacleField:
    """Two colloids in each orthogonal cell of spacing x sqrt(3) spacing."""
    cell = np.array([spacing, np.sqrt(3.0) * spacing])
    corner = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 2)
    planar = np.concatenate([corner + 0.25, corner + 0.75]) * cell
    return field_of(np.column_stack([planar, np.zeros(len(planar))]), radius, box=(*cell * cells, 0.0), dimensions=2)


def cubic_lattice(*, cells: int = 4, spacing: float = 12.0, radius: float = 4.0) -> ObstacleField:
    """A face-centred lattice with four colloids in each of cells^3 cubes of that edge."""
    corner = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    basis = np.array([[0.25, 0.25, 0.25], [0.25, 0.75, 0.75], [0.75, 0.25, 0.75], [0.75, 0.75, 0.25]])
    return field_of((corner + basis).reshape(-1, 3) * spacing, radius, box=(cells * spacing,) * 3, dimensions=3)


def single_colloid(*, radius: float = 20.0, dimensions: int = 3) -> ObstacleField:
    """One colloid at the origin of open space."""
    return field_of(np.zeros((1, 3)), radius, box=(0.0, 0.0, 0.0), dimensions=dimensions)


def free_space(*, dimensions: int = 3) -> ObstacleField:
    """No colloid, no border."""
    return field_of(np.zeros((0, 3)), 1.0, box=(0.0, 0.0, 0.0), dimensions=dimensions)


def field_of(centers: np.ndarray, radius: float, *, box: tuple[float, ...], dimensions: int) -> ObstacleField:
    """Equal spheres at `centers`, (n, 3)."""
    return ObstacleField.of_spheres(centers, np.full(len(centers), radius), np.array(box, dtype=float), dimensions)


class Walkers:
    """Swimmers of speed 1 that glide on a colloid once they touch it and leave it at random."""

    def __init__(self, field: ObstacleField, *, n_swimmers: int, seed: int, start: np.ndarray | None = None) -> None:
        self.field, self.random = field, np.random.default_rng(seed)
        self.axes = slice(0, field.dimensions)
        planar = field.centers[:, self.axes]
        self.tree = cKDTree(planar, boxsize=field.box[self.axes] if field.periodic else None) if len(planar) else None
        self.position = self._release(n_swimmers) if start is None else np.tile(start, (n_swimmers, 1)).astype(float)
        self.start = self.position.copy()
        self.director = self._unit(self.random.normal(size=(n_swimmers, 3)))
        if start is not None:
            self.director = self._unit(np.array([1.0, 0.0, 0.0]) + 0.12 * self.director)
        self.state = np.full(n_swimmers, FREE, dtype=np.uint8)
        self.last = np.full((n_swimmers, 4), -1)  # colloid and image of the last encounter
        self.since = np.zeros(n_swimmers)  # start of the encounter, or of the flight
        self.counts = np.zeros(4, dtype=int)  # captures, escapes, hops, returns
        self.ended: dict[str, list[float]] = {"residence": [], "winding": [], "hop_time": []}
        self.hops: list[np.ndarray] = []  # (n, 2, 4) each

    def _unit(self, vectors: np.ndarray) -> np.ndarray:
        vectors[:, self.field.dimensions :] = 0.0
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

    def _release(self, n_swimmers: int) -> np.ndarray:
        reach = 4.0 * self.field.radii.max(initial=1.0)  # where nothing repeats: a box around the origin
        lower = np.where(self.field.box > 0.0, 0.0, -reach) * (np.arange(3) < self.field.dimensions)
        upper = np.where(self.field.box > 0.0, self.field.box, -lower)
        position = self.random.uniform(lower, upper, (n_swimmers, 3))
        while self.tree is not None:
            _, _, height = self.nearest(position)
            inside = height < ESCAPE_HEIGHT
            if not inside.any():
                break
            position[inside] = self.random.uniform(lower, upper, (int(inside.sum()), 3))
        return position

    def nearest(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Index of the nearest colloid, offset from it, height above it, each per swimmer."""
        if self.tree is None:
            return np.full(len(position), -1), np.zeros((len(position), 3)), np.full(len(position), np.inf)
        box = self.field.box
        wrapped = position - np.floor(position / np.where(box > 0.0, box, 1.0)) * (box > 0.0) * box
        _, colloid = self.tree.query(wrapped[:, self.axes])
        offset = position - self.field.centers[colloid]
        offset -= np.round(offset / np.where(box > 0.0, box, np.inf)) * box
        return colloid, offset, np.linalg.norm(offset, axis=1) - self.field.radii[colloid]

    def advance(self, *, time: float, interval: float) -> None:
        """One Euler step of length `interval`, ending at `time`."""
        self.position += self.director * interval
        self.director = self._unit(
            self.director + self.random.normal(scale=0.15 * np.sqrt(interval), size=self.director.shape)
        )
        colloid, offset, height = self.nearest(self.position)
        bound = self.state != FREE
        touching = np.where(bound, height < ESCAPE_HEIGHT, height < CONTACT_HEIGHT)
        leaving = bound & touching & (self.random.random(len(height)) < interval / 30.0)
        radial = np.divide(
            offset,
            np.linalg.norm(offset, axis=1, keepdims=True),
            where=touching[:, None],
            out=np.zeros_like(offset),
        )
        self._glide(touching & ~leaving, radial, height)
        self.position[leaving] += (ESCAPE_HEIGHT + 0.1 - height[leaving, None]) * radial[leaving]
        self.director[leaving] = self._unit(radial[leaving] + 0.8 * self.director[leaving])
        self._book(time=time, colloid=colloid, starts=~bound & touching, ends=(bound & ~touching) | leaving)
        lifted = self.random.random(len(height)) < 0.3
        self.state = np.where(touching & ~leaving, np.where(lifted, BOUND, CONTACT), FREE).astype(np.uint8)

    def _glide(self, gliding: np.ndarray, radial: np.ndarray, height: np.ndarray) -> None:
        normal = radial[gliding]
        tangent = self.director[gliding] - normal * np.sum(self.director[gliding] * normal, axis=1, keepdims=True)
        self.director[gliding] = self._unit(tangent + 1e-9)
        self.position[gliding] += (CONTACT_HEIGHT - height[gliding, None]) * normal

    def _book(self, *, time: float, colloid: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> None:
        host = np.column_stack([colloid, self._image(colloid)])
        again = starts & (self.last[:, 0] >= 0)
        hops = again & np.any(self.last != host, axis=1)
        self.counts += [starts.sum(), ends.sum(), hops.sum(), (again & ~hops).sum()]
        length = time - self.since
        self.ended["residence"] += list(length[ends])
        self.ended["winding"] += list(length[ends] / (2.0 * np.pi * (self.field.radii[colloid[ends]] + 1.0)))
        self.ended["hop_time"] += list(length[hops])
        self.hops.append(np.stack([self.last, host], axis=1)[hops])
        self.last[starts] = host[starts]
        self.since[starts | ends] = time

    def _image(self, colloid: np.ndarray) -> np.ndarray:
        if self.tree is None:
            return np.zeros((len(colloid), 3), dtype=np.int32)
        box = self.field.box
        return np.round((self.position - self.field.centers[colloid]) / np.where(box > 0.0, box, np.inf)).astype(
            np.int32
        )

    def ensemble(self) -> Ensemble:
        """All walkers together."""
        squared = np.sum((self.position - self.start) ** 2, axis=1)
        n = len(squared)
        error = np.std(squared, ddof=1) / np.sqrt(n) if n > 1 else np.nan
        return Ensemble(
            n, float(np.mean(self.state != FREE)), float(np.mean(self.state == CONTACT)), float(squared.mean()), error
        )

    def frame(self, *, step: int, time: float) -> Frame:
        """What an observer sees now; empties the lists of ended encounters."""
        colloid, _, _ = self.nearest(self.position)
        ended = {name: np.array(values, dtype=float) for name, values in self.ended.items()}
        hops = np.concatenate([np.zeros((0, 2, 4), np.int32), *self.hops]).astype(np.int32)
        self.ended, self.hops = {name: [] for name in self.ended}, []
        return Frame(
            step=step,
            time=time,
            position=self.position.copy(),
            director=self.director.copy(),
            colloid=colloid.astype(np.int32),
            image=self._image(colloid),
            state=self.state.copy(),
            ensemble=self.ensemble(),
            has_colloids=self.tree is not None,
            counts=Counts(*self.counts.tolist()),
            under_way=time - self.since[self.state != FREE],
            hops=hops,
            **ended,
        )


def walk(
    field: ObstacleField,
    *,
    n_swimmers: int = 50,
    n_frames: int = 40,
    period: int = 50,
    time_step: float = 0.01,
    seed: int = 1,
    start: np.ndarray | None = None,
) -> Iterator[Frame]:
    """Frames at the multiples of `period` steps from 0 on; `start` (3,) releases all at one point."""
    walkers = Walkers(field, n_swimmers=n_swimmers, seed=seed, start=start)
    yield walkers.frame(step=0, time=0.0)
    n_substeps = 5  # the walkers' own step is period / 5: short enough for a smooth glide
    for number in range(1, n_frames):
        for substep in range(n_substeps):
            step = (number - 1) * period + (substep + 1) * period // n_substeps
            walkers.advance(time=step * time_step, interval=period // n_substeps * time_step)
        yield walkers.frame(step=number * period, time=number * period * time_step)

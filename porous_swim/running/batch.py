"""Many scenes of one colloid each in one launch: a scan over swimmers, noise or radius is one batch of swimmers.

Scenes of equal radius share a colloid; the others stand so far apart that no swimmer can come from one to the next.
The engine's table of parameter sets has a row for each scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from porous_swim.core.errors import SceneError
from porous_swim.engine.engine import Engine
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.noise import Brownian
from porous_swim.running.dynamics import dynamics_of
from porous_swim.running.simulation import Start
from porous_swim.scene.scene import Scene

LEEWAY = 4.0  # times what a swimmer swims in the run; flows near a colloid add to its speed, but only there
FEWEST_LAUNCH = 1 << 16  # steps to a launch, between frames


@dataclass(frozen=True, eq=False)
class Member:
    """What one scene of a batch left. Positions as if it had run alone; swimmers counted from 0."""

    scene: Scene
    encounters: dict[str, np.ndarray]  # columns of the encounter table
    time: np.ndarray  # (n_frames,) a/U
    position: np.ndarray  # (n_frames, n_recorded, 3) a
    director: np.ndarray  # (n_frames, n_recorded, 3)

    def first_encounters(self) -> dict[str, np.ndarray]:
        """The first encounter of each swimmer that had one, in the order of swimmers."""
        order = np.lexsort((self.encounters["start_time"], self.encounters["swimmer"]))
        _, first = np.unique(self.encounters["swimmer"][order], return_index=True)
        return {name: column[order][first] for name, column in self.encounters.items()}


def run_batch(scenes: Sequence[Scene]) -> list[Member]:
    """Run scenes of a `single` colloid that differ only in numbers, all at once.

    They may differ in swimmers, in amplitudes of noise, in the radius and in the escape pitch. Noise is a function of
    the seed of the first scene and of a swimmer's number in the batch, so that it differs from that of the scene run
    alone; without noise each result is, to rounding, that of the scene alone.

    Raises:
        SceneError: scenes that differ in structure, that are not of one colloid, or that do not start.
    """
    for scene in scenes:
        _check(scene, scenes[0])
    starts = [Start.of(scene) for scene in scenes]
    field, shifts = _archipelago(scenes, [start.field for start in starts])
    counts = [scene.swimmers.count for scene in scenes]
    engine = Engine(
        starts[0].backend, field,
        np.concatenate([start.swimmers.position + shift for start, shift in zip(starts, shifts, strict=True)]),
        np.concatenate([start.swimmers.director for start in starts]),
        dynamics=dynamics_of(scenes),
    )  # fmt: skip
    frames = _frames(engine, scenes[0])
    ends = np.cumsum(counts)
    return [
        _member(scene, columns, frames, int(end - scene.swimmers.count), shift)
        for columns in [engine.encounters()]
        for scene, end, shift in zip(scenes, ends, shifts, strict=True)
    ]


def _structure(scene: Scene) -> dict[str, object]:
    """What a batch shares."""
    noise = scene.noise
    return {
        "domain": scene.domain, "hydrodynamics": scene.hydrodynamics.kind, "noise": noise.kind,
        "noise.variates": noise.variates if isinstance(noise, Brownian) else None,
        "swimmers.motility": scene.swimmers.motility.kind,
        "encounter.escape_height": scene.encounter.escape_height,
        "encounter.contact_band": scene.encounter.contact_band, "run.time_step": scene.run.time_step,
        "run.flight_step": scene.run.flight_step,
        "run.duration": scene.run.duration, "run.precision": scene.precision, "run.integrator": scene.integrator,
        "record.every": scene.record_period,
    }  # fmt: skip


def _check(scene: Scene, first: Scene) -> None:
    if scene.obstacles.layout != "single" or scene.domain.boundary != "open":
        raise SceneError(f"obstacles.layout: a batch is of scenes with layout single in open space, found {scene.name}")
    for key, value in _structure(scene).items():
        other = _structure(first)[key]
        if value != other:
            raise SceneError(f"{key}: scenes of a batch share it, found {value} beside {other}")


def _archipelago(scenes: Sequence[Scene], fields: Sequence[ObstacleField]) -> tuple[ObstacleField, list[np.ndarray]]:
    """One field with a colloid for each radius, and how far each scene's origin has moved (3,)."""
    radii = sorted({float(field.radii[0]) for field in fields})
    d = scenes[0].domain.dimensions
    reach = max(float(np.abs(field.centers).max()) for field in fields) + max(radii)
    spacing = 2.0 * reach + 2.0 * LEEWAY * (scenes[0].run.duration + 100.0)
    edge = math.ceil(len(radii) ** (1.0 / d))
    places = np.stack(np.unravel_index(np.arange(len(radii)), (edge,) * d), axis=1) * spacing
    centers = np.zeros((len(radii), 3))
    centers[:, :d] = places
    shifts = [centers[radii.index(float(field.radii[0]))] - field.centers[0] for field in fields]
    return ObstacleField.of_spheres(centers, np.array(radii), np.zeros(3), d), shifts


def _frames(engine: Engine, scene: Scene) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Advance to the end; time, positions and directors at every frame, nothing where none is recorded."""
    frames = []
    recorded = scene.n_recorded > 0
    while True:
        if recorded:
            now = engine.snapshot()
            frames.append((engine.step * scene.run.time_step, now.position, now.director))
        left = scene.n_steps - engine.step
        if left == 0:
            return frames
        engine.advance(min(left, scene.record_period if recorded else FEWEST_LAUNCH * scene.flight_ticks))


def _member(
    scene: Scene, columns: dict[str, np.ndarray], frames: list[tuple[float, np.ndarray, np.ndarray]],
    begin: int, shift: np.ndarray,
) -> Member:  # fmt: skip
    """The part of one scene, moved back to where it stands alone."""
    own = (columns["swimmer"] >= begin) & (columns["swimmer"] < begin + scene.swimmers.count)
    encounters = {name: column[own] for name, column in columns.items()}
    encounters["swimmer"] = encounters["swimmer"] - begin
    encounters["colloid"] = np.zeros_like(encounters["colloid"])
    for end in ("entry", "exit"):
        for axis, name in enumerate("xyz"):
            encounters[f"{end}_{name}"] = encounters[f"{end}_{name}"] - shift[axis]
    who = slice(begin, begin + scene.n_recorded)
    time = np.array([frame[0] for frame in frames])
    shape = (len(frames), scene.n_recorded, 3)
    position = np.array([frame[1][who] - shift for frame in frames]).reshape(shape)
    return Member(scene, encounters, time, position, np.array([frame[2][who] for frame in frames]).reshape(shape))

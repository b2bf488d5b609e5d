"""Scans: scenes of the paper with changed numbers, run as batches."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from porous_swim.running.batch import Member, run_batch
from porous_swim.scene.scene import Scene, load_scene
from porous_swim.scene.shipped import scenes_folder

SECTIONS = 3  # trial values in a bracket, tried at once: a bracket shrinks 4-fold in a batch


def paper_scene(name: str) -> Scene:
    """The scene of a figure, from `scenes/paper`."""
    return load_scene(scenes_folder() / "paper" / f"{name}.yaml")


def run_changes(scene: Scene, changes: Sequence[Mapping[str, Any]]) -> list[Member]:
    """Run a scene once for each set of changed keys, in one batch."""
    return run_batch([scene.replace(dict(change)) for change in changes])


def thresholds(
    low: ArrayLike, high: ArrayLike, make: Callable[[int, float], Scene], beyond: Callable[[Member], bool],
    *, n_batches: int,
) -> np.ndarray:  # fmt: skip
    """Where outcomes change (n,): `make(i, value)` is the scene of problem i, `beyond` whether a run is above it.

    Each bracket [low, high] is cut into 4 parts in each of `n_batches` batches, so that it ends 4^-n_batches wide.
    """
    low_now, high_now = np.array(low, dtype=float), np.array(high, dtype=float)
    for _ in range(n_batches):
        inside = np.linspace(low_now, high_now, SECTIONS + 2)[1:-1]  # (n_sections, n)
        scenes = [make(i, float(inside[k, i])) for i in range(len(low_now)) for k in range(SECTIONS)]
        above = np.array([beyond(member) for member in run_batch(scenes)]).reshape(len(low_now), SECTIONS)
        edges = np.vstack([low_now, inside, high_now]).T  # (n, n_sections + 2)
        first = np.where(above.any(axis=1), above.argmax(axis=1), SECTIONS) + 1  # of the edges that lie above
        problem = np.arange(len(low_now))
        low_now, high_now = edges[problem, first - 1], edges[problem, first]
    return 0.5 * (low_now + high_now)


def is_held(member: Member) -> bool:
    """Whether an encounter lasts to the end of the run."""
    return bool(member.encounters["end_censored"].any())


def outgoing_angle(member: Member) -> float:
    """Angle of the director at the end of the run from the x axis, in degrees."""
    ex, ey, _ = member.director[-1, 0]
    return float(np.degrees(np.arctan2(ey, ex)))


def pitch_of(member: Member, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Height (n_frames, n) and pitch (n_frames, n) above the one colloid, at the origin."""
    distance = np.linalg.norm(member.position, axis=2)
    sine = np.sum(member.position * member.director, axis=2) / distance
    return distance - radius, np.arcsin(np.clip(sine, -1.0, 1.0))

"""Trapping times of pushers with noise, as the figures with noise need them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from porous_swim.paper.scan import run_changes
from porous_swim.running.batch import Member
from porous_swim.scene.scene import Scene


@dataclass(frozen=True)
class Case:
    """One colloid, swimmer and noise."""

    radius: float
    alpha: float
    D: float
    D_r: float | None = None  # None: 3 D/4

    @property
    def text(self) -> str:
        """For tables and titles."""
        return f"A = {self.radius:g}, alpha = {self.alpha:g}, D = {self.D:g}"


@dataclass(frozen=True, eq=False)
class TrappingTimes:
    """First passages of swimmers that start in contact with pitch 0, from the start of the run, a/U."""

    height: np.ndarray  # (n,) T_h: when h first exceeds 1.5
    pitch: np.ndarray  # (n,) T_theta: when the pitch first exceeds 3 alpha/8
    n_held: int  # swimmers still there at the end, whose T_h is put at the end
    n_no_pitch: int  # swimmers whose pitch had not passed by the end, whose T_theta is put at the end
    n_late: int  # swimmers whose pitch passed only after they had left


def trapping_times(scene: Scene, cases: Sequence[Case]) -> list[TrappingTimes]:
    """Run a scene for each case, all in one batch."""
    changes = [
        {
            "obstacles.radius": case.radius, "swimmers.dipole_strength": case.alpha,
            "noise": {
                "kind": "brownian", "translational_diffusion": case.D,
                "rotational_diffusion": "from_sphere" if case.D_r is None else case.D_r,
            },
        } for case in cases
    ]  # fmt: skip
    return [_times(member) for member in run_changes(scene, changes)]


def _times(member: Member) -> TrappingTimes:
    rows, n, duration = member.encounters, member.scene.swimmers.count, member.scene.run.duration
    first = rows["start_time"] == 0.0
    height = np.full(n, duration)
    height[rows["swimmer"][first]] = rows["end_time"][first]
    # the pitch of a swimmer that comes back before it has passed is timed in a later encounter
    pitch = np.full(n, np.inf)
    np.fmin.at(pitch, rows["swimmer"], np.where(np.isnan(rows["escape_pitch_time"]), np.inf, rows["escape_pitch_time"]))
    missing = ~np.isfinite(pitch)
    return TrappingTimes(
        height, np.where(missing, duration, pitch), int(np.sum(rows["end_censored"][first])), int(missing.sum()),
        int(np.sum(pitch[~missing] > height[~missing])),
    )  # fmt: skip


def mean_of(times: np.ndarray) -> tuple[float, float]:
    """Mean and standard error."""
    return float(times.mean()), float(times.std(ddof=1) / np.sqrt(len(times)))

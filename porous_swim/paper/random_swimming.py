"""Figure RandomSwimming: pushers with noise that swim at a colloid from afar."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim.paper.figure import Reproduction, Row, disc, panels
from porous_swim.paper.scan import paper_scene, pitch_of, run_changes
from porous_swim.running.batch import Member

NAME = "RandomSwimming"
TITLE = "Pushers (alpha = 0.8) from x = -40 at a colloid of radius 20 for 120 a/U, D = 5e-4 and 2e-3"
NEAR = {5e-4: (0.195, 0.004), 2e-3: (0.0017, 0.0004)}
TOUCH = (0.995, 0.0005)  # at D = 2e-3; its error is a unit of the last digit given


def reproduce(quick: bool) -> Reproduction:
    """Which share is still near at the end, which share touched, and some ways."""
    base = paper_scene("random_swimming")
    if quick:
        base = base.replace({"swimmers.count": 1000, "record.swimmers": 1000})
    count = base.swimmers.count
    members = run_changes(base, [{"noise.translational_diffusion": D} for D in NEAR])
    rows, tables = [], {}
    for (D, (listed, error)), member in zip(NEAR.items(), members, strict=True):
        height, _ = pitch_of(member, 20.0)
        near, touched = float(np.mean(height[-1] < 1.5)), len(np.unique(member.encounters["swimmer"])) / count
        rows.append(
            Row(f"D = {D:g}: share with h < 1.5 at t = 120", near, _error(near, count), independent=listed,
                independent_error=error)
        )  # fmt: skip
        known = TOUCH if D == 2e-3 else (None, 0.0)
        rows.append(
            Row(f"D = {D:g}: share that touched", touched, _error(touched, count), independent=known[0],
                independent_error=known[1])
        )  # fmt: skip
        tables[f"D{D:g}"] = {"time": member.time, "share_near": np.mean(height < 1.5, axis=1)}

    def draw() -> Any:
        picture, axes = panels(3)
        for axis, (D, member) in zip(axes, zip(NEAR, members, strict=True), strict=False):
            _ways(axis, member, f"D = {D:g}")
        for D, table in zip(NEAR, tables.values(), strict=True):
            axes[2].plot(table["time"], table["share_near"], label=f"D = {D:g}")
        axes[2].set(xlabel="t U/a", ylabel="share with h < 1.5")
        axes[2].legend()
        return picture

    return Reproduction(tables, rows, draw)


def _error(share: float, count: int) -> float:
    """Of a binomial share; at least one swimmer."""
    return max(float(np.sqrt(share * (1.0 - share) / count)), 1.0 / count)


def _ways(axis: Any, member: Member, title: str) -> None:
    disc(axis, 20.0)
    for i in range(30):
        axis.plot(member.position[:, i, 0], member.position[:, i, 1], linewidth=0.5)
    axis.set(title=title, xlabel="x/a", ylabel="y/a", xlim=(-60, 80), ylim=(-70, 70))

"""Figure Pullers: nine pullers are captured and come to rest nose-on."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim.paper.figure import Reproduction, Row, disc, panels
from porous_swim.paper.scan import paper_scene, pitch_of, run_changes

NAME = "Pullers"
TITLE = "Pullers (alpha = -0.8, A = 20) from y0 = 0, 2.5, ..., 20"
ANGLES = (180.0, 171.10, 162.05, 152.67, 142.71, 131.82, 119.31, 103.54, 76.74)
TIMES = (18.5, 29.6, 33.4, 36.2, 38.9, 42.0, 45.6, 50.5, 59.4)


def reproduce(quick: bool) -> Reproduction:
    """Where they rest, and when their pitch is within 0.01 of it."""
    scene = paper_scene("pullers")
    offsets = 2.5 * np.arange(9)
    members = run_changes(scene, [{"swimmers.release.position": [-40.0, float(y)]} for y in offsets])
    resting, times = [], []
    for member in members:
        x, y, _ = member.position[-1, 0]
        resting.append(float(np.degrees(np.arctan2(y, x))))
        tilt = pitch_of(member, 20.0)[1][:, 0] + 0.5 * np.pi
        times.append(_crossing(member.time, tilt, 0.01, float(member.encounters["start_time"][0])))
    # the sign at y0 = 0 is that of a zero
    rows = [
        Row(f"y0 = {y:g}: polar angle at rest, degrees", abs(ours), independent=listed, digit=0.01)
        for y, ours, listed in zip(offsets, resting, ANGLES, strict=True)
    ] + [
        Row(f"y0 = {y:g}: time to |theta + pi/2| < 0.01", ours, independent=listed, digit=0.1)
        for y, ours, listed in zip(offsets, times, TIMES, strict=True)
    ]
    columns = {"y0": offsets, "polar_angle": np.array(resting), "time_to_rest": np.array(times)}

    def draw() -> Any:
        picture, (axis,) = panels(1, width=6.0, height=5.0)
        disc(axis, 20.0)
        for member in members:
            axis.plot(member.position[:, 0, 0], member.position[:, 0, 1], color="C0")
            axis.plot(*member.position[-1, 0, :2], "ko", markersize=4)
        axis.set(xlabel="x/a", ylabel="z/a", xlim=(-42, 28))
        return picture

    return Reproduction({"rest": columns}, rows, draw)


def _crossing(time: np.ndarray, tilt: np.ndarray, level: float, contact: float) -> float:
    """When the tilt falls below `level` in contact for good, interpolated in its logarithm."""
    if np.all(np.abs(tilt) < level):
        return contact  # a swimmer that comes straight on is at rest where it touches
    k = int(np.flatnonzero(np.abs(tilt) >= level)[-1])
    before, after = np.log(np.abs(tilt[k : k + 2]))
    return float(time[k] + (time[k + 1] - time[k]) * (before - np.log(level)) / (before - after))

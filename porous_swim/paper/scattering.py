"""Figure TotalScattering: into which direction a pusher leaves a colloid of radius 20."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from porous_swim import theory
from porous_swim.paper.figure import Reproduction, Row, disc, panels
from porous_swim.paper.scan import is_held, outgoing_angle, paper_scene, run_changes, thresholds
from porous_swim.running.batch import Member

NAME = "TotalScattering"
TITLE = "Outgoing angle at A = 20 against impact parameter (three strengths) and against dipole strength (y0 = 0.1)"
STRENGTHS = (0.2, 0.4, 0.6)  # of the scans over the impact parameter
BY_OFFSET = {20.0: (-20.18, "about -18", 0.05), 5.0: (24.44, "", 0.05), 0.1: (36.27, "", 0.05), 21.5: (-27.4, "", 0.1),
             22.0: (-1.2, "", 0.1)}  # fmt: skip
BY_STRENGTH = {0.2: (40.0, 0.1), 0.4: (48.53, 0.05), 0.6: (36.3, 0.1), 0.665: (-14.6, 0.1)}


def reproduce(quick: bool) -> Reproduction:
    """The scans, and the strength from which the swimmer is held."""
    scene = paper_scene("scattering")
    offsets = np.unique([*BY_OFFSET, *np.linspace(0.05, 23.0, 24 if quick else 93)])
    strengths = np.unique([*BY_STRENGTH, *np.linspace(0.05, 0.66, 16 if quick else 62)])
    ways = {alpha: run_changes(scene, [_change(alpha, y) for y in offsets]) for alpha in STRENGTHS}
    by_offset = {alpha: np.array([outgoing_angle(member) for member in members]) for alpha, members in ways.items()}
    by_strength = np.array([outgoing_angle(m) for m in run_changes(scene, [_change(a, 0.1) for a in strengths])])
    (singular,) = thresholds(
        [0.66], [0.68], lambda _, alpha: scene.replace({"swimmers.dipole_strength": alpha, "run.duration": 600.0}),
        is_held, n_batches=8,
    )  # fmt: skip
    rows = [
        Row(f"alpha = 0.6, y0 = {y:g}: degrees", by_offset[0.6][offsets == y][0], paper=paper, independent=value,
            digit=digit)
        for y, (value, paper, digit) in BY_OFFSET.items()
    ] + [
        Row(f"y0 = 0.1, alpha = {alpha:g}: degrees", by_strength[strengths == alpha][0], independent=value, digit=digit)
        for alpha, (value, digit) in BY_STRENGTH.items()
    ]  # fmt: skip
    rows.append(Row("y0 = 0.1: held from alpha =", singular, paper="0.67", independent=0.66834, digit=1e-5))
    tables = {
        "offset": {"y0": offsets} | {f"angle_alpha{alpha:g}": angles for alpha, angles in by_offset.items()},
        "strength": {"alpha": strengths, "angle": by_strength},
    }

    def draw() -> Any:
        picture, axes = panels(5)
        for axis, (alpha, members) in zip(axes, ways.items(), strict=False):
            _ways(axis, members, offsets)
            axis.set_title(rf"$\alpha$ = {alpha:g}")
            axes[3].plot(offsets, by_offset[alpha], "o-", markersize=2, label=rf"$\alpha$ = {alpha:g}")
        axes[3].set(xlabel="$y_0/a$", ylabel="outgoing angle, degrees")
        axes[3].legend()
        _against_strength(axes[4], strengths, by_strength)
        return picture

    return Reproduction(tables, rows, draw)


def _change(alpha: float, y0: float) -> dict[str, object]:
    return {"swimmers.dipole_strength": float(alpha), "swimmers.release.position": [-40.0, float(y0)]}


def _ways(axis: Any, members: list[Member], offsets: np.ndarray) -> None:
    """Every other radius of a swimmer a trajectory."""
    disc(axis, 20.0)
    shown = [int(np.argmin(np.abs(offsets - y))) for y in (0.1, *range(2, 24, 2))]
    for i in shown:
        axis.plot(members[i].position[:, 0, 0], members[i].position[:, 0, 1], linewidth=0.8)
    axis.set(xlim=(-45, 60), ylim=(-50, 50), xlabel="x/a", ylabel="y/a")


def _against_strength(axis: Any, strengths: np.ndarray, angles: np.ndarray) -> None:
    axis.plot(strengths, angles, "o-", markersize=2, label="simulated")
    fine = np.linspace(0.05, 0.59, 60)
    near = [theory.scattering_angle(alpha, 20.0, 0.1) for alpha in fine]
    axis.plot(fine, [math.nan if a is None else math.degrees(a) for a in near], "--", label="near wall")
    axis.set(xlabel=r"$\alpha$", ylabel="outgoing angle, degrees", title="$y_0$ = 0.1")
    axis.legend()

"""Figure TotalScattering: into which direction a pusher leaves a colloid of radius 20."""

from __future__ import annotations

import math

import numpy as np

from porous_swim.analysis import theory
from porous_swim.paper.figure import Reproduction, Row, disc, panels
from porous_swim.paper.scan import is_held, outgoing_angle, paper_scene, run_changes, thresholds

NAME = "TotalScattering"
TITLE = "Outgoing angle at A = 20 against impact parameter (alpha = 0.6) and against dipole strength (y0 = 0.1)"
BY_OFFSET = {20.0: (-20.18, "about -18", 0.05), 5.0: (24.44, "", 0.05), 0.1: (36.27, "", 0.05), 21.5: (-27.4, "", 0.1),
             22.0: (-1.2, "", 0.1)}  # fmt: skip
BY_STRENGTH = {0.2: (40.0, 0.1), 0.4: (48.53, 0.05), 0.6: (36.3, 0.1), 0.665: (-14.6, 0.1)}


def reproduce(quick: bool) -> Reproduction:
    """Two scans in one batch, and the strength at which the swimmer is first held."""
    scene = paper_scene("bullseye")
    offsets = np.unique([*BY_OFFSET, *np.linspace(0.05, 23.0, 24 if quick else 93)])
    strengths = np.unique([*BY_STRENGTH, *np.linspace(0.05, 0.66, 16 if quick else 62)])
    members = run_changes(
        scene,
        [{"swimmers.dipole_strength": 0.6, "swimmers.release.position": [-40.0, float(y)]} for y in offsets]
        + [
            {"swimmers.dipole_strength": float(alpha), "swimmers.release.position": [-40.0, 0.1]} for alpha in strengths
        ],
    )
    angles = np.array([outgoing_angle(member) for member in members])
    by_offset, by_strength = angles[: len(offsets)], angles[len(offsets) :]
    (singular,) = thresholds(
        [0.66], [0.68], lambda _, alpha: scene.replace({"swimmers.dipole_strength": alpha, "run.duration": 600.0}),
        is_held, n_batches=4,
    )  # fmt: skip
    rows = [
        Row(
            f"alpha = 0.6, y0 = {y:g}: degrees", by_offset[offsets == y][0], paper=paper, independent=value, digit=digit
        )
        for y, (value, paper, digit) in BY_OFFSET.items()
    ] + [
        Row(f"y0 = 0.1, alpha = {alpha:g}: degrees", by_strength[strengths == alpha][0], independent=value, digit=digit)
        for alpha, (value, digit) in BY_STRENGTH.items()
    ]
    rows.append(Row("y0 = 0.1: held from alpha =", singular, paper="0.67", independent=0.66834, digit=1e-5))
    tables = {
        "offset": {"y0": offsets, "angle": by_offset},
        "strength": {"alpha": strengths, "angle": by_strength},
    }

    def draw():
        picture, axes = panels(3)
        disc(axes[0], 20.0)
        for member, y in zip(members, offsets, strict=False):
            if np.isclose(y % 2.0, 0.0, atol=0.06) or y < 0.11:
                axes[0].plot(member.position[:, 0, 0], member.position[:, 0, 1], linewidth=0.8)
        axes[0].set(xlim=(-45, 60), ylim=(-50, 50), xlabel="x/a", ylabel="y/a", title="alpha = 0.6")
        axes[1].plot(offsets, by_offset, "o-", markersize=3)
        axes[1].set(xlabel="y0/a", ylabel="outgoing angle, degrees", title="alpha = 0.6")
        axes[2].plot(strengths, by_strength, "o-", markersize=3, label="simulated")
        fine = np.linspace(0.05, 0.59, 60)
        near = [theory.scattering_angle(alpha, 20.0, 0.1) for alpha in fine]
        axes[2].plot(fine, [math.nan if a is None else math.degrees(a) for a in near], "--", label="near wall")
        axes[2].set(xlabel="alpha", ylabel="outgoing angle, degrees", title="y0 = 0.1")
        axes[2].legend()
        return picture

    return Reproduction(tables, rows, draw)

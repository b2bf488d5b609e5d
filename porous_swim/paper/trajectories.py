"""Figures TrajectoriesA and TrajectoriesB: single escapes, and the two measures of trapping against each other."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.noise import Case, trapping_times
from porous_swim.paper.scan import paper_scene, pitch_of, run_changes

TITLES = {
    "TrajectoriesA": "Height and pitch of three pushers at a colloid of radius 20 (alpha = 0.8, D = 0.002)",
    "TrajectoriesB": "T_h against T_theta at (A, alpha) = (20, 0.8) and (80, 0.4), D = 0.002",
}
CASES = (Case(20.0, 0.8, 0.002), Case(80.0, 0.4, 0.002))


def reproduce_a(quick: bool) -> Reproduction:
    """h(t) and theta(t)."""
    (member,) = run_changes(paper_scene("trajectories_a"), [{}])
    height, pitch = pitch_of(member, 20.0)
    table = {"time": member.time}
    for i in range(3):
        table |= {f"height{i}": height[:, i], f"pitch{i}": pitch[:, i]}

    def draw() -> Any:
        picture, axes = panels(2)
        for i in range(3):
            axes[0].plot(member.time, height[:, i], linewidth=0.8)
            axes[1].plot(member.time, pitch[:, i], linewidth=0.8)
        axes[0].axhline(1.5, color="0.5", linestyle="--")
        axes[0].set(xlabel="t U/a", ylabel="h/a", ylim=(0.9, 4.0))
        axes[1].axhline(0.3, color="0.5", linestyle="--")
        axes[1].set(xlabel="t U/a", ylabel=r"$\theta$")
        return picture

    return Reproduction({"ways": table}, [Row("least height over the ways", float(height.min()))], draw)


def reproduce_b(quick: bool) -> Reproduction:
    """Which of the two comes first, and how they go together."""
    results = trapping_times(paper_scene("trajectories_b").replace({"swimmers.count": 300} if quick else {}), CASES)
    rows, tables = [], {}
    for case, times in zip(CASES, results, strict=True):
        n = len(times.height)
        share = times.n_late / n
        known = (0.06, 0.005) if case is CASES[0] else (None, 0.0)  # a rounded number
        rows += [
            Row(
                f"{case.text}: share with T_theta > T_h",
                share,
                float(np.sqrt(share * (1 - share) / n)),
                independent=known[0],
                independent_error=known[1],
            ),
            Row(f"{case.text}: correlation of T_h and T_theta", float(np.corrcoef(times.height, times.pitch)[0, 1])),
        ]
        tables[f"A{case.radius:g}"] = {"T_theta": times.pitch, "T_h": times.height}

    def draw() -> Any:
        picture, axes = panels(2)
        for axis, case, times in zip(axes, CASES, results, strict=True):
            axis.plot(times.pitch, times.height, ".", markersize=2)
            top = float(np.quantile(times.height, 0.99))
            axis.plot([0, top], [0, top], "--", color="0.5")
            axis.set(title=case.text, xlabel="T_theta U/a", ylabel="T_h U/a", xlim=(0, top), ylim=(0, top))
        return picture

    return Reproduction(tables, rows, draw)

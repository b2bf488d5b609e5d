"""Figure Basin: from how far a swimmer parallel to the surface is still drawn to it."""

from __future__ import annotations

import numpy as np

from porous_swim.analysis import theory
from porous_swim.batch import Member
from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.scan import paper_scene, thresholds
from porous_swim.scene import Scene

NAME = "Basin"
TITLE = "Basin depth h* from pitch 0 against radius and dipole strength, and over five decades of alpha^2 A"
SINGLE = {(200.0, 0.8): (2.4508, "about 2.5"), (20.0, 0.8): (1.5351, ""), (200.0, 0.4): (1.858, ""),
          (50.0, 0.8): (1.852, "")}  # fmt: skip


def reproduce(quick: bool) -> Reproduction:
    """Bisection in the height of the start for many colloids and strengths at once."""
    scene = paper_scene("capture")
    decades = np.geomspace(1.0, 1e5, 6 if quick else 21)
    strengths = (0.4, 0.8) if quick else (0.2, 0.4, 0.8)
    cases = [*SINGLE, *((float(product / alpha**2), alpha) for alpha in strengths for product in decades)]
    guess = np.array([theory.basin_depth(alpha, A) for A, alpha in cases])
    depth = thresholds(
        np.maximum(1.0 + 1e-9, 0.7 * guess), 1.5 * guess + 0.3, lambda i, h: _at_height(scene, *cases[i], h), _escapes,
        n_batches=4,
    )  # fmt: skip
    rows = [
        Row(
            f"h* at A = {A:g}, alpha = {alpha:g}",
            depth[i],
            paper=paper,
            independent=value,
            digit=1e-4 if i < 2 else 1e-3,
        )
        for i, ((A, alpha), (value, paper)) in enumerate(SINGLE.items())
    ]
    radius, alpha = np.array(cases).T
    product = alpha**2 * radius
    large = product > 100.0
    exponent, prefactor = np.polyfit(np.log(product[large]), np.log(depth[large]), 1)
    rows += [
        Row("exponent of alpha^2 A, above 100", exponent, paper="1/5", independent=0.2002, digit=1e-3),
        Row("prefactor of (alpha^2 A)^0.2, above 100", float(np.exp(prefactor)), paper="0.96"),
    ]
    columns = {"radius": radius, "alpha": alpha, "alpha2_A": product, "depth": depth, "closed_form": guess}

    def draw():
        picture, axes = panels(2)
        for a in strengths:
            own = alpha == a
            order = np.argsort(radius[own])
            axes[0].loglog(radius[own][order], depth[own][order], "o-", markersize=3, label=f"alpha = {a:g}")
        axes[0].set(xlabel="A/a", ylabel="h*/a")
        axes[0].legend()
        order = np.argsort(product)
        axes[1].loglog(product[order], depth[order], "o", markersize=3, label="simulated")
        axes[1].loglog(product[order], guess[order], "--", label="0.96 (alpha^2 A)^(1/5)")
        axes[1].set(xlabel="alpha^2 A", ylabel="h*/a")
        axes[1].legend()
        return picture

    return Reproduction({"depths": columns}, rows, draw)


def _at_height(scene: Scene, A: float, alpha: float, h: float) -> Scene:
    return scene.replace(
        {
            "obstacles.radius": A, "swimmers.dipole_strength": alpha, "swimmers.release.position": [0.0, A + h],
            "run.time_step": 10.0, "run.duration": 20000.0, "record.every": 20000.0,
        }
    )  # fmt: skip


def _escapes(member: Member) -> bool:
    """Whether the swimmer never touches."""
    return len(member.encounters["swimmer"]) == 0

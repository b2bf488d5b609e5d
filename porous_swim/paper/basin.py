"""Figure Basin: from how far a swimmer parallel to the surface is still drawn to it."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim import theory
from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.scan import paper_scene, thresholds
from porous_swim.running.batch import Member
from porous_swim.scene.scene import Scene

NAME = "Basin"
TITLE = "Basin depth h* from pitch 0 against radius and dipole strength, and over five decades of alpha^2 A"
SINGLE = {(200.0, 0.8): (2.4508, "about 2.5"), (20.0, 0.8): (1.5351, ""), (200.0, 0.4): (1.858, ""),
          (50.0, 0.8): (1.852, "")}  # fmt: skip


def reproduce(quick: bool) -> Reproduction:
    """Bisection in the height of the start for many colloids and strengths at once."""
    scene = paper_scene("basin")
    decades = np.geomspace(1.0, 1e5, 6 if quick else 21)
    strengths = (0.4, 0.8) if quick else (0.2, 0.4, 0.8)
    cases = [*SINGLE, *((float(product / alpha**2), alpha) for alpha in strengths for product in decades)]
    guess = np.array([theory.basin_depth(alpha, A) for A, alpha in cases])
    depth = _depths(scene, cases, guess)
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
        Row("prefactor of (alpha^2 A)^0.2, above 100", float(np.exp(prefactor)), paper="0.96", independent=0.9285),
    ]
    columns = {"radius": radius, "alpha": alpha, "alpha2_A": product, "depth": depth, "closed_form": guess}

    def draw() -> Any:
        picture, axes = panels(2)
        for a in strengths:
            own = alpha == a
            order = np.argsort(radius[own])
            axes[0].loglog(radius[own][order], depth[own][order], "o-", markersize=3, label=rf"$\alpha$ = {a:g}")
        axes[0].set(xlabel="A/a", ylabel="h*/a")
        axes[0].legend()
        order = np.argsort(product)
        axes[1].loglog(product[order], depth[order], "o", markersize=3, label="simulated")
        axes[1].loglog(product[order], guess[order], "--", label=r"$0.96\,(\alpha^2 A)^{1/5}$")
        axes[1].set(xlabel=r"$\alpha^2 A$", ylabel="h*/a")
        axes[1].legend()
        return picture

    return Reproduction({"depths": columns}, rows, draw)


def _depths(scene: Scene, cases: list[tuple[float, float]], guess: np.ndarray) -> np.ndarray:
    """Depths (n,) of cases (radius, strength) near guesses (n,), in batches of like radius, as those last alike."""
    depth = np.empty(len(cases))
    decades = np.floor(np.log10([A for A, _ in cases]))
    for decade in np.unique(decades):
        own = np.flatnonzero(decades == decade)
        # without flow a swimmer that starts along the surface is at twice its height after sqrt(2 A h)
        longest = max(float(np.sqrt(2.0 * cases[i][0] * guess[i])) for i in own)
        duration = float(np.ceil(longest / 5.0) * 20.0)

        def start(i: int, height: float, own: np.ndarray = own, duration: float = duration) -> Scene:
            A, alpha = cases[own[i]]
            return _at_height(scene, A, alpha, height, duration)

        low, high = np.maximum(1.0 + 1e-9, 0.7 * guess[own]), 1.5 * guess[own] + 0.3
        depth[own] = thresholds(low, high, start, _escapes, n_batches=9)
    return depth


def _at_height(scene: Scene, A: float, alpha: float, h: float, duration: float) -> Scene:
    return scene.replace(
        {
            "obstacles.radius": A, "swimmers.dipole_strength": alpha, "swimmers.release.position": [0.0, A + h],
            "run.duration": duration, "record.every": duration,
        }
    )  # fmt: skip


def _escapes(member: Member) -> bool:
    """Whether the swimmer never touches."""
    return len(member.encounters["swimmer"]) == 0

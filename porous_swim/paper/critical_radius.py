"""Figure Ac_compare: the critical radius against the dipole strength, pushers and pullers."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim import theory
from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.scan import is_held, paper_scene, pitch_of, thresholds
from porous_swim.running.batch import Member
from porous_swim.scene.scene import Scene

NAME = "Ac_compare"
TITLE = "Critical radius of pushers (a) and pullers (b) against the dipole strength"
PUSHERS = {0.2: 182.230, 0.4: 48.768, 0.6: 23.899, 0.8: 15.061, 1.0: 10.866}
PULLERS = {-0.4: 8.117, -0.6: 5.860, -0.8: 4.714, -1.2: 3.541}
TILT = 0.01  # rad off nose-on: whether it grows tells the stability of a puller's rest


def reproduce(quick: bool) -> Reproduction:
    """Swimmers in contact at radii ever nearer to the critical one."""
    scene = paper_scene("critical_radius")
    strengths = [*PUSHERS, *PULLERS]
    listed = np.array([*PUSHERS.values(), *PULLERS.values()])
    found = thresholds(
        0.9 * listed, 1.1 * listed, lambda i, A: _contact(scene, strengths[i], A), _stays, n_batches=6 if quick else 8
    )
    leading = [theory.critical_radius(alpha, order="leading") for alpha in strengths]
    rows = [
        Row(f"A_c at alpha = {alpha:g}", ours, paper=f"{first:.3g} (leading order)", independent=value, digit=1e-3)
        for alpha, ours, first, value in zip(strengths, found, leading, listed, strict=True)
    ]
    exact = [theory.critical_radius(alpha) for alpha in strengths]
    columns = {"alpha": np.array(strengths), "simulated": found, "exact": np.array(exact), "leading": np.array(leading)}

    def draw() -> Any:
        picture, axes = panels(2)
        for axis, sign, name in ((axes[0], 1.0, "pushers"), (axes[1], -1.0, "pullers")):
            size = np.geomspace(0.1, 1.5, 60)
            exact_line = [theory.critical_radius(sign * a) for a in size]
            leading_line = [theory.critical_radius(sign * a, order="leading") for a in size]
            axis.loglog(size, exact_line, "-", label="exact")
            axis.loglog(size, leading_line, "--", label="leading")
            own = np.sign(columns["alpha"]) == sign
            axis.loglog(np.abs(columns["alpha"][own]), found[own], "ko", label="simulated")
            axis.set(title=name, xlabel=r"$|\alpha|$", ylabel="critical radius $A_c/a$")
            axis.legend()
        return picture

    return Reproduction({"radii": columns}, rows, draw)


def _contact(scene: Scene, alpha: float, A: float) -> Scene:
    """Pushers start parallel to the surface, pullers nearly nose-on."""
    pitch = 0.0 if alpha > 0.0 else -0.5 * np.pi + TILT
    return scene.replace(
        {
            "obstacles.radius": A, "swimmers.dipole_strength": alpha,
            "swimmers.release": {
                "kind": "point", "position": [0.0, A + 1.0], "director": [float(np.cos(pitch)), float(np.sin(pitch))]
            },
        }
    )  # fmt: skip


def _stays(member: Member) -> bool:
    """A pusher is still held; a puller's tilt has shrunk."""
    if member.scene.swimmers.dipole_strength > 0.0:
        return is_held(member)
    _, pitch = pitch_of(member, 0.0)
    return bool(pitch[-1, 0] + 0.5 * np.pi < TILT)

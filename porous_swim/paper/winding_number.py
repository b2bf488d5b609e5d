"""Figure WindingNumber: how far round a pusher slides at colloids just too small to hold it."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim import theory
from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.scan import paper_scene, run_changes

NAME = "WindingNumber"
TITLE = "Turns from contact to lift-off at A = A_c (1 - eps), alpha = 0.8"
LISTED = {0.2: 0.1527, 0.1: 0.1722, 0.05: 0.1967, 1e-2: 0.2628, 1e-3: 0.3658, 1e-4: 0.4710}
PER_DECADE = 0.1055


def reproduce(quick: bool) -> Reproduction:
    """One batch over eps."""
    scene = paper_scene("winding_number")
    critical = theory.critical_radius(0.8)
    eps = np.unique([*LISTED, *np.geomspace(1e-4, 0.3, 8 if quick else 30)])
    members = run_changes(scene, [{"obstacles.radius": critical * (1.0 - float(e))} for e in eps])
    turns = np.array([float(member.encounters["release_winding"][0]) for member in members])
    rows = [Row(f"W at eps = {e:g}", turns[eps == e][0], independent=value, digit=1e-4) for e, value in LISTED.items()]
    slope = float(turns[eps == 1e-4][0] - turns[eps == 1e-3][0])
    rows.append(Row("turns per decade of eps, 1e-4 to 1e-3", slope, independent=PER_DECADE, digit=5e-4))

    def draw() -> Any:
        picture, (axis,) = panels(1, width=5.0)
        axis.semilogx(eps, turns, "o-", markersize=4)
        axis.set(xlabel="$1 - A/A_c$", ylabel="winding number W")
        return picture

    return Reproduction({"winding": {"eps": eps, "winding": turns}}, rows, draw)

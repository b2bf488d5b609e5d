"""Checks that every part must pass, ours and those of plug-ins: layouts, releases, flows, motilities and the rest.

One line tests a new part: `check_layout({"layout": "ring", "radius": 2.0, ...})`. None needs pytest: what fails raises
an AssertionError whose message says which part, what and where.
"""

from __future__ import annotations

from porous_swim.testing.flows import check_flow
from porous_swim.testing.layouts import check_layout
from porous_swim.testing.models import check_described
from porous_swim.testing.motilities import check_motility
from porous_swim.testing.observers import check_observer
from porous_swim.testing.releases import check_release
from porous_swim.testing.statistics import check_coverage, check_statistic
from porous_swim.testing.steppers import check_stepper

__all__ = [
    "check_coverage",
    "check_described",
    "check_flow",
    "check_layout",
    "check_motility",
    "check_observer",
    "check_release",
    "check_statistic",
    "check_stepper",
]

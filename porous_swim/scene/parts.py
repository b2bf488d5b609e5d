"""The parts that a scene may name. Imported before any other is registered, so that ours stand first."""

from __future__ import annotations

from porous_swim.core.registry import forget, parts_of, register
from porous_swim.observers.part import ObserverPart
from porous_swim.obstacles import layouts
from porous_swim.obstacles.base import Layout
from porous_swim.physics import hydrodynamics
from porous_swim.physics.flow import Flow
from porous_swim.physics.motility import Motility
from porous_swim.swimmers import release
from porous_swim.swimmers.base import Release

__all__ = [
    "Flow", "Layout", "Motility", "ObserverPart", "Release", "forget", "hydrodynamics", "layouts", "parts_of",
    "register", "release",
]  # fmt: skip

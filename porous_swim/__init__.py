"""Microswimmers among colloids: capture, orbits, hops and transport in porous media.

Lengths in swimmer half-lengths a, speeds in swimming speeds U, times in a/U. Names are loaded when they are
first used: reading results starts neither Taichi nor a device.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from porous_swim.core import kernel_cache

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "False")  # before Taichi is imported anywhere
kernel_cache.prepare()

if TYPE_CHECKING:
    __version__: str
    from porous_swim import analysis, theory
    from porous_swim.core.errors import DeviceError, PorousSwimError, ResultsError, RunError, SceneError
    from porous_swim.core.parts import Part
    from porous_swim.engine.probe import contact_height, drift
    from porous_swim.observers.base import Every, Frame, Observer, RunView
    from porous_swim.observers.part import ObserverPart
    from porous_swim.obstacles.base import Layout
    from porous_swim.physics.flow import Flow
    from porous_swim.physics.motility import Motility
    from porous_swim.reporting.write import report
    from porous_swim.results.loading import load_results
    from porous_swim.results.results import Results
    from porous_swim.running.run import run
    from porous_swim.running.simulation import Simulation
    from porous_swim.running.sweeps import FailedRun, sweep
    from porous_swim.scene.parts import register
    from porous_swim.scene.scene import Scene, load_scene
    from porous_swim.swimmers.base import Release
    from porous_swim.theory.flow_field import flow_field

__all__ = [
    "DeviceError",
    "Every",
    "FailedRun",
    "Flow",
    "Frame",
    "Layout",
    "Motility",
    "Observer",
    "ObserverPart",
    "Part",
    "PorousSwimError",
    "Release",
    "Results",
    "ResultsError",
    "RunError",
    "RunView",
    "Scene",
    "SceneError",
    "Simulation",
    "__version__",
    "analysis",
    "contact_height",
    "drift",
    "flow_field",
    "load_results",
    "load_scene",
    "register",
    "report",
    "run",
    "sweep",
    "theory",
]

_HOME = {
    "theory.flow_field": ("flow_field",),
    "core.errors": ("DeviceError", "PorousSwimError", "ResultsError", "RunError", "SceneError"),
    "core.parts": ("Part",),
    "obstacles.base": ("Layout",),
    "physics.flow": ("Flow",),
    "physics.motility": ("Motility",),
    "swimmers.base": ("Release",),
    "scene.parts": ("register",),
    "observers.part": ("ObserverPart",),
    "observers.base": ("Every", "Frame", "Observer", "RunView"),
    "reporting.write": ("report",),
    "results.results": ("Results",),
    "results.loading": ("load_results",),
    "scene.scene": ("Scene", "load_scene"),
    "running.run": ("run",),
    "running.simulation": ("Simulation",),
    "running.sweeps": ("FailedRun", "sweep"),
    "engine.probe": ("contact_height", "drift"),
}
_MODULES = {"analysis": "analysis", "theory": "theory"}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("porous_swim")
    if name in _MODULES:
        return import_module(f"porous_swim.{_MODULES[name]}")
    if name in _MODULE_OF:
        return getattr(import_module(f"porous_swim.{_MODULE_OF[name]}"), name)
    raise AttributeError(f"module 'porous_swim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__

"""Microswimmers among colloids: capture, orbits, hops and transport in porous media.

Lengths in swimmer half-lengths a, speeds in swimming speeds U, times in a/U. Names are loaded when they are
first used: reading results starts neither Taichi nor a device.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from porous_swim import kernel_cache

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "False")  # before Taichi is imported anywhere
kernel_cache.prepare()

if TYPE_CHECKING:
    __version__: str
    from porous_swim import analysis
    from porous_swim.analysis import theory
    from porous_swim.analysis.flow import flow_field
    from porous_swim.engine.probe import contact_height, drift
    from porous_swim.errors import DeviceError, PorousSwimError, ResultsError, RunError, SceneError
    from porous_swim.reporting.write import report
    from porous_swim.results import Results
    from porous_swim.results_loading import load_results
    from porous_swim.runs import run
    from porous_swim.scene import Scene, load_scene
    from porous_swim.simulation import Simulation
    from porous_swim.sweeps import FailedRun, sweep

__all__ = [
    "DeviceError",
    "FailedRun",
    "PorousSwimError",
    "Results",
    "ResultsError",
    "RunError",
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
    "report",
    "run",
    "sweep",
    "theory",
]

_HOME = {
    "analysis.flow": ("flow_field",),
    "errors": ("DeviceError", "PorousSwimError", "ResultsError", "RunError", "SceneError"),
    "reporting.write": ("report",),
    "results": ("Results",),
    "results_loading": ("load_results",),
    "scene": ("Scene", "load_scene"),
    "runs": ("run",),
    "simulation": ("Simulation",),
    "sweeps": ("FailedRun", "sweep"),
    "engine.probe": ("contact_height", "drift"),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("porous_swim")
    if name == "analysis":
        return import_module("porous_swim.analysis")
    if name == "theory":
        return import_module("porous_swim.analysis.theory")
    if name in _MODULE_OF:
        return getattr(import_module(f"porous_swim.{_MODULE_OF[name]}"), name)
    raise AttributeError(f"module 'porous_swim' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__

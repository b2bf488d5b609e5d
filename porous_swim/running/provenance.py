"""What made a run: enough to make it again."""

from __future__ import annotations

import platform
from importlib.metadata import version
from typing import Any

from porous_swim.running.simulation import Simulation
from porous_swim.scene.identity import plugins_of

PACKAGES = ("taichi", "numpy", "scipy", "pyarrow", "rerun-sdk", "pydantic")


def provenance_of(simulation: Simulation) -> dict[str, Any]:
    """Program, scene, seed, device and packages of a run."""
    scene = simulation.scene
    return {
        "version": version("porous_swim"), "scene": scene.name, "scene_id": scene.scene_id, "seed": scene.run.seed,
        "device": simulation.backend.device, "precision": scene.precision, "threads": simulation.backend.threads,
        "python": platform.python_version(), "packages": {name: version(name) for name in PACKAGES} | plugins_of(scene),
    }  # fmt: skip

"""The small package of plug-ins, installed where a child process finds it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.support.commands import ROOT, environment

PACKAGE = Path(__file__).with_name("plugin_package")
SCENE = """\
swimmers: {count: 60, dipole_strength: 0.5, release: {kind: start_line, length: 12.0}}
hydrodynamics: {kind: attraction}
obstacles: {layout: ring, radius: 2.0, ring_radius: 9.0, count: 9}
domain: {dimensions: 2}
run: {time_step: 0.01, duration: 10, seed: 1, integrator: euler, threads: 1}
record: {every: 1.0, swimmers: 60, trails: 0}
"""


def install(folder: Path) -> None:
    """Install the package into `folder`, without touching the environment of the tests."""
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*command, "--target", str(folder), str(PACKAGE)], check=True, capture_output=True)


def run_with(path: Path, *arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run Python with `arguments`, and what is in the folder `path` installed, to its end."""
    env = environment(PYTHONPATH=os.pathsep.join([str(ROOT), str(path)]))
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=300)

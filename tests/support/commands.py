"""The command line in a process of its own, and a small scene for it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))
SMALL = """\
name: small
swimmers: {count: 40, dipole_strength: 4.0}
noise: {kind: brownian, translational_diffusion: 0.006}
obstacles: {layout: hexagonal, radius: 3.5, spacing: 10.0, cells: [2, 1]}
domain: {dimensions: 2}
run: {time_step: 0.001, duration: 1, seed: 1}
record: {every: 0.1, swimmers: 20, trails: 5}
"""
NO_END = ("--set", "run.duration=1000000", "--set", "record.every=1")  # hours, unless it is interrupted


def environment(**more: object) -> dict[str, str]:
    """The environment of a child process: the tree under test comes first."""
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths)), **{k: str(v) for k, v in more.items()}}


def porous_swim(*arguments: object, cwd: Path, **options: object) -> subprocess.CompletedProcess[str]:
    """Run the command line to its end."""
    command = [sys.executable, "-m", "porous_swim", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, env=environment(), capture_output=True, text=True, timeout=300, **options)


def start(
    *arguments: object,
    cwd: Path,
    stdout: int | IO[str] = subprocess.PIPE,
    stderr: int = subprocess.PIPE,
    **more: object,
) -> subprocess.Popen[str]:
    """Start the command line; `more` goes into its environment. It heeds a hang-up, also of tests under nohup."""
    command = [sys.executable, "-m", "porous_swim", *map(str, arguments)]
    return subprocess.Popen(
        command, cwd=cwd, env=environment(**more), stdout=stdout, stderr=stderr, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL) if os.name == "posix" else None,
    )  # fmt: skip


def small_scene(folder: Path, text: str = SMALL) -> Path:
    """A scene file of some forty swimmers."""
    path = folder / "small.yaml"
    path.write_text(text)
    return path

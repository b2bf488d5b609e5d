"""One scene with several sets of parameters, run one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from porous_swim.results import Results
from porous_swim.scene import Scene
from porous_swim.simulation import run


def sweep(
    scene: Scene, changes: Sequence[Mapping[str, Any]], *, out: Path | str | None = None, overwrite: bool = False,
    progress: bool = False, recording: bool = True,
) -> list[Results]:  # fmt: skip
    """Run a scene once for each set of changed keys, as `Scene.replace` takes them; the kernel is compiled once.

    Each set has results of its own, those of its scene run alone, so that every statistic of `analysis` is one of each
    set: swimmers, colloids and duration may differ. All have the seed of `scene` and so the same noise, unless
    each has a `run.seed` of its own: only then are their errors independent.

    Args:
        scene: what all sets share.
        changes: a map from dotted keys to values for each set.
        out: a folder for the run folders `1`, `2`, ... in the order of `changes`; None keeps everything in memory.
        overwrite: see `run`.
        progress: see `run`.
        recording: see `run`.

    Raises:
        SceneError: a set that is no scene, before anything is run.
        KeyboardInterrupt: a run was interrupted; what was seen until then is in `out`, and no other run begins.
    """
    results = []
    for number, each in enumerate([scene.replace(change) for change in changes], start=1):
        folder = None if out is None else Path(out) / str(number)
        results.append(run(each, out=folder, overwrite=overwrite, progress=progress, recording=recording))
        if results[-1].summary["status"] == "interrupted":
            raise KeyboardInterrupt
    return results

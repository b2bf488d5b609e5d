"""One scene with several sets of parameters, run one after the other."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from porous_swim.core.console import tell
from porous_swim.core.errors import DeviceError, PorousSwimError, ResultsError, SceneError
from porous_swim.results.loading import load_results
from porous_swim.results.manifest import SUMMARY
from porous_swim.results.results import Results
from porous_swim.running.footprint import require_memory
from porous_swim.running.run import run
from porous_swim.running.simulation import Start
from porous_swim.scene.scene import Scene, load_scene

_MOST_TOLD = 10  # mistakes in one message


@dataclass(frozen=True)
class Point:
    """One set of a sweep: its `number` from 1, what it changes, its scene, and the folder of its run, if any."""

    number: int
    changes: Mapping[str, Any]
    scene: Scene
    folder: Path | None

    def __str__(self) -> str:
        """`set 2 (swimmers.dipole_strength=0.8)`."""
        return _named(self.number, self.changes)


@dataclass(frozen=True)
class FailedRun:
    """What a sweep has in place of the results of a run that failed: its `point`, and the `error`."""

    point: Point
    error: Exception

    def __str__(self) -> str:
        """Which set failed, and why."""
        return f"{self.point} failed: {self.error or type(self.error).__name__}"

    def __getattr__(self, name: str) -> Any:
        """There are no results: say why, where someone takes this for some."""
        if name.startswith("__") or name in ("point", "error"):  # while it is being unpickled
            raise AttributeError(name)
        raise AttributeError(f"there is no {name}, as {self}")


def sweep(
    scene: Scene, changes: Sequence[Mapping[str, Any]], *, out: Path | str | None = None, overwrite: bool = False,
    progress: bool = False, recording: bool = True,
) -> list[Results | FailedRun]:  # fmt: skip
    """Run a scene once for each set of changed keys, as `Scene.replace` takes them; the kernel is compiled once.

    Each set has results of its own, those of its scene run alone, so that every statistic of `analysis` is one of each
    set: swimmers, colloids and duration may differ. All have the seed of `scene` and so the same noise, unless
    each has a `run.seed` of its own: only then are their errors independent.

    Colloids and swimmers of all sets are placed before the first one runs, so that a mistake in any costs no time. A
    run that fails all the same leaves a `FailedRun` in its place, with the error, and the next one begins.

    Args:
        scene: what all sets share.
        changes: a map from dotted keys to values for each set.
        out: a folder for the run folders `1`, `2`, ... in the order of `changes`; None keeps everything in memory.
            A run of the same scene (by `scene_id`) that finished there is read, not run again; one that was
            interrupted or failed is run anew.
        overwrite: run every set, whatever is in its folder.
        progress: see `run`; failures are told, too.
        recording: see `run`.

    Raises:
        SceneError: sets that are no scene, or whose colloids or swimmers do not fit, or not into memory; before
            anything is run.
        DeviceError: the device of a scene is not here; likewise.
        ResultsError: a folder holds something else; likewise.
        KeyboardInterrupt: a run was interrupted; what was seen until then is in `out`, and no other run begins.
    """
    points = _checked(scene, changes, None if out is None else Path(out))
    done = {point.number: _before(point) for point in points if point.folder is not None and not overwrite}
    results: list[Results | FailedRun] = []
    for point in points:
        if (found := done.get(point.number)) is not None:
            results.append(found)
            continue
        try:
            # what `_before` let pass may be overwritten: the remains of the same run
            made = run(point.scene, out=point.folder, overwrite=True, progress=progress, recording=recording)
        except Exception as error:
            results.append(FailedRun(point, error))
            if progress:
                tell(str(results[-1]), sys.stderr)
            continue
        results.append(made)
        if made.summary["status"] == "interrupted":
            raise KeyboardInterrupt
    return results


def _checked(scene: Scene, changes: Sequence[Mapping[str, Any]], out: Path | None) -> list[Point]:
    """The points, each of which can start; `SceneError` or `DeviceError` tells of all that cannot."""
    points: list[Point] = []
    mistakes: list[str] = []
    kind: type[PorousSwimError] = DeviceError
    for number, change in enumerate(changes, start=1):
        try:
            each = scene.replace(change)
            require_memory(each)
            Start.of(each)
        except (SceneError, DeviceError) as error:
            mistakes.append(f"{_named(number, change)}: {error}")
            kind = SceneError if isinstance(error, SceneError) else kind
        else:
            points.append(Point(number, change, each, None if out is None else out / str(number)))
    if mistakes:
        more = len(mistakes) - _MOST_TOLD
        raise kind("\n".join(mistakes[:_MOST_TOLD] + ([f"and {more} more sets"] if more > 0 else [])))
    return points


def _before(point: Point) -> Results | None:
    """Results of the point's own run where that finished; `ResultsError` where its folder holds something else."""
    folder = point.folder
    if folder is None or not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return None
    try:
        earlier, finished = _identity(folder)
    except (PorousSwimError, OSError, ValueError, KeyError, TypeError):
        earlier, finished = "", False
    if earlier != point.scene.scene_id:
        raise ResultsError(
            f"{point}: {folder} holds something else than a run of this set: give another `out`, or overwrite=True"
        )
    return load_results(folder) if finished else None


def _identity(folder: Path) -> tuple[str, bool]:
    """The `scene_id` of the run in a folder, and whether it finished."""
    path = folder / SUMMARY
    if not path.is_file():  # it died
        return load_scene(folder / "scene.yaml").scene_id, False
    summary = json.loads(path.read_text(encoding="utf-8"))
    return summary["provenance"]["scene_id"], summary["status"] == "finished"


def _named(number: int, changes: Mapping[str, Any]) -> str:
    told = ", ".join(f"{key}={value}" for key, value in changes.items())
    return f"set {number} ({told if len(told) <= 200 else told[:197] + '...'})"

"""A run as a report takes it: results, scene, colour, and what several sections need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from porous_swim.analysis import hop_table
from porous_swim.analysis.places import all_round
from porous_swim.core.errors import SceneError
from porous_swim.plots.scales import Scales, common
from porous_swim.plots.style import RUN_COLORS, Data, Shown, named
from porous_swim.results.encounter_table import MANY
from porous_swim.results.results import Results
from porous_swim.scene.identity import file_hashes, resolved
from porous_swim.scene.scene import Scene, load_scene

_FOR_PEOPLE = ("name", "description", "record")
_MOST_TOLD = 2  # keys in the name of a run
_FEWEST_SWIMMERS = 100  # that stand for all


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a report."""

    label: str
    color: str
    results: Results
    scene: Scene | None
    """None: there is no `scene.yaml`, or it cannot be read any more, for the reason in `no_scene`."""
    no_scene: str
    n_runs: int
    """In the report."""

    @property
    def scales(self) -> Scales | None:
        """What a and a/U are in the laboratory."""
        return Scales.of(self.results.info.units)

    @property
    def all_round(self) -> bool:
        """Whether swimmers can go round every colloid."""
        return all_round(self.results.colloids)

    @cached_property
    def flat_normal(self) -> np.ndarray | None:
        """Unit normal (3,) of the one colloid where it is flat; None where all are round, or its scene is not known."""
        if self.scene is None or self.all_round:
            return None
        _, normals = self.scene.place_obstacles().above(0, np.zeros((1, 3)), 0.0)
        return np.asarray(normals[0])

    @property
    def one_in(self) -> int:
        """Distributions of encounters and hops are of one swimmer in so many, to fit into memory; 1: of all."""
        most = max(self.results.info.n_swimmers // _FEWEST_SWIMMERS, 1)
        return min(-(-len(self.results.stored) // MANY) or 1, most)

    @cached_property
    def encounters(self) -> pa.Table:
        """The encounters of those swimmers."""
        return self.results.encounters if self.one_in == 1 else self.results.stored.of_one_in(self.one_in)

    @cached_property
    def hops(self) -> pa.Table:
        """The run's `hop_table`."""
        return hop_table(self.encounters, self.results.colloids)

    def says(self, sentence: str) -> str:
        """A sentence about this run, which names it where there are others."""
        return sentence if self.n_runs == 1 else f"{self.label}: {sentence}"

    def shows(self, data: Data) -> Shown[Data]:
        """Data of this run for a picture."""
        return Shown(named(self.label), self.color, data)


def runs_of(every: Sequence[Results]) -> list[Run]:
    """Runs named by their folders, or by their scenes where they were kept in memory."""
    scenes = [_scene(results) for results in every]
    labels = _labels(every, differences([scene for scene, _ in scenes]))
    return [
        Run(label, RUN_COLORS[i % len(RUN_COLORS)], results, *scene, len(every))
        for i, (label, results, scene) in enumerate(zip(labels, every, scenes, strict=True))
    ]


def differences(scenes: Sequence[Scene | None]) -> dict[str, list[str]]:
    """Dotted keys in which scenes that are known differ, and what stands there in each; empty where there is nothing.

    What is for people alone, and how a run is recorded, is left out.
    """
    found = [{} if scene is None else dict(_leaves(resolved(scene))) | _named_files(scene) for scene in scenes]
    known = [each for each in found if each]
    keys = dict.fromkeys(key for each in known for key in each if key.split(".")[0] not in _FOR_PEOPLE)
    return {
        key: [each.get(key, "") for each in found] for key in keys if len({each.get(key, "") for each in known}) > 1
    }


def _named_files(scene: Scene) -> dict[str, str]:
    """The files that a scene names, by what is in them."""
    return {key: f"{scene.files[key].name} ({digits[:8]})" for key, digits in file_hashes(scene).items()}


def _leaves(data: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    for key, value in data.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", str(value)


def scales_of(runs: Sequence[Run]) -> Scales | None:
    """What holds for all runs of a picture."""
    return common([run.scales for run in runs])


def _labels(every: Sequence[Results], differing: Mapping[str, Sequence[str]]) -> list[str]:
    """Names of folders; whole paths where those do not differ; in memory what tells the scenes apart, or numbers."""
    names = [
        str(results.info.provenance.get("scene", "run")) if results.folder is None else results.folder.resolve().name
        for results in every
    ]
    if len(set(names)) < len(names):
        names = [
            name if results.folder is None else str(results.folder) for name, results in zip(names, every, strict=True)
        ]
    if len(set(names)) < len(names) and 0 < len(differing) <= _MOST_TOLD:
        told = [
            ", ".join(f"{key.rsplit('.', 1)[-1]} {_short(values[i])}" for key, values in differing.items() if values[i])
            for i in range(len(names))
        ]
        names = [f"{name} ({what})" if what else name for name, what in zip(names, told, strict=True)]
    if len(set(names)) < len(names):
        names = [f"{name} ({number})" for number, name in enumerate(names, start=1)]
    return names


def _short(value: str) -> str:
    """A number with many digits in four."""
    try:
        return value if len(value) <= 6 else f"{float(value):.4g}"
    except ValueError:
        return value


def _scene(results: Results) -> tuple[Scene | None, str]:
    if results.folder is None and results.scene is None:
        return None, "The run was kept in memory without its scene: what that says is not known here."
    try:
        if results.folder is None:
            return Scene.from_mapping(results.scene or {}), ""
        path = Path(results.folder) / "scene.yaml"
        if not path.is_file():
            return None, f"{path}: there is no such file, so what the scene says is not known."
        scene = load_scene(path)
        info = results.info
        if (scene.swimmers.count, scene.domain.dimensions) != (info.n_swimmers, info.dimensions):
            return None, f"{path}: the file is of another run, so what the scene says is not known."
        return scene, ""
    except SceneError as error:
        return None, f"The scene cannot be read, so what it says is not known: {error}"

"""The resolved scene as plain data, written to a folder, and the hash that names it."""

from __future__ import annotations

import filecmp
import hashlib
import json
import shutil
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any

from porous_swim.core.parts import Part
from porous_swim.core.registry import parts_in, plugin_of
from porous_swim.physics.motility import Steady
from porous_swim.results.manifest import RUN_NAMES
from porous_swim.scene.model import SceneModel
from porous_swim.scene.yaml_core import write_yaml


def resolved(scene: SceneModel) -> dict[str, Any]:
    """Return the scene with every default written out, as plain data that loads to the same scene."""
    data: dict[str, Any] = _tidy(scene.model_dump())
    data["record"] |= {
        "every": scene.record_period * scene.run.time_step,
        "swimmers": scene.n_recorded,
        "trails": scene.n_trails,
    }
    return data


def portable(scene: SceneModel) -> dict[str, Any]:
    """Return the same with full paths of the files that it names: it loads from anywhere."""
    data = resolved(scene)
    for key, path in scene.files.items():
        _section(data, key)["path"] = str(path.resolve())
    return data


def file_hashes(scene: SceneModel) -> dict[str, str]:
    """Return hexadecimal digits of what is in each file that the scene names, by dotted key."""
    return {key: hashlib.sha256(path.read_bytes()).hexdigest() for key, path in scene.files.items()}


def plugins_of(scene: SceneModel) -> dict[str, str]:
    """Return the versions of the packages, by name, from which parts of the scene come that are not ours."""
    return _plugins(parts_in(scene))


def _plugins(parts: Iterable[Part]) -> dict[str, str]:
    found = [plugin_of(type(part)) for part in parts]
    return {plugin.package: plugin.version for plugin in found if plugin is not None}


def scene_hash(scene: SceneModel) -> str:
    """Return 16 hexadecimal digits that differ when the result could."""
    data = resolved(scene)
    for key in ("name", "description", "record"):
        del data[key]
    data["run"] = {key: data["run"][key] for key in data["run"] if key not in ("device", "threads")}
    data["run"]["precision"] = scene.precision
    if data["obstacles"].get("seed") == scene.run.seed:  # as where it is left out
        del data["obstacles"]["seed"]
    if scene.swimmers.motility == Steady():  # as where it is left out
        del data["swimmers"]["motility"]
    for key, digits in file_hashes(scene).items():
        _section(data, key)["path"] = digits
    seen = set(map(id, parts_in(scene.record)))
    if plugins := _plugins(part for part in parts_in(scene) if id(part) not in seen):
        data["plugins"] = plugins
    text = json.dumps(data, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def copies(scene: SceneModel, folder: Path) -> dict[str, str]:
    """Return the names that copies of the files that a scene names get in `folder`, by dotted key.

    None has the name of a file that a run writes, nor that of a file of other content that is there.
    """
    names: dict[str, str] = {}
    for key, path in scene.files.items():
        section = key.split(".")[0]
        numbered = (f"{section}{number}_{path.name}" for number in ("", *range(2, 1 << 16)))
        taken = {*RUN_NAMES, *(name.casefold() for name in names.values())}
        names[key] = next(
            name for name in chain([path.name], numbered) if name.casefold() not in taken and _fits(path, folder / name)
        )
    return names


def _fits(path: Path, place: Path) -> bool:
    """Whether a copy of a file at `place` overwrites nothing."""
    return not place.exists() or (place.is_file() and filecmp.cmp(path, place, shallow=False))


def save(scene: SceneModel, folder: Path) -> None:
    """Write `scene.yaml` into `folder` and copy the files that it names beside it: it runs from there."""
    data, names = resolved(scene), copies(scene, folder)
    for key, path in scene.files.items():
        if not (folder / names[key]).exists():  # else it is there already, of a scene that is saved where it lies
            shutil.copyfile(path, folder / names[key])
        _section(data, key)["path"] = names[key]
    (folder / "scene.yaml").write_text(write_yaml(data), encoding="utf-8")


def _section(data: dict[str, Any], key: str) -> dict[str, Any]:
    """Return the map that holds the last part of a dotted key."""
    for part in key.split(".")[:-1]:
        data = data[part]
    return data


def _tidy(value: Any) -> Any:
    """Return dumped models as lists and maps without empty entries, the key that tells the kind first."""
    if isinstance(value, dict):
        keys = sorted(value, key=lambda key: key not in ("kind", "layout"))  # stable: the rest keeps its order
        return {key: _tidy(value[key]) for key in keys if value[key] is not None}
    return [_tidy(item) for item in value] if isinstance(value, tuple) else value

"""A scene: one run from its YAML file to checked numbers, in a, U and a/U."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import PrivateAttr, ValidationError, model_validator

from porous_swim.core.parts import UNITS_UNKNOWN, ContactHeight, KeyedError, SeveralKeyedError
from porous_swim.core.streams import Stream, generator
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.reach import check_reach
from porous_swim.scene.checks import disagreements
from porous_swim.scene.document import Document, KeyPath, frozen, plain, read_document
from porous_swim.scene.identity import resolved, save, scene_hash
from porous_swim.scene.limits import check_limits
from porous_swim.scene.messages import faults_of, keyed_fault, scene_error, sound_part
from porous_swim.scene.model import SceneModel, with_boundary
from porous_swim.scene.units import Units, UnitSystem
from porous_swim.scene.warnings import warnings_of
from porous_swim.scene.yaml_core import write_yaml
from porous_swim.swimmers.placement import Swimmers

_RIVALS: dict[KeyPath, KeyPath] = {  # setting one of two keys that exclude each other takes the other away
    ("swimmers", "dipole"): ("swimmers", "dipole_strength"),
    ("swimmers", "dipole_strength"): ("swimmers", "dipole"),
}


class Scene(SceneModel):
    """One run. Every random number follows from `run.seed`, but a medium has a seed of its own where one is set."""

    _document: Document = PrivateAttr(default_factory=lambda: Document({}))

    @classmethod
    def from_mapping(cls, data: Mapping[str, Any], *, folder: Path | str = ".") -> Scene:
        """Return the scene that plain data describes; files that it names are relative to `folder`."""
        return _validated(Document({"name": "scene", **plain(data)}), Path(folder))

    def replace(self, changes: Mapping[str, Any]) -> Scene:
        """Return the scene with new values at dotted keys, validated as a file would be.

        A value replaces what stands at its key whole, a map too. Defaults that follow from other keys do so
        again.
        """
        return _validated(_changed(self._document, changes), self._folder)

    def place_obstacles(self) -> ObstacleField:
        """Return the colloids, a function of the layout, the domain and `medium_seed` alone.

        SceneError where they do not fit, or where swimmers among them cannot be computed with these steps and digits.
        """
        try:
            field = self.obstacles.place(self.domain, generator(self.medium_seed, Stream.PLACEMENT), self._folder)
            check_reach(field, self.encounter.escape_height)
            check_limits(self, field)
            return field
        except KeyedError as error:
            raise self._placed(error) from None

    def place_swimmers(self, field: ObstacleField, contact_height: ContactHeight) -> Swimmers:
        """Return the swimmers at t = 0; `contact_height(sines of pitch, radii)` gives least heights."""
        rng = generator(self.run.seed, Stream.RELEASE)
        try:
            return self.swimmers.release.place(field, self.swimmers.count, rng, contact_height, folder=self._folder)
        except KeyedError as error:
            raise self._placed(error) from None

    def to_yaml(self) -> str:
        """Return the resolved scene as YAML that can be run: all defaults written out, in a and U."""
        return write_yaml(resolved(self))

    def save(self, folder: Path | str) -> None:
        """Write `scene.yaml` and the files that it names into an existing `folder`: it runs from there."""
        save(self, Path(folder))

    def warnings(self, field: ObstacleField | None = None) -> list[str]:
        """Return a sentence for each thing that is legal and seldom meant; without `field` the colloids are placed."""
        return warnings_of(self, field if field is not None else self.place_obstacles())

    @property
    def scene_id(self) -> str:
        """Hash of what decides the result: no names, record, device or threads, but named files."""
        return scene_hash(self)

    @property
    def inputs(self) -> list[Path]:
        """All files that make the scene: its own, unless it came from Python, and those that it names."""
        own = [] if self._document.file is None else [Path(self._document.file)]
        return [*own, *self.files.values()]

    @model_validator(mode="after")
    def _sections_agree(self) -> Scene:
        found = disagreements(self)
        if found:
            raise SeveralKeyedError(found)
        return self

    def _placed(self, error: KeyedError) -> Exception:
        return self._document.error(tuple(error.key.split(".")), error.sentence)


def load_scene(path: Path | str, changes: Mapping[str, Any] | None = None) -> Scene:
    """Read a YAML scene; a `SceneError` names file, line, column and key, and says what would be allowed.

    `changes` are new values at dotted keys, as `Scene.replace` takes them: what they replace need not be valid.
    """
    document = read_document(path)
    stem = re.sub(r"[^A-Za-z0-9._-]+", "_", Path(path).stem).lstrip("._-") or "scene"
    document.data.setdefault("name", stem[:100])
    return _validated(_changed(document, changes or {}), Path(path).parent)


def _changed(document: Document, changes: Mapping[str, Any]) -> Document:
    """Return the document with new values at dotted keys; of two keys that exclude each other the new one stays."""
    values: dict[KeyPath, Any] = {tuple(key.split(".")): plain(value) for key, value in changes.items()}
    changed = document.with_values(values)
    for path in values:
        rival = _RIVALS.get(path)
        if rival is not None and rival not in values:
            changed.data[str(rival[0])].pop(str(rival[1]), None)
    return changed


def _validated(document: Document, folder: Path) -> Scene:
    data = frozen(document.data)
    units: UnitSystem | str | None = None
    if data.get("units") is not None:
        try:
            units = UnitSystem.of(Units.model_validate(data["units"]))
        except ValidationError:
            units = UNITS_UNKNOWN  # the scene says why
    context = {"units": units}
    try:
        scene = Scene.model_validate(data, context=context)
    except ValidationError as error:
        faults = faults_of(error, model=Scene, document=document)
        sound = sound_part(Scene, with_boundary(data), faults, context=context)
        sound._folder = folder
        seen = {fault.path for fault in faults}
        others = [keyed_fault(each) for each in (*disagreements(sound, whole=False), *_lost_files(sound))]
        raise scene_error([*faults, *(each for each in others if each.path not in seen)], document) from None
    scene._document, scene._folder = document, folder
    lost = [keyed_fault(each) for each in _lost_files(scene)]
    if lost or document.faults:
        raise scene_error(lost, document)
    return scene


def _lost_files(scene: Scene) -> list[KeyedError]:
    """Return a fault for each file that the scene names and that is not there."""
    found = scene.files.items()
    return [KeyedError(key, f"there is no file {str(path)!r}") for key, path in found if not _is_file(path)]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long a name; a NUL in it
        return False

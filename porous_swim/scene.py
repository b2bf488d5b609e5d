"""A scene: one run from its YAML file to checked numbers, in a, U and a/U."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ModelWrapValidatorHandler, PrivateAttr, ValidationError, model_validator

from porous_swim.document import Document, KeyPath, frozen, plain, read_document
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.layouts import OPEN_BY_DEFAULT, Layout
from porous_swim.obstacles.reach import check_reach
from porous_swim.parts import UNITS_UNKNOWN, ContactHeight, KeyedError, Part, SeveralKeyedError
from porous_swim.physics.contact import HardContact
from porous_swim.physics.encounter import Encounter
from porous_swim.physics.hydrodynamics import ImageDipole, NearWall, NoHydrodynamics
from porous_swim.physics.noise import Brownian, NoNoise
from porous_swim.physics.perrin import spheroid_diffusion
from porous_swim.scene_checks import disagreements
from porous_swim.scene_errors import faults_of, keyed_fault, scene_error, sound_part
from porous_swim.scene_identity import resolved, save, scene_hash
from porous_swim.scene_limits import check_limits
from porous_swim.scene_warnings import warnings_of
from porous_swim.sections import Population, Record, Run
from porous_swim.streams import Stream, generator
from porous_swim.swarm import Swimmers
from porous_swim.units import Units, UnitSystem
from porous_swim.yaml_core import write_yaml

_RIVALS: dict[KeyPath, KeyPath] = {  # setting one of two keys that exclude each other takes the other away
    ("swimmers", "dipole"): ("swimmers", "dipole_strength"),
    ("swimmers", "dipole_strength"): ("swimmers", "dipole"),
}
_FRAMES = 200  # of a recording whose interval is left open


class Scene(Part):
    """One run. Every random number follows from `run.seed`, but a medium has a seed of its own where one is set."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """What the run is called, and its folder. In a file it may be left out: the name of the file."""
    description: str = ""
    """A sentence for people."""
    units: Units | None = None
    """What a, U and the fluid are in the laboratory."""
    swimmers: Population
    """The swimmers."""
    hydrodynamics: Annotated[NoHydrodynamics | ImageDipole | NearWall, Field(discriminator="kind")] = ImageDipole()
    """The flow that a colloid reflects onto a swimmer."""
    contact: HardContact = HardContact()
    """What happens where a swimmer touches a colloid."""
    noise: Annotated[NoNoise | Brownian, Field(discriminator="kind")] = NoNoise()
    """Random motion of the swimmers."""
    obstacles: Layout
    """The colloids, or a plane wall."""
    domain: Domain = Domain()
    """The space that holds colloids and swimmers."""
    encounter: Encounter = Encounter()
    """What starts and ends an encounter."""
    run: Run
    """How the swimmers are advanced."""
    record: Record = Record()
    """What is kept to look at."""

    _document: Document = PrivateAttr(default_factory=lambda: Document({}))
    _folder: Path = PrivateAttr(default_factory=Path)

    @classmethod
    def from_mapping(cls, data: Mapping[str, Any], *, folder: Path | str = ".") -> Scene:
        """Return the scene that plain data describes; files that it names are relative to `folder`."""
        return _validated(Document({"name": "scene", **plain(data)}), Path(folder))

    def replace(self, changes: Mapping[str, Any]) -> Scene:
        """Return the scene with new values at dotted keys, validated as a file would be.

        A value replaces what stands at its key whole, a map too. Defaults that follow from other keys do so
        again.
        """
        values: dict[KeyPath, Any] = {tuple(key.split(".")): plain(value) for key, value in changes.items()}
        document = self._document.with_values(values)
        for path in values:
            rival = _RIVALS.get(path)
            if rival is not None and rival not in values:
                document.data[str(rival[0])].pop(str(rival[1]), None)
        return _validated(document, self._folder)

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
        """Return a sentence for each thing that is doubtful; without `field` the colloids are placed."""
        return warnings_of(self, field if field is not None else self.place_obstacles())

    @property
    def scene_id(self) -> str:
        """Hash of what decides the result: no names, record, device or threads, but named files."""
        return scene_hash(self)

    @property
    def files(self) -> dict[str, Path]:
        """The files that the scene names, by dotted key."""
        swimmers = getattr(self, "swimmers", None)  # a scene in which something is wrong may lack a section
        parts = {"obstacles": getattr(self, "obstacles", None), "swimmers.release": getattr(swimmers, "release", None)}
        paths = {f"{key}.path": getattr(part, "path", None) for key, part in parts.items()}
        return {key: self._folder / path for key, path in paths.items() if path is not None}

    @property
    def medium_seed(self) -> int:
        """The seed of a random medium: `obstacles.seed`, by default `run.seed`."""
        own: int | None = getattr(self.obstacles, "seed", None)
        return self.run.seed if own is None else own

    @property
    def inputs(self) -> list[Path]:
        """All files that make the scene: its own, unless it came from Python, and those that it names."""
        own = [] if self._document.file is None else [Path(self._document.file)]
        return [*own, *self.files.values()]

    @property
    def n_colloids(self) -> int:
        """Number of colloids, about, before they are placed."""
        return self.obstacles.n_colloids(self.domain, self._folder)

    @property
    def n_steps(self) -> int:
        """Number of steps of the run."""
        return round(self.run.duration / self.run.time_step)

    @property
    def flight_ticks(self) -> int:
        """Number of steps that a swimmer far from every colloid takes at once."""
        return 1 if self.run.flight_step is None else round(self.run.flight_step / self.run.time_step)

    @property
    def record_period(self) -> int:
        """Number of steps between frames of the recording."""
        if self.record.every is None:
            return max(1, self.n_steps // (_FRAMES * self.flight_ticks)) * self.flight_ticks
        return round(self.record.every / self.run.time_step)

    @property
    def n_frames(self) -> int:
        """Number of frames after the first, at equal intervals."""
        return self.n_steps // self.record_period

    @property
    def burn_in_frames(self) -> int:
        """Number of the first frame that statistics of a steady state take in."""
        return -(-round(self.record.burn_in / self.run.time_step) // self.record_period)

    @property
    def n_recorded(self) -> int:
        """Number of swimmers in the recording: the first ones."""
        return min(self.record.swimmers, self.swimmers.count)

    @property
    def n_trails(self) -> int:
        """Number of recorded swimmers that leave a trail."""
        return min(self.record.trails, self.n_recorded)

    @property
    def precision(self) -> str:
        """`f32` or `f64`."""
        if self.run.precision == "auto":
            return "f32" if isinstance(self.noise, Brownian) else "f64"
        return self.run.precision

    @property
    def integrator(self) -> str:
        """`euler`, `reflected` or `located`."""
        if self.run.integrator == "auto":
            if isinstance(self.noise, Brownian):
                return "reflected"
            return "euler" if self.run.precision == "f32" else "located"
        return self.run.integrator

    @property
    def translational_diffusion(self) -> float:
        """D in a U; 0 without noise."""
        return self.noise.translational_diffusion if isinstance(self.noise, Brownian) else 0.0

    @property
    def rotational_diffusion(self) -> float:
        """D_r in U/a; 0 without noise."""
        if not isinstance(self.noise, Brownian):
            return 0.0
        return self.noise.turning(self.swimmers.aspect_ratio, self.domain.dimensions)

    @property
    def bretherton(self) -> float:
        """Gamma = (1 - gamma^2)/(1 + gamma^2), 0 for a sphere."""
        squared = self.swimmers.aspect_ratio**2
        return (1.0 - squared) / (1.0 + squared)

    @property
    def unit_system(self) -> UnitSystem | None:
        """The laboratory values of a and U; None where the scene has no units."""
        return UnitSystem.of(self.units) if self.units is not None else None

    @property
    def length_unit(self) -> str | None:
        """`um` where the scene has units, else None: outputs are then in a alone."""
        return "um" if self.units is not None else None

    @property
    def time_unit(self) -> str | None:
        """`s` where the scene has units, else None: outputs are then in a/U alone."""
        return "s" if self.units is not None else None

    @model_validator(mode="before")
    @classmethod
    def _boundary_follows_the_layout(cls, data: Any) -> Any:
        return _with_boundary(data)

    @model_validator(mode="wrap")
    @classmethod
    def _thermal_noise_is_that_of_the_shape(cls, data: Any, handler: ModelWrapValidatorHandler[Scene]) -> Scene:
        scene = handler(data)
        given = data.get("noise")
        if not isinstance(given, dict) or given.get("translational_diffusion") != "thermal":
            return scene
        mean = spheroid_diffusion(scene.swimmers.aspect_ratio).mean(scene.domain.dimensions)
        noise = scene.noise.model_copy(update={"translational_diffusion": mean * scene.translational_diffusion})
        return scene.model_copy(update={"noise": noise})

    @model_validator(mode="after")
    def _sections_agree(self) -> Scene:
        found = disagreements(self)
        if found:
            raise SeveralKeyedError(found)
        return self

    def _placed(self, error: KeyedError) -> Exception:
        return self._document.error(tuple(error.key.split(".")), error.sentence)


def load_scene(path: Path | str) -> Scene:
    """Read a YAML scene; a `SceneError` names file, line, column and key, and says what would be allowed."""
    document = read_document(path)
    stem = re.sub(r"[^A-Za-z0-9._-]+", "_", Path(path).stem).lstrip("._-") or "scene"
    document.data.setdefault("name", stem[:100])
    return _validated(document, Path(path).parent)


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
        sound = sound_part(Scene, _with_boundary(data), faults, context=context)
        sound._folder = folder
        seen = {fault.path for fault in faults}
        others = [keyed_fault(each) for each in (*disagreements(sound, whole=False), *_lost_files(sound))]
        raise scene_error([*faults, *(each for each in others if each.path not in seen)], document) from None
    scene._document, scene._folder = document, folder
    lost = [keyed_fault(each) for each in _lost_files(scene)]
    if lost or document.faults:
        raise scene_error(lost, document)
    return scene


def _with_boundary(data: Any) -> Any:
    obstacles, domain = (data.get(key, {}) for key in ("obstacles", "domain"))
    if not isinstance(obstacles, dict) or not isinstance(domain, dict) or domain.get("boundary") is not None:
        return data
    boundary = "open" if obstacles.get("layout") in OPEN_BY_DEFAULT else "periodic"
    return {**data, "domain": {**domain, "boundary": boundary}}


def _lost_files(scene: Scene) -> list[KeyedError]:
    """Return a fault for each file that the scene names and that is not there."""
    found = scene.files.items()
    return [KeyedError(key, f"there is no file {str(path)!r}") for key, path in found if not _is_file(path)]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long a name; a NUL in it
        return False

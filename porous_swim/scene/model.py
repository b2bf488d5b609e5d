"""What a scene holds: its sections, and the numbers that follow from them. In a, U and a/U."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, ModelWrapValidatorHandler, PrivateAttr, model_validator

from porous_swim.core.numbers import Given
from porous_swim.core.parts import Part
from porous_swim.core.scales import Scales
from porous_swim.obstacles.domain import Domain
from porous_swim.physics.contact import HardContact
from porous_swim.physics.encounter import Encounter
from porous_swim.physics.hydrodynamics import ImageDipole
from porous_swim.physics.noise import Brownian, NoNoise
from porous_swim.physics.perrin import spheroid_diffusion
from porous_swim.scene.parts import Flow, Layout, parts_of
from porous_swim.scene.sections import Population, Record, Run
from porous_swim.scene.units import Units, UnitSystem

_FRAMES = 200  # of a recording whose interval is left open


class SceneModel(Part):
    """The sections of a scene and what follows from them alone."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """What the run is called, and its folder. In a file it may be left out: the name of the file."""
    description: str = ""
    """A sentence for people."""
    units: Units | None = None
    """What a, U and the fluid are in the laboratory."""
    swimmers: Population
    """The swimmers."""
    hydrodynamics: Flow = ImageDipole()
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

    _folder: Path = PrivateAttr(default_factory=Path)

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
            return "euler" if self.run.precision == "f32" or self._reorients else "located"
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
        return self.given.bretherton

    @property
    def movers(self) -> tuple[Part, ...]:
        """The parts that hand numbers to the kernels."""
        return self.hydrodynamics, self.contact, self.noise, self.encounter, self.swimmers.motility

    @property
    def given(self) -> Given:
        """What the numbers of parts depend on beside their keys."""
        swimmers = self.swimmers
        return Given(
            swimmers.dipole_strength, swimmers.aspect_ratio, self.domain.dimensions, self.run.time_step
        )  # fmt: skip

    @property
    def _reorients(self) -> bool:
        """Whether swimmers turn by themselves; a scene in which something is wrong may lack the section."""
        swimmers = getattr(self, "swimmers", None)
        return swimmers is not None and swimmers.motility.reorients()

    @property
    def unit_system(self) -> UnitSystem | None:
        """The laboratory values of a and U; None where the scene has no units."""
        return UnitSystem.of(self.units) if self.units is not None else None

    @property
    def scales(self) -> Scales | None:
        """What a and a/U are there, for messages; None also where the units are wrong."""
        domain = getattr(self, "domain", None)  # a scene that is wrong in part may lack it
        return None if domain is None else domain.scales

    @model_validator(mode="before")
    @classmethod
    def _boundary_follows_the_layout(cls, data: Any) -> Any:
        return with_boundary(data)

    @model_validator(mode="wrap")
    @classmethod
    def _thermal_noise_is_that_of_the_shape(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        scene = handler(data)
        given = data.get("noise")
        if not isinstance(given, dict) or given.get("translational_diffusion") != "thermal":
            return scene
        mean = spheroid_diffusion(scene.swimmers.aspect_ratio).mean(scene.domain.dimensions)
        noise = scene.noise.model_copy(update={"translational_diffusion": mean * scene.translational_diffusion})
        return scene.model_copy(update={"noise": noise})


def with_boundary(data: Any) -> Any:
    """Return plain data of a scene with the boundary that its layout has by default."""
    obstacles, domain = (data.get(key, {}) for key in ("obstacles", "domain"))
    if not isinstance(obstacles, dict) or not isinstance(domain, dict) or domain.get("boundary") is not None:
        return data
    layout = parts_of(Layout).get(str(obstacles.get("layout")))
    boundary = "open" if layout is not None and layout.OPEN else "periodic"
    return {**data, "domain": {**domain, "boundary": boundary}}

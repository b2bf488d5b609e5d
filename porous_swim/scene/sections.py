"""The sections of a scene that are no part of the physics: swimmers, run and recording."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from porous_swim.core.parts import LEAST_TIME, LONGEST_TIME, UNITS_UNKNOWN, KeyedError, Part, Time, Whole
from porous_swim.observers.part import ObserverPart
from porous_swim.physics.motility import Motility, Steady
from porous_swim.swimmers.base import Release
from porous_swim.swimmers.release import Uniform


class Population(Part):
    """The swimmers: how many, of what kind, and where they start."""

    count: Annotated[Whole, Field(gt=0, lt=2**31)]
    """Number of swimmers; they do not feel each other."""
    dipole_strength: Annotated[float, Field(ge=-1e6, le=1e6)]
    """alpha; above 0 a pusher, below 0 a puller. With units `dipole` may be given instead."""
    dipole: str | None = None
    """Force dipole p in place of `dipole_strength`, such as `0.45 pN um` or `0.42 pN * 1.9 um`:
    alpha = p/(8 pi mu U a^2)."""
    aspect_ratio: Annotated[float, Field(ge=0.01, le=1.0)] = 1.0
    """gamma, minor over major axis; 1 is a sphere."""
    release: Release = Uniform()
    """Where the swimmers start."""
    motility: Motility = Steady()
    """How they swim and turn by themselves."""

    @model_validator(mode="before")
    @classmethod
    def _one_dipole(cls, data: Any, info: ValidationInfo) -> Any:
        """Replace `dipole` by the dipole strength that it means."""
        if not isinstance(data, dict) or data.get("dipole") is None:
            return data
        if "dipole_strength" in data:
            raise KeyedError("dipole", "expected one of dipole and dipole_strength, found both")
        if not isinstance(data["dipole"], str):
            raise KeyedError("dipole", f"expected a string such as `0.45 pN um`, found {data['dipole']!r}")
        units = (info.context or {}).get("units")
        if units == UNITS_UNKNOWN:
            raise PydanticCustomError(UNITS_UNKNOWN, "the units section is wrong")
        if units is None:
            raise KeyedError("dipole", "a dipole needs a `units` section; without one give dipole_strength")
        try:
            strength = units.number(data["dipole"], "dipole")
        except ValueError as error:
            raise KeyedError("dipole", str(error)) from None
        return {key: value for key, value in data.items() if key != "dipole"} | {"dipole_strength": strength}


class Run(Part):
    """How the swimmers are advanced, how long, and on what."""

    time_step: Annotated[Time, Field(ge=LEAST_TIME, le=LONGEST_TIME)]
    """Length of a step. Among colloids at most 1/(2 D), in which noise moves a swimmer by 1, and (but with `located`)
    at most 4 gamma^3/(3 |alpha|), in which the flow at contact changes by itself; results ask for less."""
    flight_step: Annotated[Time, Field(ge=LEAST_TIME, le=LONGEST_TIME)] | None = None
    """Length of the steps of free swimmers that are so far from every colloid that they can neither reach it in such a
    step nor feel its flow change: a whole number of steps, of which `duration` and `record.every` are whole numbers;
    at most 0.017/D_r, in which a swimmer turns little.
    It pays where swimmers are free for long, in dilute fields and around single colloids. For runs with the
    integrator `reflected`. Left out: `time_step`."""
    duration: Annotated[Time, Field(gt=0.0, le=LONGEST_TIME)]
    """Length of the run, a whole number of steps."""
    seed: Annotated[Whole, Field(ge=0, lt=2**64)] = 0
    """Every random number follows from it; those of a random medium follow from `obstacles.seed` where that is set."""
    precision: Literal["auto", "f32", "f64"] = "auto"
    """`auto`: f64 without noise, where small errors grow; f32 with noise. With f32 colloids have a radius of at most
    16777 gamma: heights are then rounded by at most a thousandth of gamma."""
    integrator: Literal["auto", "euler", "reflected", "located"] = "auto"
    """`auto`: reflected with noise, located without (in f32 euler). `euler`: one forward step, then the swimmer is put
    back on the surface if it went below contact. `reflected` (with noise): second order in the drift; walls hold a
    swimmer, and thresholds are passed, as by a continuous path, so that steps may be 20 times as long. `located`
    (without noise, f64): eighth order, step ends and every event located to rounding, so that `time_step` only sets
    the times at which the run can be looked at."""
    device: Literal["auto", "cpu", "cuda", "vulkan", "metal"] = "auto"
    """Where to compute; `auto` takes CUDA or Metal where there is one, else the CPU. It never takes Vulkan, which may
    be a driver in software: name it."""
    threads: Annotated[Whole, Field(ge=1, le=1024)] | None = None
    """Threads on the CPU; left out: as many as this process may use, by its affinity and the quota of its control
    group. No result depends on it."""


class Record(Part):
    """What of the run is kept to look at. Encounters are always kept, of all swimmers."""

    every: Annotated[Time, Field(gt=0.0, le=LONGEST_TIME)] | None = None
    """Time between frames, a whole number of steps, at most `run.duration`. Left out: about 200 frames."""
    burn_in: Annotated[Time, Field(ge=0.0, le=LONGEST_TIME)] = 0.0
    """Time at the start of the run, a whole number of steps below `run.duration`, that statistics of a steady state
    leave out: displacements and directors over lags, the diffusivity, fractions of time, rates and densities. Set it
    to the time in which swimmers forget how they were released. Tables and statistics of single encounters and hops
    keep all."""
    swimmers: Annotated[Whole, Field(ge=0, lt=2**31)] = 200
    """How many swimmers are in the recording and in the trajectory: the first ones, at most all."""
    trails: Annotated[Whole, Field(ge=0, lt=2**31)] = 20
    """How many of these leave a trail, at most `swimmers`."""
    observers: tuple[ObserverPart, ...] = ()
    """Observers of installed packages, a map with a `kind` each; see `porous_swim.ObserverPart`."""

    @model_validator(mode="after")
    def _trails_are_recorded(self) -> Record:
        if "trails" in self.model_fields_set and self.trails > self.swimmers:
            raise KeyedError("trails", f"expected at most record.swimmers ({self.swimmers}), found {self.trails}")
        return self

"""The checks of `porous_swim.testing` find the faults that they are for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pytest
import taichi as ti
from pydantic import Field

import porous_swim as ps
from porous_swim.analysis.estimates import Estimate
from porous_swim.core.parts import Radius
from porous_swim.core.registry import OpenPart, forget
from porous_swim.obstacles.field import ObstacleField
from porous_swim.swimmers.placement import Swimmers
from porous_swim.testing import (
    check_coverage,
    check_flow,
    check_layout,
    check_motility,
    check_observer,
    check_release,
    check_statistic,
)
from tests.analysis.test_columns import tables
from tests.support.motions import Swirl


@contextmanager
def registered(part: type[OpenPart]) -> Iterator[None]:
    ps.register(part)
    try:
        yield
    finally:
        forget(part)


class Sound(ps.Layout):
    """Two colloids that touch."""

    OPEN = True

    layout: Literal["faulty"]
    radius: Radius
    """Radius of both."""

    def n_colloids(self, domain: Any, folder: Path) -> int:
        return 2

    def place(self, domain: Any, rng: np.random.Generator, folder: Path) -> ObstacleField:
        x = self._place(rng)
        return ObstacleField.of_spheres(
            np.array([[-x, 0, 0], [x, 0, 0]]), np.full(2, self.radius), np.zeros(3), domain.dimensions
        )

    def _place(self, rng: np.random.Generator) -> float:
        return self.radius


class Restless(Sound):
    """Its colloids are elsewhere each time."""

    def _place(self, rng: np.random.Generator) -> float:
        return self.radius * (1.0 + np.random.default_rng().random())


class Overlapping(Sound):
    """Its colloids overlap."""

    def _place(self, rng: np.random.Generator) -> float:
        return 0.9 * self.radius


class Miscounted(Sound):
    """It says another number of colloids than it places."""

    def n_colloids(self, domain: Any, folder: Path) -> int:
        return 5


class Unbounded(Sound):
    """One of its numbers may be anything."""

    extra: float = 1.0
    """A number."""


class Undescribed(Sound):
    """One of its keys has no row in the reference."""

    extra: Annotated[float, Field(gt=0.0)] = 1.0


class Crashing(Sound):
    """In two dimensions it fails with an error that is no SceneError."""

    def place(self, domain: Any, rng: np.random.Generator, folder: Path) -> ObstacleField:
        return super().place(domain, rng, folder) if domain.dimensions == 3 else {}[2]


def test_a_sound_layout_passes() -> None:
    with registered(Sound):
        check_layout({"layout": "faulty", "radius": 2.0})


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (Restless, "the same seed places other colloids"),
        (Overlapping, "colloids overlap by 0.1 of their summed radii"),
        (Miscounted, "n_colloids says 5 of 2 colloids"),
        (Unbounded, "Unbounded.extra: a number without bounds"),
        (Undescribed, "Undescribed.extra: it has no docstring"),
    ],
)
def test_a_faulty_layout_is_found(part: type[ps.Layout], message: str) -> None:
    with registered(part), pytest.raises(AssertionError, match=message):
        check_layout({"layout": "faulty", "radius": 2.0})


def test_a_layout_that_crashes_in_another_domain_is_found() -> None:
    with registered(Crashing), pytest.raises(KeyError):
        check_layout({"layout": "faulty", "radius": 2.0})


class Inside(ps.Release):
    """It starts swimmers in the middle of the box, whatever is there."""

    kind: Literal["faulty"]

    def place(self, field: ObstacleField, count: int, rng: Any, contact_height: Any, **folder: Any) -> Swimmers:
        return Swimmers(np.full((count, 3), 10.0), np.tile([1.0, 0.0, 0.0], (count, 1)))


class Long(Inside):
    """Its directors are too long."""

    def place(self, field: ObstacleField, count: int, rng: Any, contact_height: Any, **folder: Any) -> Swimmers:
        return Swimmers(np.zeros((count, 3)), np.tile([1.0, 0.001, 0.0], (count, 1)))


@pytest.mark.parametrize(("part", "message"), [(Inside, "swimmer 0 is 4 below contact"), (Long, "a director has the")])
def test_a_faulty_release_is_found(part: type[ps.Release], message: str) -> None:
    with registered(part), pytest.raises(AssertionError, match=message):
        check_release({"kind": "faulty"})


def flow_of(drift_of: Callable[..., Any]) -> type[ps.Flow]:
    class Faulty(ps.Flow):
        """A flow that breaks a rule."""

        kind: Literal["faulty"]

        @staticmethod
        @cache
        def make_drift(model: Any) -> Any:
            return drift_of(model.real)

    return Faulty


def uneven(real: Any) -> Any:
    @ti.func
    def drift(x, e, A, law):
        alpha, rho = law.alpha, x.dot(x)
        return x * (alpha * alpha / (rho * rho)), e * real(0.0)

    return drift


def leaning(real: Any) -> Any:
    @ti.func
    def drift(x, e, A, law):
        alpha, rho = law.alpha, x.dot(x)
        velocity = x * (alpha / (rho * rho))
        velocity[2] = velocity[2] * real(0.5)
        return velocity, e * real(0.0)

    return drift


def stretching(real: Any) -> Any:
    @ti.func
    def drift(x, e, A, law):
        return x * real(0.0), e * (law.alpha / x.dot(x))

    return drift


def spreading(real: Any) -> Any:
    @ti.func
    def drift(x, e, A, law):
        return x * (law.alpha / x.dot(x)), e * real(0.0)

    return drift


@pytest.mark.parametrize(
    ("drift_of", "message"),
    [
        (uneven, "the flow is not odd in the dipole strength"),
        (leaning, "the velocity of turned swimmers is"),
        (stretching, "along the director, where it is to be across"),
        (spreading, "flights rely on at most"),
    ],
)
def test_a_faulty_flow_is_found(drift_of: Callable[..., Any], message: str) -> None:
    with registered(flow_of(drift_of)), pytest.raises(AssertionError, match=message):
        check_flow("faulty")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axis": (0.0, 0.0, 1.0)}, "there is a flow without a dipole"),
        ({"flows_alone": True}, "the velocity of turned swimmers is"),
        ({"flows_alone": True, "axis": (0.0, 0.0, 1.0)}, None),
    ],
)
def test_a_swirl_passes_as_a_flow_of_its_own_around_an_axis(options: dict[str, Any], message: str | None) -> None:
    with registered(Swirl):
        check = partial(check_flow, "swirl", keys={"strength": 0.3, "power": 2.0}, **options)
        if message is None:
            check()
        else:
            with pytest.raises(AssertionError, match=message):
                check()


def motility_of(turned: Callable[..., Any]) -> type[ps.Motility]:
    class Faulty(ps.Motility):
        """A motility that breaks a rule."""

        kind: Literal["faulty"]

        @staticmethod
        @cache
        def make_reorient(model: Any) -> Any:
            return turned(model.real)

    return Faulty


def growing(real: Any) -> Any:
    @ti.func
    def reorient(e, law, at):
        return e * real(1.001)

    return reorient


def test_a_motility_whose_directors_grow_is_found() -> None:
    with registered(motility_of(growing)), pytest.raises(AssertionError, match="the length of a director is"):
        check_motility({"kind": "faulty"})


class Grasping(ps.Observer):
    """It moves swimmers to the origin, for all who look after it."""

    def __init__(self, schedule: Any) -> None:
        self.schedule = schedule

    def observe(self, frame: Any) -> None:
        frame.position[:] = 0.0


class Forgetful(ps.Observer):
    """It counts frames, and tells of none in its state."""

    def __init__(self, schedule: Any) -> None:
        self.schedule, self.n = schedule, 0

    def observe(self, frame: Any) -> None:
        self.n += 1

    def state(self) -> dict[str, np.ndarray]:
        return {"n": np.array(self.n)}


def test_an_observer_that_writes_into_frames_is_found() -> None:
    with pytest.raises(ValueError, match="read-only"):
        check_observer(Grasping)


def test_an_observer_that_forgets_what_it_saw_before_a_cut_is_found() -> None:
    with pytest.raises(AssertionError, match="Forgetful: taken up half way"):
        check_observer(Forgetful)


def test_a_statistic_that_depends_on_numbers_of_swimmers_is_found() -> None:
    def weighted(encounters: Any) -> float:
        """Sum of the ends of encounters, weighted with the number of the swimmer."""
        return float(np.sum(encounters["swimmer"].to_numpy() * encounters["end_time"].to_numpy()))

    with pytest.raises(AssertionError, match="weighted: it depends on how swimmers are numbered"):
        check_statistic(weighted, {"encounters": tables()["encounters"]})


def test_a_statistic_without_its_error_is_found() -> None:
    def lone(encounters: Any) -> Estimate:
        """Give a value of ten samples, and no error."""
        return Estimate(1.0, np.nan, 10, 0, "a")

    with pytest.raises(AssertionError, match="lone: it: 1 of 10 samples has the error nan"):
        check_statistic(lone, {"encounters": tables()["encounters"]})


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_intervals_that_are_too_short_are_found(share: float) -> None:
    def mean(data: np.ndarray) -> Estimate:
        return Estimate(data.mean(), share * data.std(ddof=1) / np.sqrt(len(data)), len(data), 0, "")

    options: dict[str, Any] = dict(draw=lambda rng: rng.normal(3.0, 2.0, 20), truth=3.0, n_samples=20)
    if share == 1.0:
        check_coverage(mean, **options)  # Student's interval is exact here
    else:
        with pytest.raises(AssertionError, match=r"mean: intervals of 0\.95 cover the truth in 0\.[67]"):
            check_coverage(mean, **options)

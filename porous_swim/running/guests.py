"""A user's observers: told of their run before it begins, asked when they look next, and named where they fail."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from porous_swim.core.errors import RunError
from porous_swim.observers.base import Observer, RunView
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.identity import portable
from porous_swim.scene.scene import Scene


def view_of(scene: Scene, placed: ObstacleField) -> RunView:
    """What observers are told of the run of a scene."""
    return RunView(
        scene=portable(scene), field=placed, time_step=scene.run.time_step, n_steps=scene.n_steps,
        record_period=scene.record_period, flight_ticks=scene.flight_ticks, n_swimmers=scene.swimmers.count,
        n_recorded=scene.n_recorded,
    )  # fmt: skip


def observers_of(scene: Scene) -> list[Observer]:
    """New observers of those kinds that the scene names; RunError where one cannot be made."""
    made = []
    for part in scene.record.observers:
        try:
            made.append(part.make())
        except Exception as error:
            raise RunError(f"record.observers: {part.kind} cannot be made: {type(error).__name__}: {error}") from error
    return made


def introduce(observers: Sequence[Observer], scene: Scene, placed: ObstacleField) -> None:
    """Tell a user's observers of their run, before it costs anything.

    Raises:
        TypeError: one of them is no `Observer`.
        RunError: one of them raises an exception, or wants to look where nobody can.
    """
    view = view_of(scene, placed)
    for observer in observers:
        if not isinstance(observer, Observer):
            found = f"an object of type {type(observer).__name__}"
            if isinstance(observer, type):
                found = f"the class {observer.__name__} itself: write {observer.__name__}()"
            raise TypeError(f"observers: expected objects of subclasses of porous_swim.Observer, found {found}")
        with blaming(observer, "in initialise"):
            observer.initialise(view)
        due_after(observer, 0, scene)
        if observer.n_seen is not None and not 0 <= observer.n_seen <= view.n_swimmers:
            raise RunError(
                f"observer {name_of(observer)}: n_seen: expected 0 to {view.n_swimmers} swimmers, "
                f"found {observer.n_seen}"
            )


@contextmanager
def blaming(observer: Observer, where: str) -> Iterator[None]:
    """Turn an exception of an observer into a RunError that names it and says `where` it failed."""
    try:
        yield
    except Exception as error:
        what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise RunError(f"observer {name_of(observer)} failed {where}: {what}") from error


def name_of(observer: Observer) -> str:
    """What messages call it."""
    return type(observer).__qualname__


def due_after(observer: Observer, step: int, scene: Scene) -> int:
    """The first step after `step` at which an observer looks; RunError where there is none such."""
    with blaming(observer, "in due"):
        answer = observer.due(step)
        wanted = (step // scene.record_period + 1) * scene.record_period if answer is None else operator.index(answer)
    if wanted <= step:
        raise RunError(f"observer {name_of(observer)}: due({step}) returned {wanted}: expected a step after {step}")
    ticks = scene.flight_ticks
    if wanted % ticks and wanted < scene.n_steps:
        raise RunError(
            f"observer {name_of(observer)}: due({step}) returned {wanted}, but with run.flight_step all swimmers stand "
            f"at the same step only every {ticks} steps: expected a multiple of {ticks}"
        )
    return wanted


def plain(value: object) -> np.ndarray:
    """An array that can be stored without Python objects."""
    array = np.asarray(value)
    if array.dtype.hasobject:
        raise TypeError("expected arrays of numbers, booleans or text, found one of Python objects")
    return array

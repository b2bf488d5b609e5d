"""What an observer is told of a run, what it sees, and when it looks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from porous_swim.core.state import State
from porous_swim.engine.kernel.ensemble_sums import Groups
from porous_swim.obstacles.field import ObstacleField

FREE, BOUND, CONTACT = 0, 1, 2  # states of a swimmer: in no encounter; above the contact band; in contact


class Schedule(Protocol):
    """When an observer looks: a function of the step alone, so that a run that is resumed keeps to it."""

    def next_step(self, step: int) -> int:
        """The first scheduled step after `step`."""


@dataclass(frozen=True)
class Every:
    """The steps that are multiples of `period`."""

    period: int

    def __post_init__(self) -> None:
        if self.period < 1:
            raise ValueError(f"period: expected at least 1 step, found {self.period}")

    def next_step(self, step: int) -> int:
        """The first scheduled step after `step`."""
        return (step // self.period + 1) * self.period


@dataclass(frozen=True)
class Counts:
    """How often each event has happened since the start, over all swimmers."""

    n_captures: int
    n_escapes: int
    n_hops: int
    n_returns: int


@dataclass(frozen=True)
class Ensemble:
    """All swimmers of a run together."""

    n_swimmers: int
    fraction_bound: float  # in an encounter, in contact or not
    fraction_contact: float
    msd: float  # a^2, mean squared displacement from the start
    msd_standard_error: float  # over swimmers; NaN for a single one
    windows: Sequence[tuple[int, Groups]] = ()  # since earlier frames of the record: lags in frames, sums over groups


@dataclass(frozen=True)
class Frame:
    """A run at one step: the first n swimmers one by one, and all of them together.

    Lengths in a, times in a/U. In a run all observers share the arrays, which are read-only.
    """

    step: int
    time: float  # a/U
    position: np.ndarray  # (n, 3) float64, a, unwrapped, of the first n swimmers
    director: np.ndarray  # (n, 3) float64, unit
    colloid: np.ndarray  # (n,) int32, the nearest; -1 where the field is empty
    image: np.ndarray  # (n, 3) int32, periodic image of that colloid
    state: np.ndarray  # (n,) uint8: FREE 0, BOUND 1 or CONTACT 2
    ensemble: Ensemble
    has_colloids: bool
    counts: Counts
    # Of all swimmers; what ended did so since the last frame that told of events. Empty where `has_events` is not set.
    residence: np.ndarray  # (n_ended,) float64, a/U: lengths of the encounters that ended
    winding: np.ndarray  # (n_ended,) float64, turns: of those encounters
    under_way: np.ndarray  # (n_bound,) float64, a/U: how long the encounters under way have lasted
    hop_time: np.ndarray  # (n_hops,) float64, a/U: lengths of the flights (hops) that ended
    hops: np.ndarray  # (n_hops, 2, 4) int32, of the same: colloid and periodic image, that left and that entered
    has_events: bool = True

    def first(self, n: int) -> Frame:
        """The same of the first `n` swimmers."""
        names = ("position", "director", "colloid", "image", "state")
        return replace(self, **{name: getattr(self, name)[:n] for name in names})


@dataclass(frozen=True, eq=False)
class RunView:
    """What an observer is told of a run before its first step. Lengths in a, times in a/U."""

    scene: Mapping[str, Any]  # what runs, as in `Results.scene`: plain data, all defaults filled in
    field: ObstacleField  # the colloids: `centers` (n, 3), `radii` (n,), `box` (3,), 0 along axes without a period
    time_step: float  # a/U
    n_steps: int  # of the whole run
    record_period: int  # steps between two frames of the record, `record.every`
    flight_ticks: int  # a step at which an observer looks is a multiple of this; 1 without `run.flight_step`
    n_swimmers: int
    n_recorded: int  # `record.swimmers`: those that the trajectory and the recording show


class Observer:
    """Looks at a run at steps of its own choice, and never changes it. Subclass it and pass it to `run`.

    A run calls `initialise` once before its first step, `observe` at step 0, at each step that is due, and at the last
    one, and `finish` once when it is over. An observer changes no result of a run. Where it raises an exception in
    `observe`, the run ends as failed and keeps what was seen until then; the message names the observer.

    >>> import porous_swim as ps
    >>> class MeanHeading(ps.Observer):
    ...     schedule = ps.Every(250)  # steps
    ...     def initialise(self, run):
    ...         self.n_seen, self.rows = run.n_swimmers, []
    ...     def observe(self, frame):
    ...         self.rows.append((frame.time, frame.director.mean(axis=0)))
    >>> scene = ps.Scene.from_mapping({
    ...     "swimmers": {"count": 20, "dipole_strength": 0.8},
    ...     "noise": {"kind": "brownian", "translational_diffusion": 0.006},
    ...     "obstacles": {"layout": "hexagonal", "radius": 3.5, "spacing": 10.0, "cells": [2, 1]},
    ...     "domain": {"dimensions": 2},
    ...     "run": {"time_step": 0.001, "duration": 1, "seed": 1},
    ... })
    >>> heading = MeanHeading()
    >>> results = ps.run(scene, observers=[heading])
    >>> [time for time, director in heading.rows]
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """

    schedule: Schedule | None = None
    """When it looks; None: at the frames of the record, `record.every`. See `due`."""

    n_seen: int | None = None
    """Its frames show so many swimmers, counted from the first; None: as many as the scene records."""

    wants_events: bool = False
    """Whether its frames tell of encounters and hops: `Frame.residence` and those that follow it."""

    def initialise(self, run: RunView) -> None:
        """Get ready; `schedule`, `n_seen` and `wants_events` may still be set here, from what `run` tells."""

    def due(self, step: int) -> int | None:
        """The first step after `step` at which it wants to look; None: the next frame of the record.

        A function of `step` alone. With `run.flight_step` it returns multiples of `RunView.flight_ticks`: only there
        do all swimmers stand at the same step. Steps behind the end of the run never come.
        """
        return None if self.schedule is None else self.schedule.next_step(step)

    @property
    def events_due(self) -> bool:
        """Whether the next frame is to tell of events; those that it does not tell of come with a later one."""
        return self.wants_events

    def observe(self, frame: Frame) -> None:
        """Take in one frame; frames come in order of time, each once."""

    def keep(self) -> None:
        """Write what waits to disk: called once a minute, so that a run that is killed leaves it."""

    def finish(self, *, interrupted: bool) -> None:
        """Close what is open. Called once, also after an interrupt or an error, when the results are made."""

    def state(self) -> dict[str, np.ndarray]:
        """What it remembers, as arrays of numbers, booleans or text: see `core.state.Remembers`."""
        return {}

    def restore(self, state: State) -> None:
        """Go on from what `state` of another such observer returned; called after `initialise`."""

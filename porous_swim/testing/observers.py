"""What every observer must do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from porous_swim.observers.base import Every, Frame, Observer
from porous_swim.running.guests import view_of
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene

_PERIOD, _FRAMES = 10, 5


def check_observer(make: Callable[[Every], Observer]) -> None:
    """Require of the observer that `make(schedule)` returns:

    its class is described; it names later steps as due, the same each time; it takes frames of a run that it cannot
    change, and changes none; it can be closed after a run, after an interrupted one, and before it saw a frame; what it
    remembers are arrays, and one that takes them up half way remembers the same in the end.
    """
    simulation = _simulation()
    name = type(make(Every(_PERIOD))).__name__
    assert type(make(Every(_PERIOD))).__doc__, f"{name}: it has no docstring"
    frames = list(_frames(simulation))

    def begun() -> Observer:
        observer = make(Every(_PERIOD))
        observer.initialise(view_of(simulation.scene, simulation.field))
        return observer

    for seen, interrupted in ((frames, False), (frames[:2], True), ([], True)):
        observer = begun()
        for step in (0, 1, _PERIOD - 1, _PERIOD, 10**12):
            due = [observer.due(step) for _ in range(2)]
            assert due[0] is None or due[0] > step, f"{name}: the step after {step} is due at {due[0]}"
            assert due[0] == due[1], f"{name}: its schedule changes by being asked"
        for frame in seen:
            _show(observer, frame, name)
        observer.finish(interrupted=interrupted)
    _check_state(begun, frames, name)


def _show(observer: Observer, frame: Frame, name: str) -> None:
    before = _bytes(frame)
    observer.observe(frame)  # ValueError "read-only" where it writes into the frame
    assert _bytes(frame) == before, f"{name}: it changes a frame, which others see after it"


def _check_state(begun: Callable[[], Observer], frames: list[Frame], name: str) -> None:
    """Require that a run that was cut remembers what the whole one does."""
    whole, first, second = begun(), begun(), begun()
    for frame in frames:
        whole.observe(frame)
    for frame in frames[:2]:
        first.observe(frame)
    second.restore(first.state())
    for frame in frames[2:]:
        second.observe(frame)
    one, other = whole.state(), second.state()
    assert all(isinstance(array, np.ndarray) for array in one.values()), f"{name}: its state is not of arrays"
    same = one.keys() == other.keys() and all(np.array_equal(one[key], other[key]) for key in one)
    assert same, f"{name}: taken up half way, it does not remember what the whole run makes it remember"
    for observer in (whole, first, second):
        observer.finish(interrupted=True)


def _simulation() -> Simulation:
    return Simulation(
        Scene.from_mapping(
            {
                "swimmers": {"count": 20, "dipole_strength": 0.8, "release": {"kind": "parallel", "height": 1.02}},
                "noise": {"kind": "brownian", "translational_diffusion": 0.01},
                "obstacles": {"layout": "single", "radius": 3.0},
                "domain": {"dimensions": 2},
                "run": {"time_step": 0.02, "duration": 0.02 * _PERIOD * _FRAMES, "device": "cpu", "threads": 1},
                "record": {"every": 0.02 * _PERIOD},
            }
        )
    )


def _frames(simulation: Simulation) -> list[Frame]:
    """Return frames of a small run, whose arrays cannot be written."""
    found = [simulation.frame()]
    for _ in range(_FRAMES):
        simulation.advance(_PERIOD)
        found.append(simulation.frame())
    for frame in found:
        for array in _arrays(frame):
            array.flags.writeable = False
    return found


def _arrays(frame: Frame) -> list[np.ndarray]:
    values: list[Any] = [getattr(frame, each.name) for each in fields(frame)]
    return [value for value in values if isinstance(value, np.ndarray)]


def _bytes(frame: Frame) -> list[bytes]:
    return [array.tobytes() for array in _arrays(frame)]

"""What every observer must do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from porous_swim.observers.base import Every, Frame, Observer
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene

_PERIOD, _FRAMES = 10, 5


def check_observer(make: Callable[[Every], Observer]) -> None:
    """Require of the observer that `make(schedule)` returns:

    its class is described; its schedule names later steps, the same each time; it takes frames of a run that it cannot
    change, and changes none; it can be closed after a run, after an interrupted one, and before it saw a frame.
    """
    name = type(make(Every(_PERIOD))).__name__
    assert type(make(Every(_PERIOD))).__doc__, f"{name}: it has no docstring"
    frames = list(_frames())
    for seen, interrupted in ((frames, False), (frames[:2], True), ([], True)):
        observer = make(Every(_PERIOD))
        for step in (0, 1, _PERIOD - 1, _PERIOD, 10**12):
            due = [observer.schedule.next_step(step) for _ in range(2)]
            assert due[0] > step, f"{name}: the step after {step} is due at {due[0]}"
            assert due[0] == due[1], f"{name}: its schedule changes by being asked"
        for frame in seen:
            before = _bytes(frame)
            observer.observe(frame)  # ValueError "read-only" where it writes into the frame
            assert _bytes(frame) == before, f"{name}: it changes a frame, which others see after it"
        observer.finish(interrupted=interrupted)


def _frames() -> list[Frame]:
    """Return frames of a small run, whose arrays cannot be written."""
    simulation = Simulation(
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

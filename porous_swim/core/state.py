"""What carries a run from one frame to the next, as plain arrays: enough to go on with it in another process."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from porous_swim.core.errors import RunError

State = Mapping[str, np.ndarray]


class Remembers(Protocol):
    """A part of a run that can be put back to where it was.

    A new object of the same run, restored, goes on as the old one would have, to the bit.
    """

    def state(self) -> dict[str, np.ndarray]:
        """Arrays of numbers, booleans or text, by name; none of Python objects. Empty where nothing is remembered."""

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such object; RunError where it does not fit this one."""


def state_of(parts: Mapping[str, Remembers]) -> dict[str, np.ndarray]:
    """The states of several parts as one: an array is named `part/array`."""
    return {f"{part}/{name}": array for part, each in parts.items() for name, array in each.state().items()}


def restore_parts(parts: Mapping[str, Remembers], state: State) -> None:
    """Hand each part its own arrays of a state that `state_of` made."""
    for part, each in parts.items():
        each.restore(part_of(state, part))


def part_of(state: State, part: str) -> dict[str, np.ndarray]:
    """The arrays of one part, without its name."""
    start = f"{part}/"
    return {name.removeprefix(start): array for name, array in state.items() if name.startswith(start)}


def fitting(state: State, name: str, like: np.ndarray) -> np.ndarray:
    """The array `name` of a state, which must have the shape and the type of `like`; RunError where it has not."""
    found = state.get(name)
    if found is None or found.shape != like.shape or found.dtype != like.dtype:
        is_there = "nothing" if found is None else f"{found.dtype} {found.shape}"
        raise RunError(f"this state is of another run: expected {name} of {like.dtype} {like.shape}, found {is_there}")
    return found

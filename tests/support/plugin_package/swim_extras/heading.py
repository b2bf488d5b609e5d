"""The mean heading of the swimmers, in a file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

import porous_swim as ps
from porous_swim.core.parts import Whole


class Heading(ps.ObserverPart):
    """An observer that writes time and mean director of the swimmers, a line for each look."""

    kind: Literal["heading"]
    file: str
    """The file that it writes."""
    period: Annotated[Whole, Field(ge=1, le=1_000_000)] = 100
    """Number of steps between two looks."""

    def make(self) -> ps.Observer:
        """Return the observer."""
        return _Heading(self)


class _Heading(ps.Observer):
    def __init__(self, part: Heading) -> None:
        self.schedule, self.file = ps.Every(part.period), part.file
        self.lines: list[str] = []

    def observe(self, frame: ps.Frame) -> None:
        x, y, _ = frame.director.mean(axis=0)
        self.lines.append(f"{frame.time:g} {x:.6f} {y:.6f}\n")

    def finish(self, *, interrupted: bool) -> None:
        with open(self.file, "w", encoding="utf-8") as file:
            file.writelines(self.lines)

"""The page of text that a recording opens with, in Markdown."""

from __future__ import annotations

from dataclasses import dataclass

from porous_swim.core.scales import Scales, shown_in
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.timeline import TimeLine
from porous_swim.obstacles.field import ObstacleField


@dataclass(frozen=True)
class SummaryPage:
    """What a run is, and how far it came."""

    name: str
    description: str
    field: ObstacleField
    n_recorded: int
    timeline: TimeLine
    scales: Scales | None

    def text(self, frame: Frame, *, status: str, results: str | None = None) -> str:
        """The page as of `frame`; `results` are tables in Markdown that replace the page's own counts."""
        parts = [
            f"## {self.name}",
            self.description.strip(),
            status,
            results or self._table(frame),
            self._units(),
        ]
        return "\n\n".join(part for part in parts if part) + "\n"

    def _table(self, frame: Frame) -> str:
        n_swimmers, n_colloids = frame.ensemble.n_swimmers, len(self.field.centers)
        rows = [("swimmers", f"{n_swimmers:,}"), ("of these recorded", f"{self.n_recorded:,}")]
        if n_colloids:
            counts = frame.counts
            rows += [
                ("colloids", f"{n_colloids:,}"),
                ("fraction bound", f"{frame.ensemble.fraction_bound:.3f}"),
                ("fraction in contact", f"{frame.ensemble.fraction_contact:.3f}"),
                ("captures, escapes", f"{counts.n_captures:,}, {counts.n_escapes:,}"),
                ("hops, returns", f"{counts.n_hops:,}, {counts.n_returns:,}"),
            ]
        body = "\n".join(f"| {label} | {value} |" for label, value in rows)
        return f"| at time {self.time(frame.time)} | |\n|---|---:|\n{body}"

    def _units(self) -> str:
        line = f"The time line counts {self.timeline.words}."
        if self.scales is None:
            return f"Lengths in swimmer half-lengths *a*, times in *a/U*. {line}"
        return (
            f"*a* = {self.scales.length:g} µm and *a/U* = {self.scales.time:g} s. {line} "
            "Positions of colloids and swimmers are in *a*."
        )

    def time(self, time: float) -> str:
        """A time, a/U, in words."""
        factor, unit = shown_in("a/U", self.scales)
        return f"{time * factor:g} {unit}"

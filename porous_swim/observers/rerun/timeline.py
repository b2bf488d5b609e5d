"""What a recording runs along: seconds where a scene has units, else steps.

The viewer prints every duration in seconds and minutes. Times in a/U shown so would be read as what they are not; steps
are whole numbers without a unit, and the text says how long one is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

STEP = "step"
SECONDS, SCALED = "time", "time_in_a_over_U"  # the second time line, with units and without
_SHOW_SECONDS = 40.0  # time in which the viewer plays a whole run


@dataclass(frozen=True)
class TimeLine:
    """The two time lines of a recording, steps of `time_step`, a/U, and times; one of them is on show.

    `seconds` is a/U in s; None where that is not known.
    """

    time_step: float
    seconds: float | None

    @property
    def name(self) -> str:
        """The one on show."""
        return STEP if self.seconds is None else SECONDS

    @property
    def of_times(self) -> str:
        """The name of that of times."""
        return SCALED if self.seconds is None else SECONDS

    @property
    def _scale(self) -> float:
        return 1.0 if self.seconds is None else self.seconds

    @property
    def words(self) -> str:
        """What the one on show counts."""
        return f"steps of {self.time_step:g} a/U" if self.seconds is None else "seconds"

    def columns(self, steps: list[int], times: list[float]) -> list[rr.TimeColumn]:
        """Both for rows at `steps` and `times`, a/U."""
        return [
            rr.TimeColumn(STEP, sequence=steps),
            rr.TimeColumn(self.of_times, duration=np.array(times, dtype=float) * self._scale),
        ]

    def set(self, stream: rr.RecordingStream, *, step: int, time: float) -> None:
        """Set both for what is logged next."""
        stream.set_time(STEP, sequence=step)
        stream.set_time(self.of_times, duration=time * self._scale)

    def whole(self, duration: float) -> rr.TimeRange:
        """From the start to `duration`, a/U."""
        absolute = rrb.TimeRangeBoundary.absolute
        if self.seconds is None:
            return rr.TimeRange(start=absolute(seq=0), end=absolute(seq=round(duration / self.time_step)))
        return rr.TimeRange(start=absolute(seconds=0.0), end=absolute(seconds=duration * self.seconds))

    def last(self, length: float | None) -> rrb.VisibleTimeRanges:
        """What is not older than `length`, a/U; all that has been where that is None."""
        relative = rrb.TimeRangeBoundary.cursor_relative
        if length is None:
            start = rrb.TimeRangeBoundary.infinite()
        elif self.seconds is None:
            start = relative(seq=-round(length / self.time_step))
        else:
            start = relative(seconds=-length * self.seconds)
        end = relative(seq=0) if self.seconds is None else relative(seconds=0)
        return rrb.VisibleTimeRanges(timeline=self.name, start=start, end=end)

    def panel(self, duration: float) -> rrb.TimePanel:
        """Collapsed, and playing: trails and counts grow from the start."""
        length = duration / self.time_step if self.seconds is None else duration * self.seconds
        pace = float(f"{max(length, 1e-9) / _SHOW_SECONDS:.1g}")
        return rrb.TimePanel(
            state="collapsed", timeline=self.name, play_state="playing", loop_mode="all",
            fps=pace if self.seconds is None else None, playback_speed=None if self.seconds is None else pace,
        )  # fmt: skip

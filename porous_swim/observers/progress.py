"""How far a run is, on stderr: a bar on a terminal, a line now and then in a log."""

from __future__ import annotations

import sys
import time
from typing import TextIO, cast

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from porous_swim.core.console import Unfailing, tell
from porous_swim.observers.base import Frame, Observer, Schedule

_LINE_SECONDS = 30.0  # between two lines of a log: a day's run writes less than 3000


class Clock(Observer):
    """Observer of progress whose clock starts when it is told to: compiling is no part of a rate."""

    def __init__(self, schedule: Schedule) -> None:
        self.schedule = schedule

    def start(self, *, step: int) -> None:
        """Time counts from here, at `step`."""

    def end(self, *, interrupted: bool) -> None:
        """Time counts no more: the swimmers have arrived."""

    def tabulate(self, share: float) -> None:
        """That `share`, 0 to 1, of the encounters is in their table."""


def make_progress(
    schedule: Schedule, *, n_steps: int, n_swimmers: int, quiet: bool, stream: TextIO | None = None,
    seconds: float | None = None,
) -> Clock:  # fmt: skip
    """The progress that suits `stream` (stderr by default): none, a bar, or lines; `seconds` are those in a/U.

    None where stderr is closed.
    """
    stream = stream or sys.stderr
    if quiet or stream is None:
        return NoProgress(schedule)
    kind = ProgressBar if stream.isatty() else ProgressLines
    return kind(schedule, n_steps=n_steps, n_swimmers=n_swimmers, stream=stream, seconds=seconds)


class NoProgress(Clock):
    """Says nothing."""

    def observe(self, frame: Frame) -> None:
        """Nothing to say."""


class _Rate:
    """Swimmer-steps a second since `start`."""

    def __init__(self, *, n_swimmers: int) -> None:
        self._n_swimmers = n_swimmers
        self.start(step=0)

    def start(self, *, step: int) -> None:
        self._step, self._begin = step, time.monotonic()

    def elapsed(self) -> float:
        return time.monotonic() - self._begin

    def at(self, step: int) -> float:
        return (step - self._step) * self._n_swimmers / max(self.elapsed(), 1e-9)

    def seconds_left(self, step: int, *, n_steps: int) -> float | None:
        done = step - self._step
        return self.elapsed() * (n_steps - step) / done if done > 0 else None


class ProgressLines(Clock):
    """A line at the start of the clock, then at most one in 30 s, and one at the end."""

    def __init__(
        self, schedule: Schedule, *, n_steps: int, n_swimmers: int, stream: TextIO, seconds: float | None = None
    ) -> None:
        super().__init__(schedule)
        self._seconds = seconds
        self._n_steps, self._stream, self._rate = n_steps, stream, _Rate(n_swimmers=n_swimmers)
        self._last_line = time.monotonic()
        self._last: Frame | None = None

    def start(self, *, step: int) -> None:
        """Time counts from here, at `step`."""
        self._rate.start(step=step)
        self._last_line = time.monotonic()

    def observe(self, frame: Frame) -> None:
        """Write a line if the last one is long ago."""
        self._last = frame
        if time.monotonic() - self._last_line >= _LINE_SECONDS:
            self._write(frame, left=self._rate.seconds_left(frame.step, n_steps=self._n_steps))

    def tabulate(self, share: float) -> None:
        """Write a line if the last one is long ago."""
        if time.monotonic() - self._last_line >= _LINE_SECONDS:
            self._last_line = time.monotonic()
            tell(f"{100.0 * share:5.1f} % of the encounters are in their table", self._stream)

    def finish(self, *, interrupted: bool) -> None:
        """Write the last line of a run that came to no end."""
        self.end(interrupted=interrupted)

    def end(self, *, interrupted: bool) -> None:
        """Write the last line, once: a second Ctrl-C may come while the run is being ended."""
        last, self._last = self._last, None
        if last is not None:
            self._write(last, left=None, end=", interrupted" if interrupted else "")

    def _write(self, frame: Frame, *, left: float | None, end: str = "") -> None:
        self._last_line = time.monotonic()
        share = 100.0 * frame.step / max(self._n_steps, 1)
        ahead = "" if left is None else f", {_duration(left)} left"
        line = f"{share:5.1f} %  {_state(self._rate.at(frame.step), frame, self._seconds)}{ahead}{end}"
        tell(line, self._stream)


class ProgressBar(Clock):
    """A bar with rate, fraction bound and time left, on a terminal; gone when the run is over."""

    def __init__(
        self, schedule: Schedule, *, n_steps: int, n_swimmers: int, stream: TextIO, seconds: float | None = None
    ) -> None:
        super().__init__(schedule)
        self._seconds = seconds
        self._rate = _Rate(n_swimmers=n_swimmers)
        columns = (BarColumn(), TaskProgressColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
        self._bar = Bar(
            *columns, console=Console(file=cast(TextIO, Unfailing(stream))), transient=True, refresh_per_second=4
        )
        self._task = self._bar.add_task("compiling", total=n_steps, start=False)
        self._bar.start()

    def start(self, *, step: int) -> None:
        """Time counts from here, at `step`."""
        self._rate.start(step=step)
        self._bar.start_task(self._task)
        self._bar.update(self._task, completed=step, description="running")

    def observe(self, frame: Frame) -> None:
        """Move the bar."""
        if frame.step > 0:
            text = _state(self._rate.at(frame.step), frame, self._seconds)
            self._bar.update(self._task, completed=frame.step, description=text)

    def end(self, *, interrupted: bool) -> None:
        """Begin the bar anew, for what is left to do."""
        self._bar.reset(self._task, total=1.0, description="tables and summary")

    def tabulate(self, share: float) -> None:
        """Move the bar."""
        self._bar.update(self._task, completed=share, description="writing encounters")

    def finish(self, *, interrupted: bool) -> None:
        """Take the bar away."""
        self._bar.stop()


def _state(rate: float, frame: Frame, seconds: float | None) -> str:
    colloids = f", {100.0 * frame.ensemble.fraction_bound:.0f} % bound" if frame.has_colloids else ""
    laboratory = "" if seconds is None else f" ({frame.time * seconds:.4g} s)"
    return f"t = {frame.time:g} a/U{laboratory}, {rate:.2e} swimmer-steps/s{colloids}"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"

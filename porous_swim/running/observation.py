"""Everyone who looks at a run, and the results that they leave."""

from __future__ import annotations

import time
import uuid
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from porous_swim.core.errors import RunError
from porous_swim.core.state import State
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.observers.base import Observer
from porous_swim.observers.progress import Clock
from porous_swim.results.manifest import RECORDING
from porous_swim.results.results import Results
from porous_swim.results.run_folder import RunFolder
from porous_swim.running.audience import Audience, Seat
from porous_swim.running.outcome import Outcome
from porous_swim.running.outputs import TRAJECTORY, Outputs
from porous_swim.running.recorders import Recorders, size_warning
from porous_swim.running.simulation import Simulation

KEEP_SECONDS = 60.0  # what a killed run may lose of its recording and trajectory
NO_LOCKS = "The file system of the run folder has no locks: nothing keeps a second run out of the folder."


class Observers:
    """Shows the frames of a run to all observers and makes its results of what ours saw.

    `guests` are those of a user, who have been introduced: see `guests.introduce`.
    """

    def __init__(
        self, simulation: Simulation, folder: RunFolder | None, watch: Stopwatch, *, progress: bool, recording: bool,
        guests: Sequence[Observer] = (),
    ) -> None:  # fmt: skip
        self._simulation = simulation
        path = None if folder is None else folder.path
        self._outputs = Outputs(folder, say=progress)
        self._recorders = Recorders.of(simulation, path, progress=progress, recording=recording)
        seats = self._recorders.seats()
        seats += [Seat(guest, own=False, name=f"observer{number}") for number, guest in enumerate(guests)]
        self._audience = Audience(simulation, self._outputs, watch, seats)
        run_id = uuid.uuid4().hex if folder is None else folder.run_id
        self._outcome = Outcome(simulation, folder, self._outputs, self._recorders, self._audience, watch, run_id)
        self._warnings = simulation.scene.warnings(simulation.field)
        self._kept, self._ended = time.monotonic(), False
        if folder is not None and not folder.locks:
            self._warnings.append(NO_LOCKS)
        too_large = size_warning(simulation.scene) if self._recorders.recording is not None else None
        self._warnings += [] if too_large is None else [too_large]
        if path is not None:
            self._outputs.spare = {TRAJECTORY: self._recorders.trajectory, RECORDING: self._recorders.recording}

    @property
    def clock(self) -> Clock:
        """That of the progress."""
        return self._recorders.clock

    @property
    def next_step(self) -> int:
        """The step at which the next observer looks."""
        return self._audience.next_step

    def observe(self, *, last: bool = False) -> None:
        """Show the present frame to those who are due, the `last` one to all; to nobody twice."""
        self._audience.look(last=last)

    def keep(self) -> None:
        """Write what waits to disk, once a minute: a run that is killed leaves it."""
        if time.monotonic() - self._kept >= KEEP_SECONDS:
            self._kept = time.monotonic()
            self._audience.keep()

    def finish(self, *, interrupted: bool) -> None:
        """Let everyone close what is open, of a run that leaves no results."""
        self._audience.finish_somehow()
        self._audience.finish(own=True, interrupted=interrupted)

    def results(self, *, rate: float | None, signal: str | None = None) -> Results:
        """Tables, summary and recording of a run that came to its end or was interrupted, by the `signal` of this name.

        RunError where a file could not be written: the others are there, and the summary says which one is not. Where
        an observer of the user fails in `finish`, all results are there.
        """
        simulation, recording = self._simulation, self._recorders.recording
        interrupted = simulation.step < simulation.scene.n_steps
        if recording is not None and RECORDING not in self._outputs.missing and recording.is_behind:
            recording.catch_up(self._audience.catch_up(recording))
        results = self._outcome.results(
            "interrupted" if interrupted else "finished", time=simulation.time, rate=rate, warnings=self._warnings,
            signal=signal,
        )  # fmt: skip
        self._ended = True
        self._outputs.complain()
        try:
            self._audience.finish(own=False, interrupted=interrupted)
        except RunError as error:
            raise RunError(f"{error}; the results of the run are whole") from error.__cause__
        return results

    def rescue(self, error: Exception) -> None:
        """Keep what was seen before a run failed; where even that fails, the run's own error is what matters."""
        self._audience.finish_somehow()
        if self._ended:
            return
        self._ended = True
        seen = max(0, self._audience.seen(self._recorders.series)) * self._simulation.scene.run.time_step
        missing = f"The run failed after time {seen:g} a/U; encounters under way then are missing. ({error})"
        with suppress(Exception):
            self._outcome.results("failed", time=seen, rate=None, warnings=[missing, *self._warnings])

    def state(self) -> dict[str, np.ndarray]:
        """What all observers remember, as arrays: with that of the simulation, a run that can go on from here."""
        return self._audience.state()

    def restore(self, state: State) -> None:
        """Go on from the `state` of the observers of another such run."""
        self._audience.restore(state)

"""Who looks at a run, and when: each observer at its own schedule, with what is new since it looked last."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from porous_swim.core.errors import RunError
from porous_swim.core.state import State, part_of
from porous_swim.core.stopwatch import Stopwatch
from porous_swim.observers.base import Frame, Observer
from porous_swim.running.guests import blaming, due_after, name_of, plain
from porous_swim.running.outputs import Outputs
from porous_swim.running.simulation import Simulation

_EVENTS = ("residence", "winding", "hop_time", "hops")  # of a frame: these add up from one to the next


@dataclass(eq=False)
class Seat:
    """An observer, and what it has seen."""

    observer: Observer
    task: str = "observers"  # what the stopwatch counts its time as
    file: str = ""  # that it writes into the run folder
    own: bool = True  # ours, not a user's
    name: str = ""  # in a state
    next: int = 0  # step at which it looks next
    seen: int = -1  # step at which it looked last
    events: list[dict[str, np.ndarray]] = field(default_factory=list)  # that others were told since
    finished: bool = False

    def state(self) -> dict[str, np.ndarray]:
        """What the observer remembers, what it has seen, and the events that wait for it."""
        own = {f"remembers/{name}": plain(array) for name, array in self.observer.state().items()}
        events = {
            f"events/{name}": np.concatenate([each[name] for each in self.events]) for name in _EVENTS if self.events
        }
        return own | events | {"seen": np.array(self.seen)}


class Audience:
    """All who look at one run."""

    def __init__(self, simulation: Simulation, outputs: Outputs, watch: Stopwatch, seats: Iterable[Seat]) -> None:
        self._simulation, self._outputs, self._watch = simulation, outputs, watch
        self._seats = list(seats)

    @property
    def next_step(self) -> int:
        """The least step at which anyone looks next."""
        return min(seat.next for seat in self._seats)

    def look(self, *, last: bool = False) -> None:
        """Show the present frame to those who are due, and the `last` one to all who have not seen it."""
        simulation = self._simulation
        step, last = simulation.step, last or simulation.step >= simulation.scene.n_steps
        seats = [seat for seat in self._seats if seat.seen < step and (last or seat.next <= step)]
        if not seats:
            return
        with self._watch.timing("statistics"):
            everyone = simulation.everyone()
        with self._watch.timing("recording"):
            wanted = any(seat.observer.events_due for seat in seats)
            wanted |= not any(seat.observer.wants_events for seat in self._seats)  # let them go, if any are kept
            frame = _read_only(simulation.frame(max(map(self._n_seen, seats)), everyone=everyone, events=wanted))
            if frame.has_events:
                self._pass_on(frame)
        for seat in seats:
            seat.seen = step
            with self._watch.timing(seat.task), self._guarding(seat):
                told = frame.has_events and seat.observer.wants_events and seat.observer.events_due
                seat.observer.observe(self._shown(frame, seat, told=told))
            seat.next = due_after(seat.observer, step, simulation.scene)
        self.dismiss_lost()

    def catch_up(self, observer: Observer) -> Frame:
        """The present frame with all the events that an observer has not been told of."""
        seat = next(seat for seat in self._seats if seat.observer is observer)
        frame = self._simulation.frame(self._n_seen(seat))
        self._pass_on(frame)
        return self._shown(frame, seat, told=True)

    def keep(self) -> None:
        """Let everyone write what waits."""
        for seat in self._seats:
            with self._watch.timing(seat.task), self._guarding(seat):
                seat.observer.keep()
        self.dismiss_lost()

    def finish(self, *, own: bool, interrupted: bool) -> None:
        """Let our own observers, or those of a user, close what is open, each once."""
        for seat in self._seats:
            if seat.own is own and not seat.finished:
                seat.finished = True
                with self._watch.timing(seat.task), self._guarding(seat, "in finish"):
                    seat.observer.finish(interrupted=interrupted)

    def finish_somehow(self) -> None:
        """The same of a user's after an error, which is told already."""
        for _ in self._seats:
            with suppress(Exception):
                self.finish(own=False, interrupted=True)

    def dismiss_lost(self) -> None:
        """Show nothing more to those whose file was lost."""
        self._seats = [seat for seat in self._seats if seat.file not in self._outputs.missing]

    def seen(self, observer: Observer) -> int:
        """The step at which an observer looked last; -1 where it never did."""
        return next(seat.seen for seat in self._seats if seat.observer is observer)

    def state(self) -> dict[str, np.ndarray]:
        """What everyone remembers, and what each has seen."""
        arrays: dict[str, np.ndarray] = {}
        for seat in self._seats:
            with self._guarding(seat, "in state"):
                arrays |= {f"{seat.name}/{name}": array for name, array in seat.state().items()}
        self.dismiss_lost()
        return arrays

    def restore(self, state: State) -> None:
        """Go on from the `state` of an audience of the same observers, users' in the same order."""
        for seat in self._seats:
            own = part_of(state, seat.name)
            if "seen" not in own:
                raise RunError(f"this state is of a run with other observers: it lacks {name_of(seat.observer)}")
            with nullcontext() if seat.own else blaming(seat.observer, "in restore"):
                seat.observer.restore(part_of(own, "remembers"))
            events = part_of(own, "events")
            seat.seen, seat.events = int(own["seen"]), [events] if events else []
            seat.next = 0 if seat.seen < 0 else due_after(seat.observer, seat.seen, self._simulation.scene)

    def _n_seen(self, seat: Seat) -> int:
        n = seat.observer.n_seen
        return self._simulation.scene.n_recorded if n is None else n

    def _pass_on(self, frame: Frame) -> None:
        """Keep the events that a frame tells of for each who wants them."""
        for seat in self._seats:
            if seat.observer.wants_events:
                seat.events.append({name: getattr(frame, name) for name in _EVENTS})

    def _shown(self, frame: Frame, seat: Seat, *, told: bool) -> Frame:
        """A frame as one observer sees it."""
        shown = frame.first(self._n_seen(seat))
        if told:
            events: dict[str, Any] = {name: np.concatenate([each[name] for each in seat.events]) for name in _EVENTS}
            seat.events = []
            return _read_only(replace(shown, **events, has_events=True))
        nothing: dict[str, Any] = {name: getattr(frame, name)[:0] for name in (*_EVENTS, "under_way")}
        return replace(shown, **nothing, has_events=False)

    @contextmanager
    def _guarding(self, seat: Seat, where: str | None = None) -> Iterator[None]:
        """A file of ours that fails is lost, and the run goes on; a user's observer that fails is named."""
        where = where or f"at step {self._simulation.step:,} (time {self._simulation.time:g})"
        with self._outputs.optional(seat.file):
            if seat.own:
                yield
            else:
                with blaming(seat.observer, where):
                    yield


def _read_only(frame: Frame) -> Frame:
    """Keep observers from changing what the next one sees."""
    for array in vars(frame).values():
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    return frame
